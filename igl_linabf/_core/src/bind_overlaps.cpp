#include "numpy.hpp"

void bind_overlaps(nb::module_&) {}

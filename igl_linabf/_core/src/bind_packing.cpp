#include "numpy.hpp"

void bind_packing(nb::module_&) {}

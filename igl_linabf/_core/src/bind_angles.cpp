#include "numpy.hpp"

void bind_angles(nb::module_&) {}

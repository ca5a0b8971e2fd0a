#include "numpy.hpp"

void bind_graphs(nb::module_&) {}

#include "numpy.hpp"

void bind_cholesky(nb::module_&) {}

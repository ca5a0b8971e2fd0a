// The Python module, built once for every processor and once for those with AVX2.
#include "numpy.hpp"

#if defined(_MSC_VER) && defined(_M_X64)
#include <intrin.h>
#endif

// Whether this processor has what the build for x86-64-v3 takes.
static bool has_v3() {
#if (defined(__GNUC__) || defined(__clang__)) && defined(__x86_64__)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
#elif defined(_MSC_VER) && defined(_M_X64)
    int leaf1[4], leaf7[4];
    __cpuidex(leaf1, 1, 0);
    __cpuidex(leaf7, 7, 0);
    const bool fma = leaf1[2] & (1 << 12), os = leaf1[2] & (1 << 27);
    const bool avx2 = leaf7[1] & (1 << 5), bmi2 = leaf7[1] & (1 << 8);
    return fma && os && avx2 && bmi2 && (_xgetbv(0) & 6) == 6;
#else
    return false;
#endif
}

NB_MODULE(MODULE, m) {
    m.def("has_v3", &has_v3, "Whether this processor runs the build for x86-64-v3.");
    bind_cholesky(m);
    bind_angles(m);
    bind_graphs(m);
    bind_overlaps(m);
    bind_packing(m);
}

// Detection of the processor features that the build for x86-64-v3 uses.
#pragma once
#include <initializer_list>

#if defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 11 && defined(__x86_64__)
#define KNOWS_X86_64_V3
#elif (defined(__GNUC__) || defined(__clang__)) && defined(__x86_64__)
#include <cpuid.h>
#elif defined(_MSC_VER) && defined(_M_X64)
#include <immintrin.h>
#include <intrin.h>
#endif

// Return true if this processor and the operating system support x86-64-v3 (System V ABI, AMD64 supplement, 3.1.1).
// All features are tested, because hypervisors may mask any feature.
inline bool has_v3() {
#if defined(KNOWS_X86_64_V3)
    return __builtin_cpu_supports("x86-64-v3");
#elif defined(__x86_64__) || (defined(_MSC_VER) && defined(_M_X64))
    struct Registers {
        unsigned a = 0, b = 0, c = 0, d = 0;
    };
    const auto read = [](unsigned leaf) {
        Registers r;
#ifdef _MSC_VER
        int found[4];
        __cpuid(found, int(leaf & 0x80000000));
        if (unsigned(found[0]) < leaf) return r;
        __cpuidex(found, int(leaf), 0);
        r = {unsigned(found[0]), unsigned(found[1]), unsigned(found[2]), unsigned(found[3])};
#else
        __get_cpuid_count(leaf, 0, &r.a, &r.b, &r.c, &r.d);  // r stays 0 if this leaf does not exist
#endif
        return r;
    };
    const auto has = [](unsigned bits, std::initializer_list<int> places) {
        for (const int place : places)
            if (!(bits >> place & 1)) return false;
        return true;
    };
    // SSE3, SSSE3, FMA, CMPXCHG16B, SSE4.1, SSE4.2, MOVBE, POPCNT, OSXSAVE, AVX, F16C; BMI1, AVX2, BMI2; LAHF, LZCNT
    if (!has(read(1).c, {0, 9, 12, 13, 19, 20, 22, 23, 27, 28, 29}) || !has(read(7).b, {3, 5, 8}) ||
        !has(read(0x80000001).c, {0, 5}))
        return false;
#ifdef _MSC_VER
    const unsigned long long saved = _xgetbv(0);
#else
    unsigned saved, high;
    __asm__("xgetbv" : "=a"(saved), "=d"(high) : "c"(0));
#endif
    return (saved & 6) == 6;  // the operating system saves the registers of SSE and AVX
#else
    return false;
#endif
}

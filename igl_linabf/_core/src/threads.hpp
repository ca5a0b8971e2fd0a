// Work that is shared out to threads. The pieces do not depend on how many there are, so neither do the bits.
#pragma once
#include <atomic>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#ifdef __linux__
#include <sched.h>
#endif

#include "arrays.hpp"

constexpr Index DIVIDED_FROM = 250'000;  // numbers: below, threads take longer to begin than they save
constexpr int PIECES = 16;               // of long arrays, for any number of threads
constexpr int MOST_THREADS = 8;          // more share the memory's bandwidth and gain nothing

// How many cores this process is to use: as many as it may, or as OMP_NUM_THREADS says.
inline int cores() {
    if (const char* wanted = std::getenv("OMP_NUM_THREADS"); wanted && std::atoi(wanted) > 0) return std::atoi(wanted);
#ifdef __linux__
    cpu_set_t allowed;
    if (sched_getaffinity(0, sizeof allowed, &allowed) == 0) return CPU_COUNT(&allowed);
#endif
    const int known = int(std::thread::hardware_concurrency());
    return known > 0 ? known : 1;
}

// Call work(k) for each k below `count`, several at a time. The first exception is thrown when all have ended.
template <class Work>
void at_once(Index count, const Work& work) {
    std::atomic<Index> next{0};
    std::exception_ptr error;
    std::mutex one_writes;
    const auto some = [&] {
        for (Index k; (k = next++) < count;) try {
                work(k);
            } catch (...) {
                next = count;
                const std::lock_guard held(one_writes);
                if (!error) error = std::current_exception();
            }
    };
    std::vector<std::thread> others;
    const Index threads = std::min<Index>({cores(), count, MOST_THREADS});
    try {
        for (Index k = 1; k < threads; ++k) others.emplace_back(some);
    } catch (const std::system_error&) {  // the system has no more threads: those that began do it
    }
    some();
    for (auto& other : others) other.join();
    if (error) std::rethrow_exception(error);
}

// Call work(first, last) for the pieces of 0 .. size; one piece where threads would not pay.
template <class Work>
void in_pieces(Index size, const Work& work) {
    if (size < DIVIDED_FROM) return work(Index(0), size);
    at_once(PIECES, [&](Index k) { work(size * k / PIECES, size * (k + 1) / PIECES); });
}

// The sum of work(first, last) over the pieces, added up in their order.
template <class Work>
double sum_of_pieces(Index size, const Work& work) {
    if (size < DIVIDED_FROM) return work(Index(0), size);
    double parts[PIECES], total = 0;
    at_once(PIECES, [&](Index k) { parts[k] = work(size * k / PIECES, size * (k + 1) / PIECES); });
    for (const double part : parts) total += part;
    return total;
}

// Parallel loops. The division into pieces, and therefore the result, does not depend on the number of threads.
#pragma once
#include <atomic>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#ifdef __linux__
#include <sched.h>
#endif

#include "arrays.hpp"

constexpr Index PARALLEL_SIZE = 250'000;  // shorter arrays are processed by a single thread
constexpr int PIECES = 16;                // number of pieces of a long array, for any number of threads
constexpr int MOST_THREADS = 8;           // memory bandwidth limits the gain of more threads

// Return OMP_NUM_THREADS if it is set, otherwise the number of cores available to this process.
inline int count_cores() {
    if (const char* wanted = std::getenv("OMP_NUM_THREADS"); wanted && std::atoi(wanted) > 0) return std::atoi(wanted);
#ifdef __linux__
    cpu_set_t allowed;
    if (sched_getaffinity(0, sizeof allowed, &allowed) == 0) return CPU_COUNT(&allowed);
#endif
    const int known = int(std::thread::hardware_concurrency());
    return known > 0 ? known : 1;
}

// Threads that are joined at the end of their scope, because the destructor of a running thread ends the process.
struct JoiningThreads : std::vector<std::thread> {
    ~JoiningThreads() {
        for (auto& thread : *this) thread.join();
    }
};

// Call work(k) for all k < count in parallel. The first exception is rethrown after all threads have finished.
template <class Work>
void parallel_for(Index count, const Work& work) {
    std::atomic<Index> next{0};
    std::exception_ptr error;
    std::mutex error_mutex;
    const auto run_tasks = [&] {
        for (Index k; (k = next++) < count;) try {
                work(k);
            } catch (...) {
                next = count;
                const std::lock_guard held(error_mutex);
                if (!error) error = std::current_exception();
            }
    };
    {
        const Index threads = std::min<Index>({count_cores(), count, MOST_THREADS});
        JoiningThreads others;
        try {
            if (threads > 1) others.reserve(threads - 1);  // emplace_back can then fail only if a thread cannot start
            for (Index k = 1; k < threads; ++k) others.emplace_back(run_tasks);
        } catch (const std::system_error&) {  // continue with the threads that have been started
        } catch (const std::bad_alloc&) {     // no memory for the stack of another thread
        }
        run_tasks();
    }
    if (error) std::rethrow_exception(error);
}

// Call work(first, last) in parallel for the pieces of the range [0, size), or once if the range is short.
template <class Work>
void parallel_for_pieces(Index size, const Work& work) {
    if (size < PARALLEL_SIZE) return work(Index(0), size);
    parallel_for(PIECES, [&](Index k) { work(size * k / PIECES, size * (k + 1) / PIECES); });
}

// Return the sum of work(first, last) over the pieces of [0, size), added in the order of the pieces.
template <class Work>
double parallel_sum(Index size, const Work& work) {
    if (size < PARALLEL_SIZE) return work(Index(0), size);
    double parts[PIECES], total = 0;
    parallel_for(PIECES, [&](Index k) { parts[k] = work(size * k / PIECES, size * (k + 1) / PIECES); });
    for (const double part : parts) total += part;
    return total;
}

// Vectors of 8 numbers. A processor without vectors of this size works on them in parts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace kasumi {

constexpr std::size_t kLanes = 8;
constexpr int kEight = kLanes;
using Floats = float __attribute__((vector_size(4 * kLanes)));
using Integers = std::int32_t __attribute__((vector_size(4 * kLanes)));

template <class Vector, class Number>
[[gnu::always_inline]] inline Vector loaded(const Number* from) {
  Vector made;
  std::memcpy(&made, from, sizeof made);
  return made;
}

// Runs `work`, by AVX2 where the processor has it: all that it calls and that is defined in its file is compiled for
// both. The numbers are the same, since AVX2 alone fuses no products with sums.
#if defined(__x86_64__) && !defined(__clang__)
template <class Work>
[[gnu::target("avx2"), gnu::flatten, gnu::noinline]] void run_by_avx2(const Work& work) {
  work();
}
template <class Work>
void run_by_widest(const Work& work) {
  if (__builtin_cpu_supports("avx2")) return run_by_avx2(work);
  work();
}
#else
template <class Work>
void run_by_widest(const Work& work) {
  work();
}
#endif

}  // namespace kasumi

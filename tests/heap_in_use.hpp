// What this process has allocated and not freed, drivers included.
#pragma once

#include <malloc.h>

namespace kasumi {

// Means nothing under the address sanitizer, whose allocator it does not ask.
#ifdef __SANITIZE_ADDRESS__
constexpr bool kHeapTells = false;
#else
constexpr bool kHeapTells = true;
#endif

inline double heap_in_use() {
  const auto heap = ::mallinfo2();
  return static_cast<double>(heap.uordblks) + static_cast<double>(heap.hblkhd);
}

}  // namespace kasumi

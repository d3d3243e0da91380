#include "pipeline/lab/photographs/kept_memory.hpp"

#include <malloc.h>

namespace kasumi {

void keep_freed_memory() {
  constexpr int kLargestMap = 32 << 20, kLargestRest = 64 << 20;  // bytes: glibc allows no larger map
  ::mallopt(M_MMAP_THRESHOLD, kLargestMap);
  ::mallopt(M_TRIM_THRESHOLD, kLargestRest);
}

}  // namespace kasumi

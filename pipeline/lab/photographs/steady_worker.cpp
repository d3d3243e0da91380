#include "pipeline/lab/photographs/steady_worker.hpp"

#include <malloc.h>

#include <opencv2/core/utility.hpp>

namespace kasumi {

void prepare_steady_work() {
  constexpr int kLargestMap = 32 << 20, kLargestRest = 64 << 20;  // bytes: glibc allows no larger map
  ::mallopt(M_MMAP_THRESHOLD, kLargestMap);
  ::mallopt(M_TRIM_THRESHOLD, kLargestRest);
  cv::setNumThreads(1);
}

}  // namespace kasumi

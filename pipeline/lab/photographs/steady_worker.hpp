// A process that works through pictures, one after the other.
#pragma once

#include <malloc.h>

#include <opencv2/core/utility.hpp>

namespace kasumi {

// From now on what a picture took stays with the process for the next one: by default the kernel takes the maps of each
// back and clears them again for the next, a sixth of the time of a picture, which takes some 10 MB. And OpenCV works in
// the thread that calls it: its own threads take more time than they save, since there is a worker for each core.
inline void prepare_steady_work() {
  constexpr int kLargestMap = 32 << 20, kLargestRest = 64 << 20;  // bytes: glibc allows no larger map
  ::mallopt(M_MMAP_THRESHOLD, kLargestMap);
  ::mallopt(M_TRIM_THRESHOLD, kLargestRest);
  cv::setNumThreads(1);
}

}  // namespace kasumi

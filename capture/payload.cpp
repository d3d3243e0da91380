#include "capture/payload.hpp"

#include <atomic>

namespace kasumi {

std::uint64_t new_buffer_number() {
  static std::atomic<std::uint64_t> last{0};  // of the process, as file descriptors are
  return ++last;
}

}  // namespace kasumi

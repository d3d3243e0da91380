// The bytes of a frame: memory of ours, or a driver's buffer that goes back to the driver when its last holder lets go.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace kasumi {

// A driver's buffer as a GPU can import it.
struct DmaBuf {
  int fd = -1;               // the payload's own; valid while the payload is held
  std::uint32_t offset = 0;  // of the first plane; further planes follow as in memory
  std::uint64_t buffer = 0;  // the same number only for the same memory as long as the process runs: what caches go by
};

struct Payload {
  std::span<const std::uint8_t> bytes;  // may be empty
  std::optional<DmaBuf> dma_buf;        // of the same bytes, where the driver exports its buffers
  std::shared_ptr<const void> holder;   // keeps the bytes; hold it as long as they are read, and no longer
};

// A number for DmaBuf::buffer that no other memory of this process has had. From any thread.
inline std::uint64_t new_buffer_number() {
  static std::atomic<std::uint64_t> last{0};  // of the process, as file descriptors are
  return ++last;
}

inline Payload payload_of(std::vector<std::uint8_t> bytes) {
  const auto kept = std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes));
  return {*kept, std::nullopt, kept};
}

}  // namespace kasumi

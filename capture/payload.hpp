// The bytes of a frame: own memory, or a driver's buffer that returns to the driver when its last holder releases it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace kasumi {

// A driver's buffer in a form that a GPU can import.
struct DmaBuf {
  int fd = -1;               // the payload's own; valid while the payload is held
  std::uint32_t offset = 0;  // of the first plane; the others follow as in memory
  std::uint64_t buffer = 0;  // unique to this memory for the life of the process, as a key for caches
};

struct Payload {
  std::span<const std::uint8_t> bytes;  // may be empty
  std::optional<DmaBuf> dma_buf;        // the same bytes, if the driver exports its buffers
  std::shared_ptr<const void> holder;   // keeps the bytes valid; release it as soon as they have been read
};

// A number for DmaBuf::buffer never used before in this process. From any thread.
inline std::uint64_t new_buffer_number() {
  static std::atomic<std::uint64_t> last{0};  // process-wide, like file descriptors
  return ++last;
}

inline Payload payload_of(std::vector<std::uint8_t> bytes) {
  const auto kept = std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes));
  return {*kept, std::nullopt, kept};
}

}  // namespace kasumi

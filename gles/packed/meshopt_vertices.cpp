#include "gles/packed/meshopt_vertices.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <vector>

namespace kasumi {

namespace {

constexpr std::size_t kGroup = 16;

// A stream of bytes that ends where its data do.
class Bytes {
 public:
  explicit Bytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  bool has(std::size_t count) const { return count <= bytes_.size() - at_; }
  std::uint8_t next() { return has(1) ? bytes_[at_++] : fault(); }
  std::span<const std::uint8_t> take(std::size_t count) {
    if (!has(count)) {
      fault();
      return {};
    }
    at_ += count;
    return bytes_.subspan(at_ - count, count);
  }
  bool whole() const { return !short_ && at_ == bytes_.size(); }
  bool is_short() const { return short_; }

 private:
  std::uint8_t fault() {
    short_ = true;
    return 0;
  }
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool short_ = false;
};

// 16 deltas of `bits` bits each; all ones: a whole byte follows.
void read_group(Bytes& bytes, int bits, std::uint8_t* deltas) {
  if (bits == 0) {
    std::fill_n(deltas, kGroup, std::uint8_t{0});
    return;
  }
  const auto packed = bytes.take(static_cast<std::size_t>(2 * bits));
  if (packed.empty()) return;
  if (bits == 8) {
    std::ranges::copy(packed, deltas);
    return;
  }
  const int mask = (1 << bits) - 1;
  const std::size_t in_a_byte = static_cast<std::size_t>(8 / bits);
  for (std::size_t i = 0; i < kGroup; ++i) {
    // Single bits stand from the lowest, wider ones from the highest.
    const int place = static_cast<int>(i % in_a_byte) * bits;
    const int value = packed[i / in_a_byte] >> (bits == 1 ? place : 8 - bits - place) & mask;
    deltas[i] = value == mask ? bytes.next() : static_cast<std::uint8_t>(value);
  }
}

// The deltas of one byte of all elements of a block.
void read_column(Bytes& bytes, int control, std::size_t elements, std::uint8_t* deltas) {
  const std::size_t groups = (elements + kGroup - 1) / kGroup;
  if (control == 2) {
    std::fill_n(deltas, groups * kGroup, std::uint8_t{0});
    return;
  }
  if (control == 3) {
    std::ranges::copy(bytes.take(elements), deltas);
    return;
  }
  constexpr std::array<std::array<int, 4>, 2> kBits{{{0, 1, 2, 4}, {1, 2, 4, 8}}};
  const auto header = bytes.take((groups + 3) / 4);
  if (header.empty()) return;
  for (std::size_t g = 0; g < groups && !bytes.is_short(); ++g)
    read_group(bytes, kBits[static_cast<std::size_t>(control)][header[g / 4] >> (g % 4 * 2) & 3], deltas + g * kGroup);
}

std::uint32_t unzigzag(std::uint32_t v) {
  return v >> 1 ^ (0u - (v & 1u));
}

// Four bytes of an element from those of the one before. `channel`: their encoding (0: bytes, 1: pairs, 2: by XOR).
std::uint32_t moved(std::uint32_t before, std::uint32_t delta, std::uint8_t channel) {
  if ((channel & 3) == 2) return before ^ std::rotr(delta, channel >> 4);
  const int width = (channel & 3) == 0 ? 8 : 16;
  const std::uint32_t mask = (1u << width) - 1u;
  std::uint32_t value = 0;
  for (int at = 0; at < 32; at += width) value |= (((before >> at) + unzigzag(delta >> at & mask)) & mask) << at;
  return value;
}

}  // namespace

bool decode_vertices_1(std::span<const std::uint8_t> stream, std::size_t count, std::size_t stride,
                       std::span<std::uint8_t> out) {
  constexpr std::size_t kLeastTail = 24;
  const std::size_t words = stride / 4, tail = stride + words;
  const std::size_t padded = std::max(tail, kLeastTail);
  if (stream.size() < 1 + padded) return false;
  const auto channels = stream.last(words);
  if (std::ranges::any_of(channels, [](std::uint8_t c) { return (c & 3) == 3; })) return false;
  std::array<std::uint32_t, 64> before{};
  std::memcpy(before.data(), stream.data() + stream.size() - tail, stride);
  Bytes bytes(stream.subspan(1, stream.size() - 1 - padded));
  const std::size_t block = std::min<std::size_t>(8192 / stride & ~(kGroup - 1), 256);
  std::vector<std::uint8_t> deltas(stride * 256);
  for (std::size_t first = 0; first < count; first += block) {
    const std::size_t elements = std::min(count - first, block);
    const auto controls = bytes.take(words);
    if (controls.empty()) return false;
    for (std::size_t b = 0; b < stride; ++b)
      read_column(bytes, controls[b / 4] >> (b % 4 * 2) & 3, elements, deltas.data() + b * 256);
    if (bytes.is_short()) return false;
    for (std::size_t e = 0; e < elements; ++e)
      for (std::size_t w = 0; w < words; ++w) {
        const std::uint8_t* at = deltas.data() + w * 4 * 256 + e;
        const std::uint32_t delta =
            at[0] | std::uint32_t{at[256]} << 8 | std::uint32_t{at[512]} << 16 | std::uint32_t{at[768]} << 24;
        before[w] = moved(before[w], delta, channels[w]);
        std::memcpy(out.data() + (first + e) * stride + 4 * w, &before[w], 4);
      }
  }
  return bytes.whole();
}

}  // namespace kasumi

// BasisLZ's bits and Huffman codes (KTX 2.0 specification, appendix "BasisLZ/ETC1S Bitstream").
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace kasumi {

// Bits from the lowest of each byte. Beyond the end there are zeros, and the stream is short.
class BasisBits {
 public:
  explicit BasisBits(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  std::uint32_t next(int count);
  // Numbers in chunks of `count` bits, each with one more that says whether another follows.
  std::uint32_t next_in_chunks(int count);
  // Also called by readers that find an impossible value.
  void fault() { faulty_ = true; }
  bool faulty() const { return faulty_; }

 private:
  std::uint32_t bit() {
    if (at_ / 8 >= bytes_.size()) {
      faulty_ = true;
      return 0;
    }
    const std::uint32_t one = std::uint32_t{bytes_[at_ / 8]} >> at_ % 8 & 1u;
    ++at_;
    return one;
  }
  friend class BasisCode;
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool faulty_ = false;
};

// A canonical Huffman code, as Deflate's (RFC 1951, 3.2.2). Without symbols it is a fault to read by it.
class BasisCode {
 public:
  // The code that stands in the stream, its lengths packed by another.
  explicit BasisCode(BasisBits& bits) { build(lengths_in(bits), bits); }
  std::uint32_t next(BasisBits& bits) const;

 private:
  static constexpr int kLongest = 16;
  explicit BasisCode(std::span<const std::uint8_t> lengths, BasisBits& bits) { build(lengths, bits); }
  static std::vector<std::uint8_t> lengths_in(BasisBits& bits);  // of the codes; empty: damaged, or no symbols
  void build(std::span<const std::uint8_t> lengths, BasisBits& bits);
  std::array<std::uint32_t, kLongest + 1> count_{};  // symbols by the length of their codes
  std::vector<std::uint16_t> symbols_;               // by code
};

}  // namespace kasumi

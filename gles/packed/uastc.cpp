// UASTC is a part of ASTC with 4 x 4 pixels in 16 bytes; "UASTC LDR 4x4 Texture Specification" (Binomial) says how each
// of its modes is laid out, Khronos Data Format Specification 1.3, "ASTC", how end points and weights are meant.
#include <algorithm>
#include <array>

#include "gles/packed/ktx2.hpp"

namespace kasumi {

namespace {

constexpr int kUastcPixels = 16;

struct UastcMode {
  int weight_bits;
  int bits, trits, quints;  // of a number of the end points
  int subsets, planes, channels;
  int hints;  // bits for encoders of GPU textures, skipped here
};
// By number; 8 is one colour for the whole block.
constexpr std::array<UastcMode, 19> kUastcModes{{
    {4, 6, 1, 0, 1, 1, 3, 15}, {2, 8, 0, 0, 1, 1, 3, 15}, {3, 4, 0, 0, 2, 1, 3, 15}, {2, 2, 1, 0, 3, 1, 3, 15},
    {2, 3, 0, 1, 2, 1, 3, 15}, {3, 8, 0, 0, 1, 1, 3, 15}, {2, 5, 0, 1, 1, 2, 3, 15}, {2, 3, 0, 1, 2, 1, 3, 15},
    {0, 8, 0, 0, 1, 1, 4, 0},  {2, 4, 0, 0, 2, 1, 4, 23}, {4, 4, 1, 0, 1, 1, 4, 17}, {2, 4, 1, 0, 1, 2, 4, 17},
    {3, 6, 1, 0, 1, 1, 4, 17}, {1, 8, 0, 0, 1, 2, 4, 23}, {2, 8, 0, 0, 1, 1, 4, 23}, {4, 8, 0, 0, 1, 1, 2, 23},
    {2, 8, 0, 0, 2, 1, 2, 23}, {2, 8, 0, 0, 1, 2, 2, 23}, {5, 5, 0, 0, 1, 1, 3, 15},
}};
constexpr int kUastcSolid = 8, kUastcThreeInTwo = 7, kUastcGreyInTwoPlanes = 17;

// Codes of the modes, from the lowest bit, and how many bits they have.
constexpr std::array<std::array<int, 2>, 19> kUastcCodes{{
    {0x01, 4}, {0x35, 6}, {0x1d, 5}, {0x03, 5}, {0x13, 5}, {0x0b, 5}, {0x1b, 5}, {0x07, 5}, {0x17, 5}, {0x0f, 5},
    {0x02, 3}, {0x00, 2}, {0x06, 3}, {0x1f, 5}, {0x0d, 5}, {0x05, 7}, {0x15, 6}, {0x25, 6}, {0x09, 4},
}};

// Which pixels belong to the second subset (of mode 7 in a table of its own), the first pixel the lowest bit; of three
// subsets two bits each.
constexpr std::array<std::uint32_t, 30> kUastcTwo{0xcccc, 0x8888, 0x1111, 0xecc8, 0x377f, 0xfeec, 0x0137, 0x137f,
                                                  0xc800, 0x0013, 0xfe80, 0x17ff, 0x0017, 0x00ff, 0xfff0, 0x0fff,
                                                  0xff71, 0x8eff, 0x08ce, 0x008c, 0x7310, 0xceff, 0x7331, 0x088c,
                                                  0xceef, 0x6666, 0xf00f, 0x5555, 0x0f0f, 0x36c9};
constexpr std::array<std::uint32_t, 11> kUastcThree{0xa5a50000, 0xaa005555, 0xaa000055, 0x0000aa55,
                                                    0x25252525, 0x94949494, 0x58585858, 0x56560202,
                                                    0x92929292, 0x55aa0055, 0xa05050a0};
constexpr std::array<std::uint32_t, 19> kUastcTwoOfThree{0x00f0, 0x4444, 0x0133, 0xcc80, 0xf0ff, 0x2222, 0xffc8,
                                                         0xccce, 0x3c03, 0x00ee, 0x7700, 0x3003, 0x00ce, 0xff80,
                                                         0x6fff, 0x1333, 0x11ff, 0x136c, 0x00ef};

class UastcBlock {
 public:
  explicit UastcBlock(Ktx2Bytes bytes) : low_(ktx2_number(bytes, 0, 8)), high_(ktx2_number(bytes, 8, 8)) {}
  // Beyond the block there are zeros.
  int next(int count) {
    const std::uint64_t from = at_ >= 128  ? 0
                               : at_ >= 64 ? high_ >> (at_ - 64)
                               : at_ > 0   ? low_ >> at_ | high_ << (64 - at_)
                                           : low_;
    at_ += count;
    return static_cast<int>(from & ((std::uint64_t{1} << count) - 1));
  }

 private:
  std::uint64_t low_, high_;
  int at_ = 0;
};

// To 0 .. 255. high: the trit or quint above the bits.
int unquantised(const UastcMode& mode, int bits, int high) {
  if (mode.trits + mode.quints == 0) {
    if (mode.bits == 4) return bits * 17;
    return mode.bits == 5 ? bits << 3 | bits >> 2 : bits;
  }
  const int upper = bits >> 1;
  int spread = 0, factor = 0;
  if (mode.trits > 0 && mode.bits == 2) {
    factor = 93;
    spread = upper << 8 | upper << 4 | upper << 2 | upper << 1;
  } else if (mode.trits > 0 && mode.bits == 4) {
    factor = 22;
    spread = upper << 6 | upper;
  } else if (mode.trits > 0) {
    factor = 5;
    spread = upper << 4 | upper >> 4;
  } else if (mode.bits == 3) {
    factor = 26;
    spread = upper << 7 | upper << 1 | upper >> 1;
  } else {
    factor = 6;
    spread = upper << 5 | upper >> 3;
  }
  const int mask = (bits & 1) != 0 ? 0x1ff : 0;
  const int value = (high * factor + spread) ^ mask;
  return (mask & 0x80) | value >> 2;
}

using UastcEnds = std::array<int, 18>;

// First all trits or quints, in groups whose last is as short as it can be; then all bits.
UastcEnds read_ends(UastcBlock& block, const UastcMode& mode) {
  constexpr std::array<int, 6> kTritBits{0, 2, 4, 5, 7, 8};
  constexpr std::array<int, 4> kQuintBits{0, 3, 5, 7};
  const int count = 2 * mode.channels * mode.subsets;
  UastcEnds ends{};
  if (mode.trits + mode.quints > 0) {
    const int base = mode.trits > 0 ? 3 : 5, group = mode.trits > 0 ? 5 : 3;
    for (int first = 0; first < count; first += group) {
      const int here = std::min(group, count - first);
      const auto size = static_cast<std::size_t>(here);
      int packed = block.next(mode.trits > 0 ? kTritBits[size] : kQuintBits[size]);
      for (int i = 0; i < here; ++i, packed /= base) ends[static_cast<std::size_t>(first + i)] = packed % base;
    }
  }
  for (int i = 0; i < count; ++i) {
    int& end = ends[static_cast<std::size_t>(i)];
    end = unquantised(mode, block.next(mode.bits), end);
  }
  return ends;
}

// 0 .. 64
int weight_of(int bits, int value) {
  if (bits == 1) return value * 64;
  const int full = (1 << bits) - 1;
  const int six = bits == 2   ? value * 21
                  : bits == 3 ? value * 9
                  : bits == 4 ? value << 2 | value >> 2
                              : value << 1 | value >> 4;
  return six + (value > full / 2 ? 1 : 0);
}

int mode_of(UastcBlock& block) {
  UastcBlock ahead = block;
  const int code = ahead.next(7);
  for (std::size_t m = 0; m < kUastcCodes.size(); ++m)
    if (const auto [bits, count] = kUastcCodes[m]; (code & ((1 << count) - 1)) == bits) {
      block.next(count);
      return static_cast<int>(m);
    }
  return -1;
}

// Empty: no such pattern.
std::optional<std::array<int, kUastcPixels>> subsets_of(UastcBlock& block, int mode, int subsets) {
  std::array<int, kUastcPixels> of{};
  if (subsets == 1) return of;
  const auto pattern = static_cast<std::size_t>(block.next(subsets == 3 ? 4 : 5));
  const std::span<const std::uint32_t> patterns = subsets == 3 ? std::span<const std::uint32_t>(kUastcThree)
                                                  : mode == kUastcThreeInTwo
                                                      ? std::span<const std::uint32_t>(kUastcTwoOfThree)
                                                      : std::span<const std::uint32_t>(kUastcTwo);
  if (pattern >= patterns.size()) return std::nullopt;
  const int bits = subsets == 3 ? 2 : 1;
  for (std::size_t i = 0; i < of.size(); ++i)
    of[i] = static_cast<int>(patterns[pattern] >> static_cast<int>(i) * bits & ((1u << bits) - 1));
  return of;
}

using UastcTexels = std::array<glm::u8vec4, kUastcPixels>;

// False: no such mode or pattern.
bool read_block(Ktx2Bytes bytes, UastcTexels& texels) {
  UastcBlock block(bytes);
  const int number = mode_of(block);
  if (number < 0) return false;
  if (number == kUastcSolid) {
    glm::u8vec4 colour{};
    for (int c = 0; c < 4; ++c) colour[c] = static_cast<std::uint8_t>(block.next(8));
    texels.fill(colour);
    return true;
  }
  const UastcMode& mode = kUastcModes[static_cast<std::size_t>(number)];
  block.next(mode.hints);
  const auto subsets = subsets_of(block, number, mode.subsets);
  if (!subsets) return false;
  // The channel that the second weights are for.
  int apart = mode.planes == 2 ? 3 : -1;
  if (mode.planes == 2 && number != kUastcGreyInTwoPlanes) apart = block.next(2);
  const UastcEnds ends = read_ends(block, mode);
  std::array<bool, 3> seen{};
  for (std::size_t i = 0; i < texels.size(); ++i) {
    const int subset = (*subsets)[i];
    bool& anchored = seen[static_cast<std::size_t>(subset)];
    std::array<int, 2> weights{};
    // The first weight of a subset has no highest bit: it is 0.
    for (int p = 0; p < mode.planes; ++p)
      weights[static_cast<std::size_t>(p)] =
          weight_of(mode.weight_bits, block.next(mode.weight_bits - (anchored ? 0 : 1)));
    anchored = true;
    for (int c = 0; c < 4; ++c) {
      // Two channels: grey and transparency.
      const int channel = mode.channels == 2 ? c / 3 : c;
      if (channel >= mode.channels) {
        texels[i][c] = 255;
        continue;
      }
      const auto at = static_cast<std::size_t>(2 * (subset * mode.channels + channel));
      const int weight = weights[c == apart ? 1 : 0];
      texels[i][c] =
          static_cast<std::uint8_t>((ends[at] * 257 * (64 - weight) + ends[at + 1] * 257 * weight + 32) >> 14);
    }
  }
  return true;
}

}  // namespace

Result<Image<glm::u8vec4>> read_uastc(Ktx2Bytes blocks, int width, int height) {
  constexpr std::size_t kBlock = 16;
  const int columns = (width + 3) / 4, rows = (height + 3) / 4;
  if (blocks.size() / kBlock < static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows))
    return fail(FaultKind::bad_input, "damaged UASTC: {} bytes for {} x {} pixels", blocks.size(), width, height);
  Image<glm::u8vec4> image(width, height);
  UastcTexels texels{};
  std::size_t at = 0;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column, at += kBlock) {
      if (!read_block(blocks.subspan(at, kBlock), texels))
        return fail(FaultKind::bad_input, "damaged UASTC picture (block {} of row {})", column + 1, row + 1);
      for (int y = 4 * row; y < std::min(4 * row + 4, height); ++y)
        for (int x = 4 * column; x < std::min(4 * column + 4, width); ++x)
          image.at(x, y) = texels[static_cast<std::size_t>(y % 4 * 4 + x % 4)];
    }
  return image;
}

}  // namespace kasumi

#include "gles/packed/basis_bits.hpp"

namespace kasumi {

std::uint32_t BasisBits::next(int count) {
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i) value |= bit() << i;
  return value;
}

std::uint32_t BasisBits::next_in_chunks(int count) {
  std::uint32_t value = 0;
  for (int at = 0; at < 32; at += count) {
    value |= next(count) << at;
    if (bit() == 0) return value;
  }
  fault();
  return value;
}

std::vector<std::uint8_t> BasisCode::lengths_in(BasisBits& bits) {
  const auto damaged = [&] {
    bits.fault();
    return std::vector<std::uint8_t>{};
  };
  constexpr std::array<std::uint8_t, 21> kOrder{17, 18, 19, 20, 0,  8, 7,  9, 6,  10, 5,
                                                11, 4,  12, 3,  13, 2, 14, 1, 15, 16};
  const std::uint32_t symbols = bits.next(14);
  if (symbols == 0) return {};
  const std::uint32_t packed = bits.next(5);
  if (packed < 1 || packed > kOrder.size()) return damaged();
  std::array<std::uint8_t, kOrder.size()> small{};
  for (std::size_t i = 0; i < packed; ++i) small[kOrder[i]] = static_cast<std::uint8_t>(bits.next(3));
  const BasisCode code(small, bits);
  std::vector<std::uint8_t> lengths;
  lengths.reserve(symbols);
  while (lengths.size() < symbols && !bits.faulty()) {
    const std::uint32_t symbol = code.next(bits);
    std::size_t run = 1;
    std::uint8_t length = 0;
    if (symbol <= kLongest) {
      length = static_cast<std::uint8_t>(symbol);
    } else if (symbol <= 18) {
      run = symbol == 17 ? 3 + bits.next(3) : 11 + bits.next(7);
    } else {
      run = symbol == 19 ? 3 + bits.next(2) : 7 + bits.next(7);
      if (lengths.empty() || lengths.back() == 0) return damaged();
      length = lengths.back();
    }
    if (run > symbols - lengths.size()) return damaged();
    lengths.insert(lengths.end(), run, length);
  }
  return lengths;
}

void BasisCode::build(std::span<const std::uint8_t> lengths, BasisBits& bits) {
  for (const std::uint8_t length : lengths) ++count_[length];
  count_[0] = 0;
  std::uint32_t left = 1;  // codes that are not taken yet
  std::array<std::uint32_t, kLongest + 2> first{};
  for (std::size_t length = 1; length <= kLongest; ++length) {
    left <<= 1;
    if (count_[length] > left) return bits.fault();
    left -= count_[length];
    first[length + 1] = first[length] + count_[length];
  }
  symbols_.resize(first.back());
  for (std::size_t symbol = 0; symbol < lengths.size(); ++symbol)
    if (lengths[symbol] > 0) symbols_[first[lengths[symbol]]++] = static_cast<std::uint16_t>(symbol);
}

std::uint32_t BasisCode::next(BasisBits& bits) const {
  std::uint32_t code = 0, first = 0, place = 0;
  for (std::size_t length = 1; length <= kLongest; ++length) {
    code |= bits.bit();
    if (code - first < count_[length]) return symbols_[place + code - first];
    place += count_[length];
    first = (first + count_[length]) << 1;
    code <<= 1;
  }
  bits.fault();
  return 0;
}

}  // namespace kasumi

#include "gles/display/kms_edid.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace kasumi {
namespace {

constexpr std::size_t kBlock = 128;
constexpr std::array<std::uint8_t, 8> kHeader{0x00, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x00};
constexpr std::size_t kFirstDescriptor = 54, kDescriptor = 18, kDescriptors = 4;
constexpr std::uint8_t kNameTag = 0xfc;

std::string maker(std::span<const std::uint8_t> edid) {
  const unsigned packed = static_cast<unsigned>(edid[8]) << 8 | edid[9];
  std::string letters;
  for (const int shift : {10, 5, 0}) {
    const unsigned letter = packed >> shift & 31u;
    letters += letter >= 1 && letter <= 26 ? static_cast<char>('A' + letter - 1) : '?';
  }
  return letters;
}

std::string model(std::span<const std::uint8_t> edid) {
  for (std::size_t i = 0; i < kDescriptors; ++i) {
    const auto descriptor = edid.subspan(kFirstDescriptor + i * kDescriptor, kDescriptor);
    if (descriptor[0] != 0 || descriptor[1] != 0 || descriptor[3] != kNameTag) continue;
    std::string name;
    for (const std::uint8_t letter : descriptor.subspan(5)) {
      if (letter == '\n') break;
      name += letter >= 0x20 && letter < 0x7f ? static_cast<char>(letter) : '?';
    }
    name.erase(name.find_last_not_of(' ') + 1);
    if (!name.empty()) return name;
  }
  return fmt::format("{:04x}", static_cast<unsigned>(edid[11]) << 8 | edid[10]);  // its product code
}

}  // namespace

std::string edid_name(std::span<const std::uint8_t> edid) {
  if (edid.size() < kBlock || !std::ranges::equal(edid.first(kHeader.size()), kHeader)) return "";
  return maker(edid) + " " + model(edid);
}

std::uint64_t edid_identity(std::span<const std::uint8_t> edid) {
  if (edid.empty()) return 0;
  std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a
  for (const std::uint8_t byte : edid) hash = (hash ^ byte) * 0x100000001b3u;
  return hash == 0 ? 1 : hash;
}

}  // namespace kasumi

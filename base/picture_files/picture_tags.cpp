#include "base/picture_files/picture_tags.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <string_view>

#include <zlib.h>

namespace kasumi {

namespace {

using TagBytes = std::span<const std::uint8_t>;
constexpr std::size_t kLargestProfile = 4 << 20, kLargestExif = 1 << 20;

bool tag_begins(TagBytes bytes, std::string_view with) {
  return bytes.size() >= with.size() && std::memcmp(bytes.data(), with.data(), with.size()) == 0;
}

// 0 beyond the end.
std::uint32_t tag_number(TagBytes bytes, std::size_t at, int count, bool big_endian) {
  if (at > bytes.size() || bytes.size() - at < static_cast<std::size_t>(count)) return 0;
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i)
    value = value << 8 | bytes[at + static_cast<std::size_t>(big_endian ? i : count - 1 - i)];
  return value;
}

std::vector<std::uint8_t> copied(TagBytes bytes) {
  return {bytes.begin(), bytes.end()};
}

// The first directory of a TIFF: orientation, and a profile where there is one.
void read_directory(TagBytes tiff, PictureTags& tags) {
  const bool big = tag_begins(tiff, "MM");
  if ((!big && !tag_begins(tiff, "II")) || tag_number(tiff, 2, 2, big) != 42) return;
  const std::size_t at = tag_number(tiff, 4, 4, big);
  const auto entries = tag_number(tiff, at, 2, big);
  for (std::uint32_t i = 0; i < entries; ++i) {
    const auto entry = at + 2 + 12 * std::size_t{i};
    if (entry + 12 > tiff.size()) return;
    const auto tag = tag_number(tiff, entry, 2, big), type = tag_number(tiff, entry + 2, 2, big),
               count = tag_number(tiff, entry + 4, 4, big);
    if (tag == 0x0112 && type == 3) {
      const auto orientation = tag_number(tiff, entry + 8, 2, big);
      if (orientation >= 1 && orientation <= 8) tags.orientation = static_cast<int>(orientation);
    }
    const std::size_t from = tag_number(tiff, entry + 8, 4, big);
    if (tag == 34675 && count > 4 && from <= tiff.size() && count <= tiff.size() - from)
      tags.profile = copied(tiff.subspan(from, count));
  }
}

void read_exif(TagBytes exif, PictureTags& tags) {
  if (tag_begins(exif, std::string_view("Exif\0\0", 6))) exif = exif.subspan(6);
  if (exif.size() < 8 || exif.size() > kLargestExif) return;
  tags.exif = copied(exif);
  const auto profile = std::move(tags.profile);
  read_directory(exif, tags);
  tags.profile = profile;
}

PictureTags jpeg_tags(TagBytes file) {
  constexpr std::string_view kExif("Exif\0\0", 6), kProfile("ICC_PROFILE\0", 12);
  PictureTags tags;
  std::map<int, TagBytes> parts;  // of the profile, by number
  for (std::size_t at = 2; at + 4 <= file.size();) {
    if (file[at] != 0xff || file[at + 1] == 0xff) {
      ++at;
      continue;
    }
    const int marker = file[at + 1];
    if (marker == 0xda || marker == 0xd9) break;
    if (marker == 0x00 || marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8)) {
      at += 2;
      continue;
    }
    const std::size_t length = tag_number(file, at + 2, 2, true);
    if (length < 2 || length > file.size() - at - 2) break;
    const auto content = file.subspan(at + 4, length - 2);
    if (marker == 0xe1 && tag_begins(content, kExif) && tags.exif.empty()) read_exif(content, tags);
    if (marker == 0xe2 && tag_begins(content, kProfile) && content.size() > 14)
      parts.emplace(content[12], content.subspan(14));
    at += 2 + length;
  }
  for (const auto& [number, part] : parts) tags.profile.insert(tags.profile.end(), part.begin(), part.end());
  return tags;
}

// Inflated up to the largest profile and one byte more, which shows that it is too long.
std::vector<std::uint8_t> inflated(TagBytes packed) {
  std::vector<std::uint8_t> bytes(kLargestProfile + 1);
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) return {};
  stream.next_in = const_cast<Bytef*>(packed.data());  // zlib only reads from it
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = bytes.data();
  stream.avail_out = static_cast<uInt>(bytes.size());
  const int result = inflate(&stream, Z_FINISH);
  const std::size_t made = stream.total_out;
  inflateEnd(&stream);
  if (result != Z_STREAM_END && made <= kLargestProfile) return {};
  bytes.resize(made);
  return bytes;
}

PictureTags png_tags(TagBytes file) {
  PictureTags tags;
  for (std::size_t at = 8; at + 12 <= file.size();) {
    const std::size_t length = tag_number(file, at, 4, true);
    if (length > file.size() - at - 12) break;
    const auto name = file.subspan(at + 4, 4), content = file.subspan(at + 8, length);
    if (tag_begins(name, "eXIf")) read_exif(content, tags);
    if (tag_begins(name, "iCCP") && tags.profile.empty()) {
      const auto end = std::ranges::find(content.first(std::min<std::size_t>(content.size(), 80)), std::uint8_t{0});
      const auto skipped = static_cast<std::size_t>(end - content.begin()) + 2;
      if (skipped < content.size()) tags.profile = inflated(content.subspan(skipped));
    }
    at += 12 + length;
  }
  return tags;
}

PictureTags webp_tags(TagBytes file) {
  PictureTags tags;
  for (std::size_t at = 12; at + 8 <= file.size();) {
    const std::size_t length = tag_number(file, at + 4, 4, false);
    if (length > file.size() - at - 8) break;
    const auto name = file.subspan(at, 4), content = file.subspan(at + 8, length);
    if (tag_begins(name, "EXIF")) read_exif(content, tags);
    if (tag_begins(name, "ICCP")) tags.profile = copied(content);
    at += 8 + length + length % 2;
  }
  return tags;
}

PictureTags tiff_tags(TagBytes file) {
  PictureTags tags;
  read_directory(file, tags);
  return tags;
}

}  // namespace

Result<PictureTags> picture_tags(const PictureHeader& header, std::span<const std::uint8_t> file) {
  PictureTags tags;
  if (header.format == "JPEG") tags = jpeg_tags(file);
  if (header.format == "PNG") tags = png_tags(file);
  if (header.format == "WebP") tags = webp_tags(file);
  if (header.format == "TIFF") tags = tiff_tags(file);
  if (tags.profile.size() > kLargestProfile)
    return fail(FaultKind::bad_input, "a colour profile of more than {} bytes", kLargestProfile);
  return tags;
}

}  // namespace kasumi

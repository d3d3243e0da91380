#include "base/picture_files/embedded_tags.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <string_view>

#include <zlib.h>

#include "base/picture_files/rare_files.hpp"
#include "base/picture_files/tiff_directory.hpp"

namespace kasumi {

namespace {

using TagBytes = std::span<const std::uint8_t>;
constexpr std::size_t kLargestProfile = 4 << 20, kLargestExif = 1 << 20;

bool tag_begins(TagBytes bytes, std::string_view with) {
  return bytes.size() >= with.size() && std::memcmp(bytes.data(), with.data(), with.size()) == 0;
}

std::vector<std::uint8_t> copied(TagBytes bytes) {
  return {bytes.begin(), bytes.end()};
}

// The first directory of a TIFF: orientation, and a profile where there is one.
std::vector<TiffEntry> read_first_directory(TagBytes tiff, const TiffStart& start, EmbeddedTags& tags) {
  auto entries = read_tiff_directory(tiff, start.directory, start.is_big_endian);
  if (const auto* turned = find_entry(entries, 0x0112)) {
    const auto orientation = first_number(*turned, start.is_big_endian);
    if (orientation >= 1 && orientation <= 8) tags.orientation = static_cast<int>(orientation);
  }
  if (const auto* profile = find_entry(entries, kTiffProfile); profile && profile->count > 4)
    tags.profile = profile->bytes;
  return entries;
}

void read_exif(TagBytes exif, EmbeddedTags& tags) {
  if (tag_begins(exif, std::string_view("Exif\0\0", 6))) exif = exif.subspan(6);
  if (exif.size() < 8 || exif.size() > kLargestExif) return;
  tags.exif = copied(exif);
  EmbeddedTags read;
  if (const auto start = tiff_start(exif)) read_first_directory(exif, *start, read);
  tags.orientation = read.orientation;  // EXIF has no profile
}

EmbeddedTags jpeg_tags(TagBytes file) {
  constexpr std::string_view kExif("Exif\0\0", 6), kProfile("ICC_PROFILE\0", 12);
  EmbeddedTags tags;
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
    const std::size_t length = tiff_number(file, at + 2, 2, true);
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

EmbeddedTags png_tags(TagBytes file) {
  EmbeddedTags tags;
  for (std::size_t at = 8; at + 12 <= file.size();) {
    const std::size_t length = tiff_number(file, at, 4, true);
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

EmbeddedTags webp_tags(TagBytes file) {
  EmbeddedTags tags;
  for (std::size_t at = 12; at + 8 <= file.size();) {
    const std::size_t length = tiff_number(file, at + 4, 4, false);
    if (length > file.size() - at - 8) break;
    const auto name = file.subspan(at, 4), content = file.subspan(at + 8, length);
    if (tag_begins(name, "EXIF")) read_exif(content, tags);
    if (tag_begins(name, "ICCP")) tags.profile = copied(content);
    at += 8 + length + length % 2;
  }
  return tags;
}

EmbeddedTags tiff_tags(TagBytes file) {
  EmbeddedTags tags;
  const auto start = tiff_start(file);
  if (!start) return tags;
  const bool big = start->is_big_endian;
  const auto entries = read_first_directory(file, *start, tags);
  std::vector<std::uint8_t> exif = copied(file.first(8));
  if (auto pointers = copy_exif(file, entries, exif, big); !pointers.empty()) {
    set_first_directory(exif, append_tiff_directory(exif, std::move(pointers), big), big);
    if (exif.size() <= kLargestExif) tags.exif = std::move(exif);
  }
  return tags;
}

}  // namespace

Result<EmbeddedTags> embedded_tags(const PictureHeader& header, std::span<const std::uint8_t> file) {
  EmbeddedTags tags;
  if (header.format == "JPEG") tags = jpeg_tags(file);
  if (header.format == "PNG") tags = png_tags(file);
  if (header.format == "WebP") tags = webp_tags(file);
  if (header.format == "TIFF") tags = tiff_tags(file);
  if (header.format == "HEIF") {
    const auto files = rare_files();
    if (!files) return fail(files.error());
    tags = (*files)->heif_tags(file);
  }
  if (tags.profile.size() > kLargestProfile)
    return fail(FaultKind::bad_input, "a colour profile of more than {} bytes", kLargestProfile);
  return tags;
}

}  // namespace kasumi

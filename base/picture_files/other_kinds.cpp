#include "base/picture_files/other_kinds.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>

#include <fmt/format.h>

#include "base/picture_files/tiff_directory.hpp"
#include "base/picture_header.hpp"

namespace kasumi {

namespace {

struct OtherKind {
  std::size_t at;
  std::string_view begins, name;
};
constexpr OtherKind kOtherKinds[] = {
    {0, "GIF8", "a GIF"},
    {0, "\xff\x0a", "a JPEG XL"},
    {4, "JXL \r\n\x87\n", "a JPEG XL"},
    {4, "jP  \r\n\x87\n", "a JPEG 2000"},
    {0, "\xff\x4f\xff\x51", "a JPEG 2000"},
    {0, "II\xbc", "a JPEG XR"},
    {0, "8BPS", "a Photoshop document"},
    {0, "gimp xcf", "GIMP's own document"},
    {0, "%PDF", "a PDF"},
    {0, "%!PS", "PostScript"},
    {0, "\x1f\x8b", "a file packed by gzip"},
    {4, "ftyp", "a film"},
    {0, "\x1a\x45\xdf\xa3", "a film"},
};

constexpr std::string_view kRaw = "a camera's raw file: expected it developed, as TIFF of 16 bits in sRGB";

bool begins_at(std::span<const std::uint8_t> file, std::size_t at, std::string_view with) {
  return file.size() >= at + with.size() &&
         std::equal(with.begin(), with.end(), file.begin() + static_cast<std::ptrdiff_t>(at),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

// DNG says so; CR2 has "CR" behind its header; others begin with a preview and hold their samples in SubIFDs.
bool is_raw(std::span<const std::uint8_t> file) {
  constexpr std::uint16_t kDngVersion = 50706, kSubfileType = 254, kSubdirectories = 330;
  if (begins_at(file, 0, "FUJIFILMCCD-RAW") || begins_at(file, 4, "ftypcrx ")) return true;
  const auto start = tiff_start(file);
  if (!start) return begins_at(file, 0, "IIRO") || begins_at(file, 0, std::string_view("IIU\0", 4));
  if (begins_at(file, 8, "CR")) return true;
  const auto entries = read_tiff_directory(file, start->directory, start->is_big_endian);
  const auto* kind = find_entry(entries, kSubfileType);
  return find_entry(entries, kDngVersion) != nullptr ||
         (kind && first_number(*kind, start->is_big_endian) % 2 == 1 && find_entry(entries, kSubdirectories));
}

// "<!doctype html" or "<html": what a server answered in place of the picture; "<svg": a drawing.
std::string_view markup(std::span<const std::uint8_t> file) {
  constexpr std::size_t kFirst = 512;
  std::string text(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(std::min(file.size(), kFirst)));
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto first = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  if (first == std::string::npos || text[first] != '<') return {};
  if (text.find("<svg") != std::string::npos) return "an SVG";
  return text.find("html") != std::string::npos ? "a web page, perhaps a server's answer in place of the picture"
                                                : std::string_view();
}

}  // namespace

std::string other_kind(std::span<const std::uint8_t> file) {
  constexpr std::string_view kExpected = "PNG, JPEG, TIFF, WebP, HEIC, PNM or FITS";
  if (file.empty()) return "an empty file";
  if (is_heif(file)) return {};
  if (is_raw(file)) return std::string(kRaw);
  if (begins_at(file, 0, "version https://git-lfs"))
    return "a pointer of Git LFS: expected the picture itself (git lfs pull)";
  auto name = markup(file);
  if (const auto* kind =
          std::ranges::find_if(kOtherKinds, [&](const OtherKind& k) { return begins_at(file, k.at, k.begins); });
      kind != std::end(kOtherKinds))
    name = kind->name;
  return name.empty() ? std::string() : fmt::format("{}: expected {}", name, kExpected);
}

}  // namespace kasumi

#include "base/picture_header.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>

#include "base/fits_header.hpp"

namespace kasumi {

namespace {

using HeaderBytes = std::span<const std::uint8_t>;
enum class ByteOrder { little, big };

bool begins(HeaderBytes file, std::string_view with) {
  return file.size() >= with.size() && std::memcmp(file.data(), with.data(), with.size()) == 0;
}

// 0 beyond the end.
std::uint64_t number(HeaderBytes file, std::uint64_t at, int count, ByteOrder order) {
  if (at > file.size() || file.size() - at < static_cast<std::size_t>(count)) return 0;
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i)
    value = value << 8 | file[at + static_cast<std::size_t>(order == ByteOrder::big ? i : count - 1 - i)];
  return value;
}

std::int64_t signed_number(HeaderBytes file, std::uint64_t at) {
  return static_cast<std::int32_t>(number(file, at, 4, ByteOrder::little));
}

std::optional<PictureHeader> png_header(HeaderBytes file) {
  if (!begins(file, "\x89PNG\r\n\x1a\n") || file.size() < 24) return std::nullopt;
  if (!begins(file.subspan(12), "IHDR")) return std::nullopt;  // it comes first, or the size stands elsewhere
  const auto at = [&](std::size_t place) { return static_cast<std::int64_t>(number(file, place, 4, ByteOrder::big)); };
  return PictureHeader{"PNG", at(16), at(20)};
}

// Those of its thumbnail count, too.
std::int64_t scans_of(HeaderBytes jpeg) {
  constexpr std::string_view kScan = "\xff\xda";  // never stands within a scan
  const std::string_view text(reinterpret_cast<const char*>(jpeg.data()), jpeg.size());
  std::int64_t scans = 0;
  for (auto at = text.find(kScan); at != std::string_view::npos; at = text.find(kScan, at + kScan.size())) ++scans;
  return scans;
}

// Of several scans, those with at least a bit for each block (marker 0xc0 and 0xc1) cost no more than their bytes.
std::optional<PictureHeader> jpeg_header(HeaderBytes file) {
  if (!begins(file, "\xff\xd8")) return std::nullopt;
  for (std::size_t at = 2; at + 9 < file.size();) {
    const std::uint8_t marker = file[at + 1];
    if (file[at] != 0xff || marker == 0x00 || marker == 0xff) {  // decoders skip to the next marker, too
      ++at;
      continue;
    }
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    const auto big = [&](std::size_t place) {
      return static_cast<std::int64_t>(number(file, at + place, 2, ByteOrder::big));
    };
    if (frame) return PictureHeader{"JPEG", big(7), big(5), 0, marker > 0xc1 ? scans_of(file) : 1};
    if (marker == 0xda || marker == 0xd9) return std::nullopt;  // the picture itself, without a frame
    const bool alone = marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8);
    at += 2 + (alone ? 0 : static_cast<std::size_t>(big(2)));
  }
  return std::nullopt;
}

std::optional<PictureHeader> bmp_header(HeaderBytes file) {
  if (!begins(file, "BM") || file.size() < 26) return std::nullopt;
  if (number(file, 14, 4, ByteOrder::little) == 12)
    return PictureHeader{"BMP", static_cast<std::int64_t>(number(file, 18, 2, ByteOrder::little)),
                         static_cast<std::int64_t>(number(file, 20, 2, ByteOrder::little))};
  return PictureHeader{"BMP", signed_number(file, 18), std::abs(signed_number(file, 22))};
}

std::optional<PictureHeader> webp_header(HeaderBytes file) {
  if (!begins(file, "RIFF") || file.size() < 30 || !begins(file.subspan(8), "WEBPVP8")) return std::nullopt;
  const auto at = [&](std::size_t place, int count) {
    return static_cast<std::int64_t>(number(file, place, count, ByteOrder::little));
  };
  if (file[15] == 'X') return PictureHeader{"WebP", at(24, 3) + 1, at(27, 3) + 1};
  if (file[15] == 'L') return PictureHeader{"WebP", (at(21, 4) & 0x3fff) + 1, (at(21, 4) >> 14 & 0x3fff) + 1};
  return PictureHeader{"WebP", at(26, 2) & 0x3fff, at(28, 2) & 0x3fff};
}

std::optional<PictureHeader> exr_header(HeaderBytes file) {
  if (!begins(file, "\x76\x2f\x31\x01")) return std::nullopt;
  const auto text_end = [&](std::size_t from) {
    const auto* end = from < file.size() ? std::memchr(file.data() + from, 0, file.size() - from) : nullptr;
    return end ? static_cast<std::size_t>(static_cast<const std::uint8_t*>(end) - file.data()) : file.size();
  };
  for (std::size_t at = 8; at < file.size();) {  // name, type, length, value
    const auto name_end = text_end(at), type_end = text_end(name_end + 1);
    if (name_end == at || type_end + 5 > file.size()) return std::nullopt;
    const std::string_view name(reinterpret_cast<const char*>(file.data()) + at, name_end - at);
    const auto value = type_end + 5;
    if (name == "dataWindow" && value + 16 <= file.size())
      return PictureHeader{"EXR", signed_number(file, value + 8) - signed_number(file, value) + 1,
                           signed_number(file, value + 12) - signed_number(file, value + 4) + 1};
    at = value + number(file, type_end + 1, 4, ByteOrder::little);
  }
  return std::nullopt;
}

// Its first picture, which is the one that is decoded.
std::optional<PictureHeader> tiff_header(HeaderBytes file) {
  if (!begins(file, "II") && !begins(file, "MM")) return std::nullopt;
  const auto order = begins(file, "II") ? ByteOrder::little : ByteOrder::big;
  const auto version = number(file, 2, 2, order);
  if (version != 42 && version != 43) return std::nullopt;
  const bool big = version == 43;
  const auto directory = big ? number(file, 8, 8, order) : number(file, 4, 4, order);
  const auto entries = number(file, directory, big ? 8 : 2, order);
  const std::uint64_t size = big ? 20 : 12, first = directory + (big ? 8 : 2);
  PictureHeader header{"TIFF"};
  std::int64_t tile_width = 0, tile_height = 0;
  for (std::uint64_t i = 0; i < entries && first + i * size + size <= file.size(); ++i) {
    const auto at = first + i * size;
    const auto type = number(file, at + 2, 2, order);
    const int bytes = type == 3 ? 2 : type == 4 ? 4 : type == 16 ? 8 : 0;
    const auto value = std::min<std::uint64_t>(number(file, at + (big ? 12 : 8), bytes, order), INT32_MAX);
    switch (number(file, at, 2, order)) {
      case 256: header.width = static_cast<std::int64_t>(value); break;
      case 257: header.height = static_cast<std::int64_t>(value); break;
      case 322: tile_width = static_cast<std::int64_t>(value); break;
      case 323: tile_height = static_cast<std::int64_t>(value); break;
    }
  }
  header.tile_pixels = tile_width * tile_height;
  return header;
}

constexpr std::size_t kLongestTextHeader = 1 << 16;

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

// The next word; lines that begin with # between words are comments.
std::string_view next_word(std::string_view& text) {
  for (;;) {
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    if (!text.starts_with('#')) break;
    text.remove_prefix(std::min(text.find('\n'), text.size()));
  }
  const auto end = static_cast<std::size_t>(std::ranges::find_if(text, is_space) - text.begin());
  const auto word = text.substr(0, end);
  text.remove_prefix(end);
  return word;
}

// 0: not a number.
std::int64_t number_of(std::string_view word) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() ? value : 0;
}

std::int64_t next_number(std::string_view& text) {
  return number_of(next_word(text));
}

std::optional<PictureHeader> pam_header(std::string_view text) {
  PictureHeader header{"PNM"};
  next_word(text);
  for (auto word = next_word(text); !word.empty() && word != "ENDHDR"; word = next_word(text)) {
    if (word == "WIDTH") header.width = next_number(text);
    if (word == "HEIGHT") header.height = next_number(text);
  }
  return header;
}

std::optional<PictureHeader> pnm_header(std::string_view text) {
  const bool floats = text.starts_with("PF") || text.starts_with("Pf");
  if (!floats && (text.size() < 2 || text[1] < '1' || text[1] > '6')) return std::nullopt;
  text.remove_prefix(2);
  const auto width = next_number(text);
  return PictureHeader{floats ? "PFM" : "PNM", width, next_number(text)};
}

// Lines, an empty one, then "-Y HEIGHT +X WIDTH".
std::optional<PictureHeader> hdr_header(std::string_view text) {
  const auto blank = text.find("\n\n");
  if (blank == std::string_view::npos) return std::nullopt;
  text.remove_prefix(blank + 2);
  PictureHeader header{"HDR"};
  for (int axis = 0; axis < 2; ++axis) {
    const auto name = next_word(text);
    (name.ends_with('Y') ? header.height : header.width) = next_number(text);
  }
  return header;
}

std::optional<PictureHeader> text_header(HeaderBytes file) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), std::min(file.size(), kLongestTextHeader));
  if (text.starts_with("P7")) return pam_header(text);
  if (text.starts_with("#?")) return hdr_header(text);
  return text.starts_with('P') ? pnm_header(text) : std::nullopt;
}

std::optional<PictureHeader> fits_header(HeaderBytes file) {
  if (!is_fits(file)) return std::nullopt;
  const auto side = [&](const char* keyword) { return number_of(fits_value(file, keyword).value_or("")); };
  return PictureHeader{"FITS", side("NAXIS1"), side("NAXIS2")};
}

// The largest of the sizes that it names (ISO/IEC 23008-12, 6.5.3): others are of tiles and thumbnails.
std::optional<PictureHeader> heif_header(HeaderBytes file) {
  if (!is_heif(file)) return std::nullopt;
  constexpr std::string_view kSize = "ispe";
  constexpr std::size_t kWithinBytes = 1 << 20;  // the box of sizes stands before the samples
  const auto within = file.first(std::min(file.size(), kWithinBytes));
  PictureHeader header{"HEIF"};
  for (auto at = within.begin();; at += kSize.size()) {
    at = std::search(at, within.end(), kSize.begin(), kSize.end());
    const auto place = static_cast<std::size_t>(at - within.begin()) + kSize.size() + 4;  // behind version and flags
    if (place + 8 > within.size()) return header;
    const auto width = static_cast<std::int64_t>(number(file, place, 4, ByteOrder::big)),
               height = static_cast<std::int64_t>(number(file, place + 4, 4, ByteOrder::big));
    if (std::max(width, height) > std::max(header.width, header.height)) header.width = width, header.height = height;
  }
}

}  // namespace

bool is_heif(std::span<const std::uint8_t> file) {
  if (file.size() < 16 || !begins(file.subspan(4), "ftyp")) return false;
  const auto brands = std::min<std::size_t>(number(file, 0, 4, ByteOrder::big), file.size());
  for (std::size_t at = 8; at + 4 <= brands; at += at == 8 ? 8 : 4)  // the first has a version behind it
    for (const auto* brand : {"heic", "heix", "heim", "heis", "mif1", "avif"})
      if (begins(file.subspan(at), brand)) return true;
  return false;
}

std::optional<PictureHeader> picture_header(std::span<const std::uint8_t> file) {
  for (const auto read : {png_header, jpeg_header, tiff_header, exr_header, bmp_header, webp_header, fits_header,
                          heif_header, text_header})
    if (auto header = read(file)) return header;
  return std::nullopt;
}

Result<> check_size(const PictureHeader& header, const PictureLimits& limits) {
  const auto width = header.width, height = header.height;
  const bool sane = width >= 1 && height >= 1 && width <= limits.side_px && height <= limits.side_px;
  if (header.scans > limits.scans)
    return fail(FaultKind::bad_input, "a {} of {} scans: expected {} at most", header.format, header.scans,
                limits.scans);
  if (sane && width * height <= limits.pixels && header.tile_pixels <= limits.pixels) return {};
  if (sane && width * height <= limits.pixels)
    return fail(FaultKind::bad_input, "a {} in tiles of {:.0f} million pixels: expected {:.0f} million at most",
                header.format, static_cast<double>(header.tile_pixels) / 1e6, static_cast<double>(limits.pixels) / 1e6);
  if (header.format == "FITS" && width == 0 && height == 0)  // so begin those that fpack made
    return fail(FaultKind::bad_input,
                "a FITS of NAXIS = 0 in its first header: expected a picture there, uncompressed (funpack)");
  return fail(FaultKind::bad_input, "a {} of {} x {} pixels: expected 1 .. {} each way and {:.0f} million at most",
              header.format, width, height, limits.side_px, static_cast<double>(limits.pixels) / 1e6);
}

}  // namespace kasumi

#include "pipeline/site/files/picture_times.hpp"

#include <array>
#include <cctype>
#include <cmath>
#include <ctime>

#include <libexif/exif-data.h>

#include "base/c_ptr.hpp"
#include "base/finite_number.hpp"
#include "base/fits_header.hpp"
#include "base/utc_text.hpp"
#include "pipeline/site/files/archive_members.hpp"

namespace kasumi {
namespace {

constexpr std::array kUsual{"%Y%m%d_%H%M%S",     "%Y%m%d-%H%M%S",     "%Y%m%dT%H%M%S",     "%Y%m%d%H%M%S",
                            "%Y-%m-%d_%H-%M-%S", "%Y-%m-%dT%H-%M-%S", "%Y-%m-%dT%H:%M:%S", "%Y-%m-%d_%H:%M:%S",
                            "%Y_%m_%d_%H_%M_%S", "%Y-%m-%d %H-%M-%S", "%Y%m%d_%H%M",       "%Y%m%d-%H%M"};
constexpr const char* kExif = "%Y:%m:%d %H:%M:%S";
constexpr int kFirstYear = 1990, kLastYear = 2100;  // others are numbers that look like a date

std::optional<Utc> parse(const std::string& text, const char* format, double offset_h) {
  for (std::size_t from = 0; from < text.size(); ++from) {
    // A date begins where a number does.
    if (from > 0 && std::isdigit(static_cast<unsigned char>(text[from - 1]))) continue;
    std::tm time{};
    time.tm_mday = 1;
    const char* end = ::strptime(text.c_str() + from, format, &time);
    if (!end || std::isdigit(static_cast<unsigned char>(*end))) continue;
    const int year = time.tm_year + 1900;
    if (year < kFirstYear || year > kLastYear) continue;
    const auto seconds = ::timegm(&time) - std::llround(3600.0 * offset_h);
    return Utc{std::chrono::seconds{seconds}};
  }
  return std::nullopt;
}

using ExifPtr = CPtr<ExifData, exif_data_unref>;

std::string entry_of(const ExifData& data, ExifTag tag) {
  ExifEntry* entry = exif_content_get_entry(data.ifd[EXIF_IFD_EXIF], tag);
  if (!entry) return {};
  std::array<char, 64> text{};
  return exif_entry_get_value(entry, text.data(), text.size()) ? std::string(text.data()) : std::string();
}

// "+09:00"
std::optional<double> offset_of(const std::string& text) {
  if (text.size() != 6 || (text[0] != '+' && text[0] != '-')) return std::nullopt;
  const auto hours = finite_number(text.substr(1, 2)), minutes = finite_number(text.substr(4, 2));
  if (!hours || !minutes) return std::nullopt;
  return (text[0] == '-' ? -1.0 : 1.0) * (*hours + *minutes / 60.0);
}

std::optional<Utc> by_exif(const std::vector<std::uint8_t>& file, double offset_h) {
  const ExifPtr data(exif_data_new_from_data(file.data(), static_cast<unsigned int>(file.size())));
  if (!data) return std::nullopt;
  const auto own = offset_of(entry_of(*data, EXIF_TAG_OFFSET_TIME_ORIGINAL));
  return parse(entry_of(*data, EXIF_TAG_DATE_TIME_ORIGINAL), kExif, own.value_or(offset_h));
}

// UTC, as the standard has it.
std::optional<Utc> by_fits(const std::vector<std::uint8_t>& file) {
  const auto begin = fits_value(file, "DATE-OBS");
  return begin ? parse_utc(*begin + "Z") : std::nullopt;
}

}  // namespace

std::optional<Utc> picture_time(const std::filesystem::path& file, const PictureTimes& times) {
  const auto name = file.filename().string();
  const bool with_folders = times.format.find('/') != std::string::npos;
  if (!times.format.empty())
    return parse(with_folders ? file.string() : name, times.format.c_str(), times.utc_offset_h);
  for (const char* usual : kUsual)
    if (const auto utc = parse(name, usual, times.utc_offset_h)) return utc;
  const auto bytes = read_picture_bytes(file);
  if (!bytes) return std::nullopt;
  return is_fits(*bytes) ? by_fits(*bytes) : by_exif(*bytes, times.utc_offset_h);
}

}  // namespace kasumi

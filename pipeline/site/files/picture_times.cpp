#include "pipeline/site/files/picture_times.hpp"

#include <array>
#include <cctype>
#include <cmath>
#include <ctime>

#include "base/picture_files/tiff_directory.hpp"
#include "base/picture_header.hpp"
#include "pipeline/site/files/archive_members.hpp"
#include "pipeline/site/files/taken_at.hpp"

namespace kasumi {
namespace {

constexpr std::array kUsual{"%Y%m%d_%H%M%S",     "%Y%m%d-%H%M%S",     "%Y%m%dT%H%M%S",     "%Y%m%d%H%M%S",
                            "%Y-%m-%d_%H-%M-%S", "%Y-%m-%dT%H-%M-%S", "%Y-%m-%dT%H:%M:%S", "%Y-%m-%d_%H:%M:%S",
                            "%Y_%m_%d_%H_%M_%S", "%Y-%m-%d %H-%M-%S", "%Y%m%d_%H%M",       "%Y%m%d-%H%M"};
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

}  // namespace

std::optional<Utc> picture_time(const std::filesystem::path& file, const PictureTimes& times) {
  const auto name = file.filename().string();
  const bool with_folders = times.format.find('/') != std::string::npos;
  if (!times.format.empty())
    return parse(with_folders ? file.string() : name, times.format.c_str(), times.utc_offset_h);
  for (const char* usual : kUsual)
    if (const auto utc = parse(name, usual, times.utc_offset_h)) return utc;
  auto bytes = read_picture_bytes(file, kTakenAtBytes);
  if (bytes && bytes->size() == kTakenAtBytes && (tiff_start(*bytes) || is_heif(*bytes)))
    bytes = read_picture_bytes(file);  // their tags may stand at the end
  if (!bytes) return std::nullopt;
  const auto taken = taken_at(*bytes);
  if (taken.utc || !taken.wall) return taken.utc;
  return *taken.wall - std::chrono::seconds(std::llround(3600.0 * times.utc_offset_h));
}

}  // namespace kasumi

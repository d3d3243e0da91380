#include "pipeline/site/files/taken_at.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <ctime>
#include <numbers>
#include <string>
#include <vector>

#include <libexif/exif-data.h>

#include "base/c_ptr.hpp"
#include "base/earth.hpp"
#include "base/finite_number.hpp"
#include "base/fits_header.hpp"
#include "base/picture_files/embedded_tags.hpp"
#include "base/picture_files/tiff_directory.hpp"
#include "base/utc_text.hpp"

namespace kasumi {
namespace {

using Place = TakenAt::Place;
using TagsPtr = CPtr<ExifData, exif_data_unref>;
constexpr double kDegree = std::numbers::pi / 180.0;

std::optional<Place> plausible(double latitude_deg, double longitude_deg, std::optional<double> altitude_m) {
  if (longitude_deg > 180.0 && longitude_deg <= 360.0) longitude_deg -= 360.0;
  if (!(std::abs(latitude_deg) <= 90.0 && std::abs(longitude_deg) <= 180.0)) return std::nullopt;
  if (latitude_deg == 0.0 && longitude_deg == 0.0) return std::nullopt;
  if (altitude_m && !(*altitude_m >= -500.0 && *altitude_m <= 9000.0)) altitude_m.reset();
  return Place{latitude_deg, longitude_deg, altitude_m};
}

// "+09:00", "Z": hours ahead of UTC.
std::optional<double> zone_of(const std::string& text) {
  if (text == "Z" || text == "z") return 0.0;
  if (text.size() != 6 || (text[0] != '+' && text[0] != '-') || text[3] != ':') return std::nullopt;
  const auto hours = finite_number(text.substr(1, 2)), minutes = finite_number(text.substr(4, 2));
  if (!hours || !minutes) return std::nullopt;
  return (text[0] == '-' ? -1.0 : 1.0) * (*hours + *minutes / 60.0);
}

Utc by_zone(Utc wall, double ahead_h) {
  return wall - std::chrono::seconds(std::llround(3600.0 * ahead_h));
}

// Zones are quarters of an hour apart.
bool zones_apart(Utc utc, Utc wall) {
  constexpr std::chrono::minutes kQuarter(15), kMost(15 * 60), kSlack(2);
  const auto apart = std::chrono::abs(wall - utc) + kSlack;
  return apart < kMost && apart % kQuarter <= 2 * kSlack;
}

const ExifEntry* entry_at(const ExifData& data, ExifIfd directory, int tag) {
  return exif_content_get_entry(data.ifd[directory], static_cast<ExifTag>(tag));
}
std::string text_of(const ExifEntry* entry) {
  if (!entry || entry->format != EXIF_FORMAT_ASCII || !entry->data) return {};
  std::string text(reinterpret_cast<const char*>(entry->data), entry->size);
  return text.substr(0, text.find('\0'));
}
// Empty: not so many, or one is no number.
std::vector<double> rationals_of(const ExifData& data, const ExifEntry* entry, std::size_t count) {
  constexpr std::size_t kSize = 8;
  std::vector<double> values;
  if (!entry || entry->format != EXIF_FORMAT_RATIONAL || entry->components < count || entry->size < kSize * count)
    return values;
  for (std::size_t i = 0; i < count; ++i) {
    const auto ratio =
        exif_get_rational(entry->data + kSize * i, exif_data_get_byte_order(const_cast<ExifData*>(&data)));
    if (ratio.denominator == 0) return {};
    values.push_back(static_cast<double>(ratio.numerator) / static_cast<double>(ratio.denominator));
  }
  return values;
}

std::optional<Utc> exif_day_and_time(const std::string& text) {
  std::tm time{};
  const char* end = ::strptime(text.c_str(), "%Y:%m:%d %H:%M:%S", &time);
  if (!end || time.tm_year < 90) return std::nullopt;
  return Utc{std::chrono::seconds{::timegm(&time)}};
}

std::optional<Place> place_by_gps(const ExifData& data) {
  const auto angle = [&](int tag, int side) -> std::optional<double> {
    const auto parts = rationals_of(data, entry_at(data, EXIF_IFD_GPS, tag), 3);
    const auto which = text_of(entry_at(data, EXIF_IFD_GPS, side));
    if (parts.empty() || which.empty()) return std::nullopt;
    const double sign = which[0] == 'S' || which[0] == 'W' ? -1.0 : 1.0;
    return sign * (parts[0] + parts[1] / 60.0 + parts[2] / 3600.0);
  };
  const auto latitude = angle(EXIF_TAG_GPS_LATITUDE, EXIF_TAG_GPS_LATITUDE_REF),
             longitude = angle(EXIF_TAG_GPS_LONGITUDE, EXIF_TAG_GPS_LONGITUDE_REF);
  if (!latitude || !longitude) return std::nullopt;
  std::optional<double> altitude;
  if (const auto height = rationals_of(data, entry_at(data, EXIF_IFD_GPS, EXIF_TAG_GPS_ALTITUDE), 1); !height.empty()) {
    const auto* below = entry_at(data, EXIF_IFD_GPS, EXIF_TAG_GPS_ALTITUDE_REF);
    altitude = below && below->size > 0 && below->data[0] == 1 ? -height[0] : height[0];
  }
  return plausible(*latitude, *longitude, altitude);
}

std::optional<Utc> utc_by_gps(const ExifData& data) {
  const auto clock = rationals_of(data, entry_at(data, EXIF_IFD_GPS, EXIF_TAG_GPS_TIME_STAMP), 3);
  const auto day = exif_day_and_time(text_of(entry_at(data, EXIF_IFD_GPS, EXIF_TAG_GPS_DATE_STAMP)) + " 00:00:00");
  if (clock.empty() || !day) return std::nullopt;
  return *day + std::chrono::seconds(std::llround(3600.0 * clock[0] + 60.0 * clock[1] + clock[2]));
}

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// 46.94, "+46.94", "46 56 24.0", "46:56:24 N".
std::optional<double> angle_of(std::string text) {
  double sign = 1.0, degrees = 0.0, unit = 1.0;
  const auto side = text.find_last_of("NSEWnsew");
  if (side != std::string::npos) {
    if (std::string_view("SWsw").find(text[side]) != std::string_view::npos) sign = -1.0;
    text.erase(side);
  }
  std::ranges::replace(text, ':', ' ');
  for (std::size_t at = text.find_first_not_of(' '), parts = 0; at != std::string::npos; ++parts) {
    const auto end = std::min(text.find(' ', at), text.size());
    auto part = text.substr(at, end - at);
    if (parts == 0 && (part[0] == '-' || part[0] == '+')) {
      if (part[0] == '-') sign = -sign;
      part.erase(0, 1);
    }
    const auto value = finite_number(part);
    if (!value || *value < 0.0 || parts > 2) return std::nullopt;
    degrees += *value / unit;
    unit *= 60.0;
    at = text.find_first_not_of(' ', end);
  }
  return unit > 1.0 ? std::optional(sign * degrees) : std::nullopt;
}

// Bowring's: less than a metre off.
Place place_of_geocentric(double x, double y, double z) {
  constexpr double kA = kWgs84SemiMajorAxis_m, kB = kA * (1.0 - kWgs84Flattening);
  constexpr double kE2 = 1.0 - kB * kB / (kA * kA), kSecondE2 = kA * kA / (kB * kB) - 1.0;
  const double off_axis = std::hypot(x, y), theta = std::atan2(z * kA, off_axis * kB);
  const double latitude =
      std::atan2(z + kSecondE2 * kB * std::pow(std::sin(theta), 3), off_axis - kE2 * kA * std::pow(std::cos(theta), 3));
  const double bend = kA / std::sqrt(1.0 - kE2 * std::pow(std::sin(latitude), 2));
  return {
      latitude / kDegree, std::atan2(y, x) / kDegree,
      off_axis * std::cos(latitude) + z * std::sin(latitude) - bend * (1.0 - kE2 * std::pow(std::sin(latitude), 2))};
}

std::optional<Place> place_by_header(std::span<const std::uint8_t> file) {
  struct Keys {
    const char *latitude, *longitude, *altitude;
  };
  constexpr std::array<Keys, 7> kKeys{{{"SITELAT", "SITELONG", "SITEELEV"},
                                       {"SITELAT", "SITELON", "SITEALT"},
                                       {"LAT-OBS", "LONG-OBS", "ALT-OBS"},
                                       {"OBS-LAT", "OBS-LONG", "OBS-ELEV"},
                                       {"OBSGEO-B", "OBSGEO-L", "OBSGEO-H"},
                                       {"LATITUDE", "LONGITUD", "ALTITUDE"},
                                       {"GPS_LAT", "GPS_LON", "GPS_ALT"}}};
  for (const auto& keys : kKeys) {
    const auto latitude = fits_value(file, keys.latitude), longitude = fits_value(file, keys.longitude);
    const auto north = latitude ? angle_of(*latitude) : std::nullopt,
               east = longitude ? angle_of(*longitude) : std::nullopt;
    if (!north || !east) continue;
    const auto altitude = fits_value(file, keys.altitude);
    if (const auto place = plausible(*north, *east, altitude ? finite_number(*altitude) : std::nullopt)) return place;
  }
  std::array<double, 3> centre{};
  for (std::size_t i = 0; i < centre.size(); ++i) {
    const auto text = fits_value(file, std::string("OBSGEO-") + "XYZ"[i]);
    const auto value = text ? finite_number(*text) : std::nullopt;
    if (!value) return std::nullopt;
    centre[i] = *value;
  }
  if (std::hypot(centre[0], centre[1], centre[2]) < 0.9 * kWgs84SemiMajorAxis_m) return std::nullopt;
  const auto place = place_of_geocentric(centre[0], centre[1], centre[2]);
  return plausible(place.latitude_deg, place.longitude_deg, place.altitude_m);
}

void time_by_header(std::span<const std::uint8_t> file, TakenAt& taken) {
  for (const char* keyword : {"DATE-OBS", "DATE-BEG"}) {
    auto text = fits_value(file, keyword).value_or("");
    if (text.size() == std::string_view("2019-05-01").size()) {
      auto clock = fits_value(file, "TIME-OBS");
      if (!clock) clock = fits_value(file, "UT");
      if (clock) text += "T" + *clock;
    }
    constexpr std::size_t kSeconds = 19;  // "2019-05-01T12:34:56"
    if (text.size() < kSeconds) continue;
    const auto end = text.find_first_not_of("0123456789.", kSeconds);
    const auto zone = end == std::string::npos ? std::optional<double>() : zone_of(text.substr(end));
    constexpr std::size_t kMostDigits = 29;  // some write ten thousandths of a microsecond
    const auto wall = parse_utc(text.substr(0, std::min({text.size(), end, kMostDigits})) + "Z");
    if (!wall || (end != std::string::npos && !zone)) continue;
    const bool local = lower(fits_value(file, "TIMESYS").value_or("")).starts_with("local") ||
                       (lower(fits_comment(file, keyword).value_or("")).find("local") != std::string::npos);
    if (zone)
      taken.utc = by_zone(*wall, *zone);
    else
      (local ? taken.wall : taken.utc) = wall;
    return;
  }
}

}  // namespace

TakenAt taken_by_exif(std::span<const std::uint8_t> exif) {
  TakenAt taken;
  if (exif.empty()) return taken;
  std::vector<std::uint8_t> headed{'E', 'x', 'i', 'f', 0, 0};
  headed.insert(headed.end(), exif.begin(), exif.end());
  const TagsPtr data(exif_data_new());
  if (!data) return taken;
  exif_data_unset_option(data.get(), EXIF_DATA_OPTION_FOLLOW_SPECIFICATION);
  exif_data_load_data(data.get(), headed.data(), static_cast<unsigned int>(headed.size()));
  taken.place = place_by_gps(*data);
  const auto wall = exif_day_and_time(text_of(entry_at(*data, EXIF_IFD_EXIF, EXIF_TAG_DATE_TIME_ORIGINAL)));
  const auto zone = zone_of(text_of(entry_at(*data, EXIF_IFD_EXIF, EXIF_TAG_OFFSET_TIME_ORIGINAL)));
  if (wall && zone)
    taken.utc = by_zone(*wall, *zone);
  else
    taken.utc = utc_by_gps(*data), taken.wall = wall;
  if (taken.utc && taken.wall && !zones_apart(*taken.utc, *taken.wall)) taken.utc.reset();  // an older fix of GPS's
  if (taken.utc || taken.wall || taken.place) taken.by = "EXIF";
  return taken;
}

TakenAt taken_at(std::span<const std::uint8_t> file) {
  TakenAt taken;
  if (is_fits(file)) {
    time_by_header(file, taken);
    taken.place = place_by_header(file);
    if (taken.utc || taken.wall || taken.place) taken.by = "FITS header";
    return taken;
  }
  const auto begins = [&](std::string_view bytes) {
    return file.size() >= bytes.size() &&
           std::equal(bytes.begin(), bytes.end(), file.begin(),
                      [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
  };
  PictureHeader header;
  if (begins("\xff\xd8")) header.format = "JPEG";
  if (begins("\x89PNG")) header.format = "PNG";
  if (begins("RIFF")) header.format = "WebP";
  if (tiff_start(file)) header.format = "TIFF";
  if (is_heif(file)) header.format = "HEIF";
  const auto tags = embedded_tags(header, file);
  return tags ? taken_by_exif(tags->exif) : taken;
}

}  // namespace kasumi

// When and where a picture was taken, as its file says: by EXIF (JPEG, PNG, WebP, TIFF, HEIC) or a FITS
// header.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "base/clock.hpp"

namespace kasumi {

struct TakenAt {
  struct Place {
    double latitude_deg, longitude_deg;  // north, east
    std::optional<double> altitude_m;
  };
  std::string_view by;      // "EXIF", "FITS header"; empty: the file has neither time nor place
  std::optional<Utc> utc;   // where the file names the zone
  std::optional<Utc> wall;  // a clock of a zone that the file does not name, as if it were UTC's
  std::optional<Place> place;
};

// `file`: whole, or of other formats than TIFF and HEIC its first kTakenAtBytes. EXIF: DateTimeOriginal with OffsetTimeOriginal, else GPS time (UTC); GPS
// position. FITS: DATE-OBS (with TIME-OBS where it is a day), else DATE-BEG, which are UTC unless they or TIMESYS say
// otherwise; SITELAT, LAT-OBS, OBS-LAT, OBSGEO-B or LATITUDE with their longitudes and elevations in degrees or
// sexagesimal, or OBSGEO-X, -Y, -Z. A place of 0, 0 is one that nobody set.
TakenAt taken_at(std::span<const std::uint8_t> file);
constexpr std::size_t kTakenAtBytes = 128 << 10;

// `exif`: a TIFF of tags.
TakenAt taken_by_exif(std::span<const std::uint8_t> exif);

}  // namespace kasumi

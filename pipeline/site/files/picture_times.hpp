// When a picture was taken, by its name, its EXIF data or its FITS header.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/clock.hpp"

namespace kasumi {

struct PictureTimes {
  // As strptime reads it, somewhere in the file's name: "%Y%m%d_%H%M%S"; with folders where it has a slash:
  // "%Y/%m/%d/%H%M". Empty: what names usually have, else EXIF or FITS (DATE-OBS).
  std::string format;
  double utc_offset_h = 0.0;  // of those times: 9 in Japan; EXIF's own offset takes precedence
};

// Empty: neither the name nor the file has a time.
std::optional<Utc> picture_time(const std::filesystem::path& file, const PictureTimes& times);

}  // namespace kasumi

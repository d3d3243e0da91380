// Films by libav, as H.264 by x264 where it has that, else as MPEG-4.
#pragma once

#include <memory>
#include <string>

#include "base/picture_files/rare_files.hpp"

namespace kasumi {

// As RareFiles::make_film().
std::unique_ptr<FilmEncoder> encode_film(const std::string& file, double frames_per_second, cv::Size size);

}  // namespace kasumi

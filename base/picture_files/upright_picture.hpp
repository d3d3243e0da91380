// A picture as a viewer shows it: turned as its EXIF says, its colours sRGB. The one reader of photographs and masks.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

#include "base/picture_header.hpp"
#include "base/result.hpp"

namespace kasumi {

struct UprightPicture {
  cv::Mat picture;       // R G B (A) or grey: as the file has it, or floats of 0..1 where a colour profile was applied
  double quantum = 0.0;  // of the file's samples: 1/255, 1/65535; 0: floats
  bool is_converted = false;       // by its profile
  std::vector<std::uint8_t> exif;  // the file's, a TIFF of tags
  bool whole = false;              // a JPEG that was seen to miss nothing
};

// The caller has checked its size. Without orientation and profile the samples are those of decode_picture_file(), bit
// for bit. Errors (bad_input, unsupported): those of that, a colour profile that cannot be applied.
Result<UprightPicture> decode_upright_picture(const PictureHeader& header, std::span<const std::uint8_t> file);

// The mask in 8 bits: white is visible. A mask painted as transparency is its alpha: transparent hides. Errors
// (bad_input): other depths; black on transparency, where either could mean hidden.
Result<cv::Mat> mask_of(const UprightPicture& seen);

}  // namespace kasumi

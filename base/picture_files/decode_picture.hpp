// A picture file of any format.
#pragma once

#include <cstdint>
#include <span>

#include <opencv2/core.hpp>

#include "base/picture_header.hpp"
#include "base/result.hpp"

namespace kasumi {

// Grey, R G B or R G B A, values and bits as they stand in the file: PNG and JPEG by picture_files, others by the module.
// `header`: the file's own, whose size has been bounded. Errors: bad_input (damaged), unsupported (no module here).
// `whole` receives whether it is a JPEG that was seen to miss nothing.
Result<cv::Mat> decode_picture_file(const PictureHeader& header, std::span<const std::uint8_t> file,
                                    bool* whole = nullptr);

}  // namespace kasumi

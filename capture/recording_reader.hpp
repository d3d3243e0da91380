// Looks through the pictures of a recorded camera as fast as they can be read, without playing them by a clock.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "base/result.hpp"
#include "capture/frame.hpp"

namespace kasumi {

struct ReadingOptions {
  YuvEncoding yuv_encoding = YuvEncoding::bt601_full;  // of uncompressed pictures
  int width = 0, height = 0;                           // expected; 0: any size
  // At most so many: the first good one of as many equal stretches of rows. Empty: all.
  std::optional<int> most{};
  // Asked before a picture is read; what it declines is neither good nor damaged. Empty: every one is wanted.
  std::function<bool(const FrameMetadata&)> wanted{};
};

struct PicturesRead {
  int good = 0, damaged = 0;
  Utc first{}, last{};  // of the good ones
};

// Hands each picture to `use`, in the order of the rows. A picture is damaged when its file cannot be read or is cut
// short, when the driver flagged it, when it cannot be decoded, and when it is of another size than expected: it is
// counted and passed over. A row that tells of a disconnection is no picture. Errors (bad_input): what read_index
// finds; pictures were wanted, but none is good.
Result<PicturesRead> for_each_picture(const std::filesystem::path& camera_folder, const ReadingOptions& options,
                                      const std::function<void(const PictureView&, const FrameMetadata&)>& use);

}  // namespace kasumi

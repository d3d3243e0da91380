#include "base/picture_files/upright_picture.hpp"

#include <opencv2/imgproc.hpp>

#include "base/picture_files/decode_picture.hpp"
#include "base/picture_files/embedded_tags.hpp"
#include "base/picture_files/rare_files.hpp"

namespace kasumi {

namespace {

// EXIF's orientations, as a mirror and quarter turns clockwise.
void turn(cv::Mat& picture, int orientation) {
  if (orientation == 2 || orientation == 4 || orientation == 5 || orientation == 7) cv::flip(picture, picture, 1);
  if (orientation == 3 || orientation == 4) cv::rotate(picture, picture, cv::ROTATE_180);
  if (orientation == 6 || orientation == 7) cv::rotate(picture, picture, cv::ROTATE_90_CLOCKWISE);
  if (orientation == 5 || orientation == 8) cv::rotate(picture, picture, cv::ROTATE_90_COUNTERCLOCKWISE);
}

}  // namespace

Result<UprightPicture> decode_upright_picture(const PictureHeader& header, std::span<const std::uint8_t> file) {
  auto tags = embedded_tags(header, file);
  if (!tags) return fail(tags.error());
  bool whole = false;
  auto decoded = decode_picture_file(header, file, &whole);
  if (!decoded) return fail(decoded.error());
  UprightPicture seen{std::move(*decoded), 0.0, false, std::move(tags->exif), whole};
  if (seen.picture.empty()) return seen;
  const int depth = seen.picture.depth();
  seen.quantum = depth == CV_8U ? 1.0 / 255.0 : depth == CV_16U ? 1.0 / 65535.0 : 0.0;
  if (!tags->profile.empty() && seen.quantum > 0.0) {
    const auto files = rare_files();
    if (!files) return fail(files.error().kind, "it has a colour profile, and {}", files.error().message);
    if (const auto wrong = (*files)->to_srgb(seen.picture, tags->profile); !wrong.empty())
      return fail(FaultKind::bad_input, "{}: expected it saved as sRGB", wrong);
    seen.is_converted = seen.picture.depth() == CV_32F;
  }
  if (header.format != "TIFF")
    turn(seen.picture, tags->orientation);  // OpenCV turns TIFFs itself, whatever it is asked
  return seen;
}

Result<cv::Mat> mask_of(const UprightPicture& seen) {
  cv::Mat picture = seen.picture;
  if (seen.is_converted) picture.convertTo(picture, CV_8U, 255.0);
  if (picture.depth() == CV_16U) picture.convertTo(picture, CV_8U, 1.0 / 256.0, -0.498);  // the upper byte
  if (picture.empty() || picture.depth() != CV_8U) return fail(FaultKind::bad_input, "of 8 or 16 bits");
  cv::Mat grey = picture;
  if (picture.channels() == 3) cv::cvtColor(picture, grey, cv::COLOR_RGB2GRAY);
  if (picture.channels() != 4) return grey;
  cv::cvtColor(picture, grey, cv::COLOR_RGBA2GRAY);
  cv::Mat alpha;
  cv::extractChannel(picture, alpha, 3);
  if (cv::countNonZero(alpha < 255) == 0) return grey;
  // Ink that is black and white only is a mask by itself, cut out; other ink is any picture with holes.
  const cv::Mat opaque = alpha > 127, black = (grey < 16) & opaque, white = (grey > 239) & opaque;
  const int inked = cv::countNonZero(opaque), blacks = cv::countNonZero(black), whites = cv::countNonZero(white);
  if (inked > 0 && blacks == inked)
    return fail(FaultKind::bad_input,
                "black and white, or transparent where things hide (this is black on transparency, and "
                "either may be meant): flatten it");
  if (blacks > 0 && whites > 0 && blacks + whites >= 0.99 * inked) return cv::Mat(cv::min(grey, alpha));
  return alpha;
}

}  // namespace kasumi

#include <webp/decode.h>

#include "gles/packed/module.hpp"

namespace kasumi {

Result<Image<glm::u8vec4>> read_webp(std::span<const std::uint8_t> file, int width, int height) {
  WebPBitstreamFeatures features{};
  if (WebPGetFeatures(file.data(), file.size(), &features) != VP8_STATUS_OK)
    return fail(FaultKind::bad_input, "damaged WebP");
  if (features.has_animation != 0) return fail(FaultKind::bad_input, "a WebP film: expected a picture");
  if (features.width != width || features.height != height)
    return fail(FaultKind::bad_input, "WebP of {} x {} pixels: its header says {} x {}", features.width,
                features.height, width, height);
  Image<glm::u8vec4> image(width, height);
  const int row = width * 4;
  static_assert(sizeof(glm::u8vec4) == 4);
  if (WebPDecodeRGBAInto(file.data(), file.size(), &image.elements()[0][0],
                         static_cast<std::size_t>(row) * static_cast<std::size_t>(height), row) == nullptr)
    return fail(FaultKind::bad_input, "damaged WebP");
  return image;
}

}  // namespace kasumi

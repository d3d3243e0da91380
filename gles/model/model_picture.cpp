#include "gles/model/model_picture.hpp"

#include <cstring>

#include "base/picture_files/picture_file.hpp"
#include "gles/model/rare_models.hpp"

namespace kasumi {

namespace {

std::uint8_t in_8_bits(const DecodedFile& file, std::size_t sample) {
  if (file.bits == 8) return file.samples[sample];
  std::uint16_t value = 0;
  std::memcpy(&value, file.samples.data() + 2 * sample, sizeof value);
  return static_cast<std::uint8_t>((value + 128) / 257);
}

}  // namespace

Result<PictureHeader> model_picture_size(std::span<const std::uint8_t> file, int largest) {
  const auto header = picture_header(file);
  if (!header || (header->format != "PNG" && header->format != "JPEG" && header->format != "WebP"))
    return fail(FaultKind::bad_input, "neither a PNG nor a JPEG nor a WebP");
  if (auto bounded = check_size(*header, {largest, kPhotographLimits.pixels}); !bounded) return fail(bounded.error());
  return *header;
}

Result<Image<glm::u8vec4>> decode_picture(std::span<const std::uint8_t> file, int largest) {
  const auto header = model_picture_size(file, largest);
  if (!header) return fail(header.error());
  if (header->format == "WebP") {
    const auto models = rare_models();
    if (!models) return fail(models.error());
    return (*models)->webp_picture(file, static_cast<int>(header->width), static_cast<int>(header->height));
  }
  const auto decoded = header->format == "PNG" ? decode_png(file) : decode_jpeg_file(file);
  if (!decoded) return fail(decoded.error());
  const bool grey = decoded->channels == 1;
  Image<glm::u8vec4> image(decoded->width, decoded->height);
  std::size_t at = 0;
  for (glm::u8vec4& texel : image.elements()) {
    for (const int c : {0, 1, 2}) texel[c] = in_8_bits(*decoded, at + static_cast<std::size_t>(grey ? 0 : c));
    texel.a = decoded->channels == 4 ? in_8_bits(*decoded, at + 3) : 255;
    at += static_cast<std::size_t>(decoded->channels);
  }
  return image;
}

}  // namespace kasumi

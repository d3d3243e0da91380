#include "pipeline/kiosk/content/texture_file.hpp"

#include <algorithm>

#include "base/picture_files/picture_file.hpp"
#include "capture/codec/encode.hpp"

namespace kasumi {

namespace {

constexpr int kTextureQuality = 95;  // of JPEG: what it takes away shows in the measured loss

Result<std::vector<std::uint8_t>> texture_file(const Image<glm::u8vec4>& pixels) {
  if (std::ranges::any_of(pixels.elements(), [](const glm::u8vec4& texel) { return texel.a != 255; }))
    return encode_png(pixels);
  Image<Rgb8> opaque(pixels.width(), pixels.height());
  std::ranges::transform(pixels.elements(), opaque.elements().begin(),
                         [](const glm::u8vec4& texel) { return Rgb8(texel); });
  auto png = encode_png(opaque);
  auto jpeg = encode_jpeg(opaque, kTextureQuality, ChromaSubsampling::s444);
  return png && (!jpeg || png->size() < jpeg->size()) ? std::move(png) : std::move(jpeg);
}

}  // namespace

Result<std::vector<std::vector<std::uint8_t>>> texture_files(const std::vector<ModelTexture>& textures) {
  std::vector<std::vector<std::uint8_t>> files;
  for (const auto& texture : textures) {
    auto file = texture_file(texture.pixels);
    if (!file) return fail(file.error());
    files.push_back(std::move(*file));
  }
  return files;
}

}  // namespace kasumi

#include "gles/composite/processor_mix.hpp"

#include <algorithm>

#include "gles/gl/patterns.hpp"

namespace kasumi {
namespace {

// Both images begin at a pixel of the picture: copies these rectangles.
void copy_pixels(const std::vector<PixelBox>& rectangles, const Image<glm::u8vec4>& from, glm::ivec2 from_first,
                 Image<glm::u8vec4>& to, glm::ivec2 to_first) {
  for (const PixelBox& box : rectangles)
    for (int y = box.top; y < box.bottom; ++y)
      std::copy_n(from.row(y - from_first.y) + (box.left - from_first.x), box.right - box.left,
                  to.row(y - to_first.y) + (box.left - to_first.x));
}

glm::ivec2 corner(const PixelBox& box) {
  return {box.left, box.top};
}

}  // namespace

ProcessorMix::ProcessorMix() : response_(ResponseCurve{}), patterns_{dither_texels(), &noise_texels()} {}

void ProcessorMix::take_layer(const LayerTexels& layer, const Composite& composite,
                              const Image<glm::u8vec2>* foreground, bool matte) {
  pixels_ = MixedPixels(layer, composite.rectangles(CutArea::edge), composite.fully_covered(), foreground,
                        matte ? &nodes_ : nullptr);
}

const Image<glm::u8vec4>& ProcessorMix::background() {
  to_rgba(planes_.view(), picture_);
  return picture_;
}

const Image<glm::u8vec4>& ProcessorMix::mix(const Parts& parts) {
  to_rgba(planes_.view(), picture_);
  const EdgeInputs inputs{planes_.view(), response_,  patterns_, pixels_, parts.passers ? &passers_ : nullptr,
                          parts.measured, parts.noise};
  if (!parts.processing.none()) {
    mix_processed(parts, inputs);
    return picture_;
  }
  mix_edges(inputs, {0, 0}, picture_, matte_light_);
  if (const auto* pixels = parts.covered.pixels)
    copy_pixels(parts.composite.fully_covered(), *pixels, corner(parts.composite.covered()), picture_, {0, 0});
  return picture_;
}

void ProcessorMix::mix_processed(const Parts& parts, const EdgeInputs& inputs) {
  const glm::ivec2 size{picture_.width(), picture_.height()};
  const ObjectFootprint object{parts.composite.changed(), parts.composite.fully_covered(), size};
  if (object.changed.empty()) return;
  if (!processing_ || !processing_->is_for(object, parts.processing)) processing_.emplace(object, parts.processing);
  const PixelBox& part = processing_->part();
  const glm::ivec2 first = corner(part);
  if (composite_.width() != part.right - part.left || composite_.height() != part.bottom - part.top)
    composite_ = Image<glm::u8vec4>(part.right - part.left, part.bottom - part.top);
  const std::size_t pattern = parts.noise.none() ? 0 : parts.noise.pattern % kNoisePatterns;
  const auto& wanted = processing_->begin(pattern, parts.covered.drawing);
  for (const PixelBox& box : wanted.pixels)
    for (int y = box.top; y < box.bottom; ++y)
      std::transform(picture_.row(y) + box.left, picture_.row(y) + box.right,
                     composite_.row(y - first.y) + (box.left - first.x),
                     [](const glm::u8vec4& seen) { return glm::u8vec4(seen.x, seen.y, seen.z, 0); });
  mix_edges(inputs, first, composite_, matte_light_);
  if (const auto* pixels = parts.covered.pixels)
    copy_pixels(wanted.covered, *pixels, corner(parts.composite.covered()), composite_, first);
  processing_->apply(picture_, composite_);
}

Result<CameraTextures> ProcessorMix::upload(const Image<glm::u8vec4>& picture, const GlInfo& info) {
  PictureView view{PixelLayout::rgba8, YuvEncoding::bt601_full, picture.width(), picture.height(), {}};
  view.planes[0] = {&picture.elements().front().x, 4 * static_cast<std::size_t>(picture.width())};
  return shown_.upload(view, info);
}

}  // namespace kasumi

#include "gles/object/processor_mix.hpp"

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

void ProcessorMix::take_layer(LayerTexels layer, const Composite& composite) {
  layer_ = std::move(layer);
  edges_.clear();
  const PixelBox& box = layer_.box;
  Image<std::uint8_t> mixed(box.right - box.left, box.bottom - box.top, 0);
  const auto set = [&](const std::vector<PixelBox>& rectangles, std::uint8_t value) {
    for (const PixelBox& part : rectangles)
      for (int y = part.top; y < part.bottom; ++y)
        std::fill_n(mixed.row(y - box.top) + (part.left - box.left), part.right - part.left, value);
  };
  set(composite.rectangles(CutArea::edge), 1);
  set(composite.fully_covered(), 0);
  for (int y = 0; y < mixed.height(); ++y)
    for (int x = 0; x < mixed.width(); ++x) {
      if (mixed.at(x, y) == 0 || layer_.texels.at(x, y).a <= 0.0F) continue;
      const int left = box.left + x, top = box.top + y;
      if (!edges_.empty() && edges_.back().top == top && edges_.back().right == left)
        ++edges_.back().right;
      else
        edges_.push_back({left, top, left + 1, top + 1});
    }
}

const Image<glm::u8vec4>& ProcessorMix::background() {
  to_rgba(planes_.view(), picture_);
  return picture_;
}

const Image<glm::u8vec4>& ProcessorMix::mix(const Parts& parts) {
  to_rgba(planes_.view(), picture_);
  const EdgeInputs inputs{planes_.view(),
                          response_,
                          patterns_,
                          layer_,
                          parts.foreground,
                          parts.matte ? &nodes_ : nullptr,
                          parts.passers ? &passers_ : nullptr,
                          parts.measured,
                          parts.noise};
  // With passers before it, all of the object is an edge.
  const auto mixed = parts.passers ? parts.composite.changed() : edges_;
  if (!parts.processing.none()) {
    mix_processed(parts, inputs, mixed);
    return picture_;
  }
  mix_edges(inputs, mixed, {0, 0}, picture_);
  if (const auto* pixels = parts.covered.pixels)
    copy_pixels(parts.composite.fully_covered(), *pixels, corner(parts.composite.covered()), picture_, {0, 0});
  return picture_;
}

void ProcessorMix::mix_processed(const Parts& parts, const EdgeInputs& inputs, const std::vector<PixelBox>& mixed) {
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
  mix_edges(inputs, mixed, first, composite_);
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

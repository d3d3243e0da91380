// Flat pictures over or instead of the scene: captions, the curator's still picture.
#pragma once

#include <memory>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/offscreen.hpp"
#include "gles/gl/target.hpp"

namespace kasumi {

using Rgba8 = glm::u8vec4;  // encoded; colours not multiplied by alpha

// Rectangle in the target, pixels from its top left corner.
struct FlatPlace {
  double left = 0.0;
  double top = 0.0;
  double width = 0.0;
  double height = 0.0;
};

// A flat picture's texels, made without GL: for a large one that takes a part of a second.
struct FlatTexels {
  Image<Rgba8> premultiplied;
  int width = 0;  // of the picture, which may be larger
  int height = 0;
};
// Halved until no side is longer than `largest`.
FlatTexels flat_texels(const Image<Rgba8>& picture, int largest);

class FlatPicture {
 public:
  // Uploads the picture (halved until it fits the driver's limit). Errors: bad_input (empty), device.
  static Result<FlatPicture> create(GlContext& context, const Image<Rgba8>& picture);
  // Errors: bad_input (empty, or beyond the driver's limit), device.
  static Result<FlatPicture> create(GlContext& context, const FlatTexels& texels);
  // Of what was drawn offscreen, opaque; without a copy. Errors: device.
  static Result<FlatPicture> create(GlContext& context, Offscreen drawn);
  FlatPicture(FlatPicture&&) noexcept;
  FlatPicture& operator=(FlatPicture&&) noexcept;
  ~FlatPicture();
  int width() const;  // of the picture as passed in
  int height() const;
  // Blends it over the target in encoded values; opacity 0..1. Pixels map 1:1 if the place has the picture's size and
  // integer coordinates. Errors: bad_input (no target, no place), device.
  Result<> draw(const DrawTarget& target, const FlatPlace& place, double opacity = 1.0) const;

 private:
  struct State;
  explicit FlatPicture(std::unique_ptr<State> state);
  static Result<FlatPicture> of_texture(const GlContext& context, int width, int height, GlTexture texture,
                                        bool has_mipmaps);
  std::unique_ptr<State> state_;
};

// The place of the whole picture inside the target, with its aspect ratio kept.
FlatPlace fitted(const DrawTarget& target, int width, int height);
FlatPlace everywhere(const DrawTarget& target);

// Fills the target with one colour.
void clear_to(const DrawTarget& target, const glm::vec3& encoded);

}  // namespace kasumi

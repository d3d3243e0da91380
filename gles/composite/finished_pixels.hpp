// The pixels that the object covers fully, as the target shows them: encoded, dithered, with one frame's noise. What
// they depend on seldom changes, so that most pictures only look them up.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/layer_buffer.hpp"
#include "gles/gl/program.hpp"
#include "gles/gl/target.hpp"
#include "gles/light/object_look.hpp"
#include "gles/picture/target_placement.hpp"

namespace kasumi {

class FinishedPixels {
 public:
  // Something other than the look has changed: the layer, the response.
  void clear() { *this = {}; }

  // Once for each picture: finds the pixels of this look on this target, `draw`s them with the viewport set if they
  // are not there yet, and makes them those to be bound. `covered`: the pixels of the picture that hold them. false:
  // the look has changed since the picture before, and to keep them would cost more than it saves. Errors: device;
  // draw's.
  Result<bool> find(const TargetPlacement& shown, const PixelBox& covered, const ObjectLook& look, const GlInfo& info,
                    const std::function<Result<>()>& draw);
  // The same pixels in memory, those of the target's part that holds `covered`; read once, and no longer to be bound.
  // Errors: device.
  Result<const Image<glm::u8vec4>*> read();
  // For picture.frag with PROCESSED, on the same target.
  void bind(const Program& program) const;

 private:
  struct Kept {
    LayerBuffer pixels;
    Image<glm::u8vec4> in_memory;    // empty: not read
    std::optional<ObjectLook> look;  // empty: nothing has been drawn
  };
  void move_to(const TargetPlacement& shown, const PixelBox& covered);

  std::array<Kept, kNoisePatterns> kept_;
  std::size_t found_ = 0;
  std::optional<ObjectLook> last_;  // of the picture before
  // Where they lie: pixels of the target, in its rows.
  Letterbox picture_;
  bool top_row_first_ = false;
  PixelBox covered_, part_;
  glm::dvec4 place_{0.0};  // of part_ in the picture: left, top, 1 / width, 1 / height
};

}  // namespace kasumi

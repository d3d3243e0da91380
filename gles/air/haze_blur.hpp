// Haze that blurs, on the GPU (H; physics 9): the scheme of matched steps, and the explicit scheme for comparison.
//
//   auto blur = HazeBlur::create(info, 1600, 1120);
//   blur->set_scene(scene);
//   blur->run(haze);           // whenever the haze has changed: 13 passes for a blur of 25 pixels
//   blur->show(target);
//
// The parameters come from estimator/haze/, which is also the reference. Light is stored in half floats if the driver
// renders to them; else as 16-bit numbers, two channels in the four bytes of a target: twice the passes, the same
// accuracy (docs/photographs.md).
#pragma once

#include <array>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/layer_buffer.hpp"
#include "gles/gl/program.hpp"
#include "gles/gl/target.hpp"

namespace kasumi {

// A picture and its surfaces' ranges. All images have the same size.
struct BlurInput {
  Image<glm::vec3> light;                           // linear, >= 0
  Image<float> range;                               // relative to the farthest, > 0
  Image<float> steps_along_row, steps_down_column;  // sums of the range's steps, in turns of 0..1
};

// One pass: its offset in whole pixels, the variance of the passes before, and its own.
struct HazePass {
  double offset_px = 1.0;
  double from_px2 = 0.0;
  double variance_px2 = 0.0;
};

struct HazeLook {
  std::array<glm::dvec3, 2> weight{glm::dvec3{1.0}, glm::dvec3{0.0}};  // of two exponentials a channel; sum 1
  std::array<glm::dvec3, 2> extinction{};                              // per farthest range
  glm::dvec3 airlight{1.0};                                            // linear
  double inner_px = 1.0;                                               // the picture's own width
  double widening_px = 0.0;                                            // added at range 1; grows as range^(3/2)
  std::vector<HazePass> passes;
  int explicit_passes = 0;  // > 0: this many passes of one pixel instead, by H Eq 11-13
  // Differences of the steps' sums, in turns: below the first it is one surface, above the second it is two.
  double same_surface = 0.0, other_surface = 0.0;
};

struct BlurStorage {
  bool force_bytes = false;  // even if the driver renders to half floats
};

class HazeBlur {
 public:
  // Errors: bad_input (size), unsupported (the driver computes in medium precision only), device.
  static Result<HazeBlur> create(const GlInfo& info, int width, int height, const BlurStorage& options = {});
  bool in_bytes() const { return in_bytes_; }

  // Errors: bad_input (sizes), device.
  Result<> set_scene(const BlurInput& scene);
  // Fades and blurs the scene. Errors: bad_input (a step larger than the picture, no scene), device.
  Result<> run(const HazeLook& look);
  // Draws the last result with its airlight added, encoded as sRGB. Errors: bad_input (target), device.
  Result<> show(const DrawTarget& target) const;
  // The same without airlight: premultiplied light and transmission, linear. BLOCKS.
  Result<Image<glm::vec4>> read() const;

 private:
  HazeBlur() = default;
  struct State {  // of the light: one buffer, or one for each pair of channels
    std::vector<LayerBuffer> buffers;
  };
  Result<State> make_state(const GlInfo& info) const;
  void draw_into(const LayerBuffer& buffer) const;

  int width_ = 0, height_ = 0;
  bool in_bytes_ = false, filters_ = false;
  std::vector<Program> begin_;                       // one for each buffer of the state
  std::vector<Program> pass_, explicit_pass_, end_;  // one
  State now_, next_;
  GlTexture red_green_, blue_, along_row_, down_column_;
  double range_scale_ = 1.0, light_unit_ = 1.0;
  bool has_scene_ = false;
  HazeLook look_;  // of the last run
  double unit_ = 1.0;
};

}  // namespace kasumi

// What the renderer is measured against: a plain blit, the papers' sum over wavelengths, the papers' buffers (M Sect
// 6).
#pragma once

#include <string>
#include <vector>

#include "base/result.hpp"
#include "gles/context.hpp"
#include "gles/gpu_model.hpp"
#include "gles/objects.hpp"
#include "gles/programs.hpp"
#include "gles/projection.hpp"
#include "gles/target.hpp"
#include "pipeline/bench_gles_scene.hpp"

namespace kasumi {

// How Gamma is computed in each fragment. two_nodes: physics 4, six exponentials. The others: M Eq 11 as a sum over
// that many wavelengths, one exponential each; scattering coefficients from wavelength (M Eq 15 and 18), their
// constant factors and q_c from the CPU.
enum class GammaBy { two_nodes, wavelengths_41, wavelengths_81 };

// One shader over the whole target.
class ScreenPass {
 public:
  // The camera's picture as it is.
  static Result<ScreenPass> blit(unsigned picture);
  // A picture under air, 0 to 50 km from left to right.
  static Result<ScreenPass> under_air(unsigned picture, const BenchScene& scene, GammaBy gamma);
  // The papers' third pass: depth to distance (M Eq 19), Gamma, M Eq 10, the background where no object is.
  static Result<ScreenPass> compositing(unsigned object, unsigned depth, unsigned background, const DepthRange& range,
                                        const BenchScene& scene, GammaBy gamma);
  Result<> draw(const DrawTarget& target) const;

 private:
  ScreenPass() = default;
  static Result<ScreenPass> build(const std::string& name, const std::string& fragment, std::vector<unsigned> textures);
  GlProgram program_;
  GlBuffer square_;
  std::vector<unsigned> textures_;
};

// The papers' layout: object to a buffer with colour and depth, camera's picture to another, then the compositing pass.
// Their fragments stay as they publish them: no response curve is undone and none applied, which costs less than ours.
class TwoBufferLayout {
 public:
  // `picture` is the camera's, a texture that outlives this. Errors: unsupported (no depth textures), device.
  static Result<TwoBufferLayout> create(const GlInfo& info, unsigned picture, const BenchScene& scene, GammaBy gamma);
  Result<> draw(const DrawTarget& target);

 private:
  TwoBufferLayout() = default;
  Result<> draw_object();

  BenchScene scene_;
  Projection projection_;
  DepthRange range_;
  Programs programs_;
  std::vector<GpuModel> model_;  // one
  GlTexture object_colour_, object_depth_, background_colour_;
  GlFramebuffer object_, background_;
  std::vector<ScreenPass> passes_;  // background, compositing
};

// A nearest-filtered texture of the picture; without pixels when `pixels` is null.
GlTexture make_picture_texture(int width, int height, const void* pixels);

}  // namespace kasumi

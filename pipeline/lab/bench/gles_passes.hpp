// Shaders over the whole screen: what the renderer is measured against, and its own sum over two nodes.
#pragma once

#include <string>
#include <vector>

#include "base/result.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/target.hpp"
#include "gles/gpu_model/projection.hpp"
#include "pipeline/lab/bench/gles_scene.hpp"

namespace kasumi {

// How Gamma is computed in each fragment. two_nodes: physics 4, six exponentials. The others: M Eq 11 as a sum over
// that many wavelengths, one exponential each; scattering coefficients from the wavelength (M Eq 15 and 18), whose
// constant factors, like q_c divided by its sum, come from the CPU.
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

}  // namespace kasumi

// The blur of haze as diffusion (H Sect 3; physics 9): a Gaussian whose width varies per pixel. This is the reference
// for the GPU's implementation.
//
// Light flows between a pixel x and its four neighbours x + u, of offset d: F(x) += sum g(x, x+u) (F(x+u) - F(x)). The
// three schemes differ in d and in the conductance g.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/result.hpp"

namespace kasumi {

// explicit_steps: H Eq 11-13, d = 1, g is the mean of the two rates. H prints Eq 8 with grad rho . F; the flux form
// used in Eq 11 is that of grad rho . grad F. invariant: H Eq 18 as printed, d = sigma_k(x), bilinear. It neither
// conserves light nor reaches the wanted width: a pass gives sigma^2 (1 + 2 rho), not sigma^2 e^{2 rho}. matched: ours.
// d is a whole number of pixels, the same for all pixels; the rate makes the pass's variance exact; a pixel takes part
// until its own variance is reached; g is the lesser of the two pixels' rates (what the sharper one still wants) and 0
// between two surfaces. Light is conserved.
enum class DiffusionScheme { explicit_steps, invariant, matched };
std::string_view name_of(DiffusionScheme scheme);  // "explicit", "invariant", "matched"
std::optional<DiffusionScheme> diffusion_scheme_named(std::string_view name);

constexpr double kLargestRate = 0.25;  // rho_max: beyond it the explicit scheme is not stable

// How blurred a picture is to become.
struct BlurMap {
  Image<float> sigma_px;  // wanted, >= inner_px
  double inner_px = 1.0;  // sigma_0: the picture's own
  // HazeRange::steps_*; empty: one surface. Only the matched scheme uses them.
  Image<float> steps_along_row, steps_down_column;
};

// One pass of the matched scheme: from a variance (beyond the picture's own) to one larger by `variance_px2`.
struct MatchedPass {
  int offset_px = 1;
  double from_px2 = 0.0;
  double variance_px2 = 0.0;
  // For a pixel with that wanted variance in total. <= kLargestRate.
  double rate(double wanted_px2) const;
};
// As many passes as the invariant scheme has. sigma grows with the square of the pass number: compared with a Gaussian,
// no width in between is worse than the ends (H's geometric growth: 1.6 times at the widest). Empty: nothing to do.
std::vector<MatchedPass> matched_passes(double inner_px, double widest_px);
// The number of passes by H Eq 13 and 18.
int passes_of(DiffusionScheme scheme, double inner_px, double widest_px);

// Up to the first difference of the steps' sums two pixels lie on one surface, from the second on they lie on two.
constexpr float kSameSurface = 0.02F, kOtherSurface = 0.04F;

struct DiffusionCost {
  int passes = 0;
  // Texels read per pixel and pass: its own and its neighbours' light and rate; four for each bilinear one.
  int taps = 0;
  double operations() const { return static_cast<double>(passes) * taps; }
};
DiffusionCost cost_of(DiffusionScheme scheme, double inner_px, double widest_px);

// `light`: any four values per pixel (premultiplied colour and transmission). The picture is mirrored at its edges (the
// invariant scheme clamps to the edge). Errors: bad_input (sizes, sigma below inner_px or not finite, a step of the
// matched scheme larger than the picture).
Result<Image<glm::vec4>> diffuse(DiffusionScheme scheme, const Image<glm::vec4>& light, const BlurMap& map);

}  // namespace kasumi

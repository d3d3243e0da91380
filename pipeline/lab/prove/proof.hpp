// A building of the site drawn into every picture under the air by other landmarks, and compared with the camera's
// picture.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "pipeline/lab/prove/air_by_others.hpp"
#include "pipeline/lab/prove/proof_inputs.hpp"

namespace kasumi {

// The air that it is drawn under: as estimated; none; the papers' T = 3; the one that suits all pictures best.
enum class ProofWay { told, no_air, fixed_t, constant };
inline constexpr std::array kProofWays{ProofWay::told, ProofWay::no_air, ProofWay::fixed_t, ProofWay::constant};
std::string_view name_of(ProofWay way);  // "told", "no_air", "fixed_t3", "best_constant"
constexpr double kPapersTurbidity = 3.0;

struct ProofEntry {
  std::size_t view = 0;   // in ProofInputs
  std::string air_class;  // of the list, or by the estimated air and the sun
  std::string left_out;   // why it is not judged; empty: it is
  bool clear = false;     // one of those that measure the facade, for the pictures of other days
  double sunlit = 0.0;    // cosine of the sun's incidence on the facade; 0: it is in the shade, or no place is known
  std::optional<double> sun_elevation_deg, sun_azimuth_deg;
  AirByOthers air;
  bool drawn = false;  // a facade was measured on other days
  // The facade's mean light as the camera encodes it, in 255ths.
  glm::dvec3 seen_255{0.0}, sigma_255{0.0};
  std::array<glm::dvec3, kProofWays.size()> drawn_255{};
  Image<Rgb8> part;              // its pixels as drawn under the estimated air
  double pixel_error_255 = 0.0;  // mean size of the difference of pixels, under the estimated air
  const glm::dvec3& drawn_by(ProofWay way) const { return drawn_255[static_cast<std::size_t>(way)]; }
  // Mean size of the channels' differences.
  double error_255(ProofWay way) const;
  bool judged() const { return drawn && left_out.empty(); }
};

struct Proof {
  ProofInputs scene;
  std::vector<ProofEntry> pictures;                   // one for each view
  int shaded_views = 0, lit_views = 0;                // that the facade was measured in
  glm::dvec3 shade{0.0}, shade_sigma{0.0}, lit{0.0};  // its mean L0 / Linf, by all clear days
  glm::dvec3 fixed_depth{0.0}, constant_per_m{0.0};
  std::vector<std::string> remarks;
};

// Errors (bad_input): read_proof_inputs'; too few clear pictures.
Result<Proof> prove(const ProveRequest& request);

}  // namespace kasumi

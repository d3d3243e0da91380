// What `kasumi estimate --haze` says of a photograph's haze: its colour, and how thick it is before a part of the picture.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "estimator/photograph/haze_colour.hpp"

namespace kasumi {

struct HazeQuestion {
  std::optional<HazyPart> part{};      // where the optical depth is asked for
  std::optional<double> distance_m{};  // of that part
  double altitude_m = 0.0;             // of the camera above the sea
};

struct HazeDepth {
  glm::dvec3 depth{0.0};
  double sigma = 0.0;  // of green
};

struct HazeAnswer {
  std::filesystem::path picture;
  HazeColour colour;
  glm::dvec3 from_infinity{};  // linear, of full scale
  bool from_sky = false;
  std::optional<HazeDepth> depth;  // from the camera to the part; nothing: no part, or haze hides it
  std::string doubt;               // for people: why the part yields no depth
  // With a distance: of green, what remains of it for the aerosol as the whole column's optical depth at 550 nm, and
  // its exponent; that of usual aerosol where the picture does not determine it.
  std::optional<double> extinction_per_m, sigma_per_m, aod_550;
  double exponent = 0.0;

  // The extinction before the part is not measurable: its visibility is only a bound.
  bool clear() const { return extinction_per_m && *extinction_per_m < 2.0 * *sigma_per_m; }
  bool useful() const { return colour.told || depth; }
};

// The pictures are taken for an sRGB camera's. With a part and its distance, the part is a landmark: those of one size
// are of one camera, and solved together (estimator/landmarks). Errors: bad_input (no picture).
std::vector<Result<HazeAnswer>> hazes_of(const std::vector<std::filesystem::path>& pictures,
                                         const HazeQuestion& question);
std::string haze_json(const HazeAnswer& answer);  // one object, with a line break
std::string haze_text(const HazeAnswer& answer);

}  // namespace kasumi

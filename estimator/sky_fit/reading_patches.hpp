// Readings gathered into small patches of sky, so that a fit costs the same for eighty readings and for a thousand.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "estimator/atmosphere.hpp"
#include "estimator/sky_fit/sky_reading.hpp"

namespace kasumi {

struct ReadingPatch {
  Direction direction{0.0, 0.0, 1.0};
  double sun_distance = 0.0;  // rad
  glm::dvec3 log_light{0.0};
  glm::dvec3 variance{0.0};  // of log_light, by the readings' own noise
  double off_axis = 0.0;
};

// Linear sRGB, any unit, of a sky near enough for its slopes within a patch to be the readings'.
using RadianceField = std::function<glm::dvec3(const Direction&)>;

class ReadingPatches {
 public:
  // Smaller near the sun and near the horizon, where light changes fast.
  ReadingPatches(std::span<const SkyReading> readings, const SunDirection& sun);

  std::size_t size() const { return centres_.size(); }
  const std::vector<Direction>& centres() const { return centres_; }
  // ln light of each patch: the median of its readings' ln(light / like), times `like` at the
  // centre; so what clouds leave in single readings has no weight.
  std::vector<ReadingPatch> gathered(std::span<const SkyReading> readings, const RadianceField& like) const;

 private:
  SunDirection sun_;
  std::vector<Direction> centres_;
  std::vector<std::vector<std::size_t>> members_;  // readings of each
};

}  // namespace kasumi

// Visibility from pictures of the scene camera, as `kasumi estimate --scene` reports it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "estimator/landmarks/channel_extinctions.hpp"
#include "pipeline/lab/photographs/measured_visibility.hpp"

namespace kasumi {

struct VisibilityReading {
  std::filesystem::path picture;
  std::vector<ContrastReading> readings;  // one for each landmark
  ChannelExtinctions air;

  bool usable() const { return air.extinction().kind != ExtinctionKind::nothing; }  // a bound is of use, too
};

struct VisibilitySeries {
  LandmarkWatch watch;
  std::vector<VisibilityReading> pictures;  // in the order given; those of a folder by name
};

// Pictures of one camera, or folders of them. The landmarks' intrinsic contrasts are estimated from all of them
// together. Only the readings are kept in memory. Errors (bad_input): the file of landmarks, a picture.
Result<VisibilitySeries> read_visibilities(const std::vector<std::filesystem::path>& pictures,
                                           const std::filesystem::path& landmarks);

// One JSON object; `sky`: the comparison with the sky camera at the same time; `check`: with an instrument.
std::string visibility_json(const LandmarkWatch& watch, const VisibilityReading& scene, const ExtinctionComparison* sky,
                            const VisibilityCheck* check = nullptr);
// Text for people.
std::string visibility_text(const LandmarkWatch& watch, const VisibilityReading& scene,
                            const ExtinctionComparison* sky);

}  // namespace kasumi

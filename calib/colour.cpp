#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/colorimetry.hpp"
#include "calib/radiometry.hpp"

namespace kasumi {
namespace {

// What three detectors see of the three components of daylight: one column per component.
template <class Detectors>
glm::dmat3 seen_of_daylight(const Detectors& detectors) {
  glm::dmat3 seen{0.0};
  for (double nm = kFirstVisible_nm; nm <= kLastVisible_nm; nm += 1.0)
    seen += glm::outerProduct(detectors(nm), daylight_components(nm));
  return seen;
}

glm::dmat3 camera_of_daylight(const SpectralSensitivity& sensitivity) {
  return seen_of_daylight([&](double nm) { return sensitivity.at(nm); });
}

}  // namespace

glm::dmat3 camera_to_xyz(const SpectralSensitivity& sensitivity) {
  return seen_of_daylight(colour_matching) * glm::inverse(camera_of_daylight(sensitivity));
}

bool separates_daylight(const SpectralSensitivity& sensitivity) {
  // The volume the channels' unit vectors span: 3.3e-3 to 8.2e-3 for measured cameras and the eye, 0 for a grey one.
  const auto channels = glm::transpose(camera_of_daylight(sensitivity));
  for (int c = 0; c < 3; ++c)
    if (!(glm::length(channels[c]) > 0.0)) return false;
  const glm::dmat3 units{glm::normalize(channels[0]), glm::normalize(channels[1]), glm::normalize(channels[2])};
  return std::abs(glm::determinant(units)) > 1e-5;
}

glm::dmat3 srgb_to_xyz() {
  // Rows as IEC 61966-2-1 prints them.
  return glm::transpose(glm::dmat3{0.4124, 0.3576, 0.1805,  //
                                   0.2126, 0.7152, 0.0722,  //
                                   0.0193, 0.1192, 0.9505});
}

}  // namespace kasumi

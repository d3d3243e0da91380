#include <cmath>

#include <Eigen/LU>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/colour/colorimetry.hpp"
#include "calib/colour/spectral_sensitivity.hpp"

namespace kasumi {
namespace {

// Responses of three detectors to the three components of daylight: one column per component.
template <class Detectors>
glm::dmat3 daylight_matrix(const Detectors& detectors) {
  glm::dmat3 responses{0.0};
  for (double nm = kFirstVisible_nm; nm <= kLastVisible_nm; nm += 1.0)
    responses += glm::outerProduct(detectors(nm), daylight_components(nm));
  return responses;
}

glm::dmat3 camera_of_daylight(const SpectralSensitivity& sensitivity) {
  return daylight_matrix([&](double nm) { return sensitivity.at(nm); });
}

}  // namespace

glm::dmat3 camera_to_xyz(const SpectralSensitivity& sensitivity) {
  return daylight_matrix(colour_matching) * glm::inverse(camera_of_daylight(sensitivity));
}

bool separates_daylight(const SpectralSensitivity& sensitivity) {
  // The volume the channels' unit vectors span: 3.3e-3 to 8.2e-3 for measured cameras and the eye, 0 for a grey one.
  const auto channels = glm::transpose(camera_of_daylight(sensitivity));
  for (int c = 0; c < 3; ++c)
    if (!(glm::length(channels[c]) > 0.0)) return false;
  const glm::dmat3 units{glm::normalize(channels[0]), glm::normalize(channels[1]), glm::normalize(channels[2])};
  return std::abs(glm::determinant(units)) > 1e-5;
}

glm::dmat3 srgb_reflectance_to_channels(const SpectralSensitivity& sensitivity) {
  constexpr double kStep_nm = 5.0;
  constexpr int kBands = 81;
  const auto white = [](double nm) { return daylight_spectrum(0.31272, 0.32903, nm); };  // D65
  const glm::dmat3 from_xyz = glm::inverse(srgb_to_xyz());

  // Rows: linear sRGB and camera channels of a reflectance spectrum, both 1 for a white surface.
  Eigen::Matrix<double, 3, kBands> srgb, channels;
  for (int i = 0; i < kBands; ++i) {
    const double nm = kFirstVisible_nm + kStep_nm * i;
    const glm::dvec3 in_srgb = white(nm) * (from_xyz * colour_matching(nm)), counted = white(nm) * sensitivity.at(nm);
    for (int c = 0; c < 3; ++c) {
      srgb(c, i) = in_srgb[c];
      channels(c, i) = counted[c];
    }
  }
  for (int c = 0; c < 3; ++c) {
    srgb.row(c) /= srgb.row(c).sum();
    channels.row(c) /= channels.row(c).sum();
  }

  // Least roughness under three constraints: [R A'; A 0] [spectrum; multipliers] = [0; rgb].
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(kBands + 3, kBands + 3);
  for (int i = 0; i + 1 < kBands; ++i) {
    system(i, i) += 1.0;
    system(i + 1, i + 1) += 1.0;
    system(i, i + 1) -= 1.0;
    system(i + 1, i) -= 1.0;
  }
  system.topRightCorner(kBands, 3) = srgb.transpose();
  system.bottomLeftCorner(3, kBands) = srgb;
  Eigen::MatrixXd colours = Eigen::MatrixXd::Zero(kBands + 3, 3);
  colours.bottomRows(3).setIdentity();
  const Eigen::Matrix3d channels_of_srgb = channels * system.fullPivLu().solve(colours).topRows(kBands);
  glm::dmat3 result;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) result[column][row] = channels_of_srgb(row, column);
  return result;
}

}  // namespace kasumi

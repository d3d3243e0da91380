#include "calib/colour/daylight_response.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {

double band_nm(int i) {
  return kFirstVisible_nm + kBandStep_nm * i;
}

const Eigen::Matrix<double, kBands, 3>& daylight_sums() {
  static const auto sums = [] {
    Eigen::Matrix<double, kBands, 3> result = Eigen::Matrix<double, kBands, 3>::Zero();
    for (double nm = kFirstVisible_nm; nm <= kLastVisible_nm; nm += 1.0) {
      const int i = std::min(static_cast<int>((nm - kFirstVisible_nm) / kBandStep_nm), kBands - 2);
      const double part = (nm - band_nm(i)) / kBandStep_nm;
      const auto s = daylight_components(nm);
      for (int k = 0; k < 3; ++k) {
        result(i, k) += (1.0 - part) * s[k];
        result(i + 1, k) += part * s[k];
      }
    }
    return result;
  }();
  return sums;
}

BandCurve curve_of(const SpectralSensitivity& sensitivity, int channel) {
  BandCurve curve;
  for (int i = 0; i < kBands; ++i) curve[i] = sensitivity.at(band_nm(i))[channel];
  return curve * (kBands / curve.sum());
}

std::array<BandCurve, 3> curves_of(const SpectralSensitivity& sensitivity) {
  return {curve_of(sensitivity, 0), curve_of(sensitivity, 1), curve_of(sensitivity, 2)};
}

DaylightResponse daylight_response_of(const std::array<BandCurve, 3>& curves) {
  DaylightResponse response;
  for (int c = 0; c < 3; ++c) {
    const Eigen::Vector3d sums = daylight_sums().transpose() * curves[static_cast<std::size_t>(c)];
    response[2 * c] = sums[1] / sums[0];
    response[2 * c + 1] = sums[2] / sums[0];
  }
  return response;
}

double log_response(const DaylightResponse& response, int channel, const DaylightWeights& spectrum) {
  return std::log(std::max(1e-6, 1.0 + spectrum.m1 * response[2 * channel] + spectrum.m2 * response[2 * channel + 1]));
}

glm::dvec2 log_ratios(const DaylightResponse& response, const DaylightWeights& spectrum) {
  const double green = log_response(response, 1, spectrum);
  return {log_response(response, kAgainstGreen[0], spectrum) - green,
          log_response(response, kAgainstGreen[1], spectrum) - green};
}

}  // namespace kasumi

#include "pipeline/lab/comparison/pixel_errors.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <opencv2/core/utility.hpp>

#include "base/colour_difference.hpp"
#include "calib/colour/colorimetry.hpp"
#include "calib/light/radiometry.hpp"

namespace kasumi {
namespace {

// Of each pair; equal pixels cost nothing.
std::vector<double> colour_differences(const std::vector<glm::vec3>& one, const std::vector<glm::vec3>& other) {
  const auto response = Response::srgb();
  const auto to_xyz = srgb_to_xyz();
  const auto lab = [&](const glm::vec3& encoded) { return lab_of(to_xyz * response.to_light(encoded), 1.0); };
  std::vector<double> differences(one.size(), 0.0);
  cv::parallel_for_(cv::Range(0, static_cast<int>(one.size())), [&](const cv::Range& part) {
    for (auto i = static_cast<std::size_t>(part.start); i < static_cast<std::size_t>(part.end); ++i)
      if (one[i] != other[i]) differences[i] = ciede2000(lab(one[i]), lab(other[i]));
  });
  return differences;
}

}  // namespace

PixelErrors pixel_errors(const Image<glm::vec3>& one, const Image<glm::vec3>& other, const CountedPixels& counted) {
  std::vector<glm::vec3> a, b;
  for (std::size_t i = 0; i < one.elements().size(); ++i)
    if (counted.empty() || counted.elements()[i] != 0) {
      a.push_back(one.elements()[i]);
      b.push_back(other.elements()[i]);
    }
  PixelErrors errors;
  errors.pixels = a.size();
  const double n = static_cast<double>(a.size());
  double absolute = 0.0, square = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const glm::dvec3 d = glm::dvec3(a[i]) - glm::dvec3(b[i]);
    absolute += std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
    errors.largest = std::max({errors.largest, 255.0 * std::abs(d.x), 255.0 * std::abs(d.y), 255.0 * std::abs(d.z)});
    square += glm::dot(d, d);
  }
  errors.mean_absolute = 255.0 * absolute / (3.0 * n);
  if (square > 0.0) errors.psnr_db = -10.0 * std::log10(square / (3.0 * n));
  auto differences = colour_differences(a, b);
  errors.ciede2000.mean = std::accumulate(differences.begin(), differences.end(), 0.0) / n;
  const auto at_95 = differences.begin() + static_cast<std::ptrdiff_t>(0.95 * (n - 1.0));
  std::nth_element(differences.begin(), at_95, differences.end());
  errors.ciede2000.at_95_percent = *at_95;
  errors.ciede2000.largest = *std::max_element(at_95, differences.end());
  return errors;
}

}  // namespace kasumi

#include "estimator/photograph/lens_drops.hpp"

#include <cmath>
#include <limits>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

// Chosen: a drop out of focus covers some tens of pixels; fineness compares neighbours with those eight pixels apart.
constexpr int kPart_px = 48, kCoarse_px = 8;
constexpr double kLeastDetail = 3.0 / 255.0;  // root mean square over eight pixels: less is noise and JPEG
// Of the usual fineness: chosen, a third less is visible and no change of light makes it.
constexpr float kBlurred = 2.0F / 3.0F;
// Chosen: the usual fineness is a median, which one blurred picture in five does not move.
constexpr std::size_t kFewestPictures = 5;

float fineness_at(const Image<glm::vec3>& encoded, int left, int top) {
  double fine = 0.0, coarse = 0.0;
  int count = 0;
  for (int y = top; y < top + kPart_px - kCoarse_px; ++y)
    for (int x = left; x < left + kPart_px - kCoarse_px; ++x) {
      const float here = encoded.at(x, y).g;
      const auto from = [&](int dx, int dy) { return std::pow(double{encoded.at(x + dx, y + dy).g - here}, 2); };
      fine += from(1, 0) + from(0, 1);
      coarse += from(kCoarse_px, 0) + from(0, kCoarse_px);
      ++count;
    }
  if (std::sqrt(0.5 * coarse / count) < kLeastDetail) return std::numeric_limits<float>::quiet_NaN();
  return static_cast<float>(std::sqrt(fine / coarse));
}

}  // namespace

DetailFineness fineness_of(const Image<glm::vec3>& encoded) {
  DetailFineness found{Image<float>(encoded.width() / kPart_px, encoded.height() / kPart_px)};
  for (int y = 0; y < found.parts.height(); ++y)
    for (int x = 0; x < found.parts.width(); ++x)
      found.parts.at(x, y) = fineness_at(encoded, x * kPart_px, y * kPart_px);
  return found;
}

std::vector<double> blurred_shares(std::span<const DetailFineness> pictures) {
  std::vector<double> blurred(pictures.size()), known(pictures.size());
  if (pictures.size() < kFewestPictures) return blurred;
  for (std::size_t part = 0; part < pictures.front().parts.elements().size(); ++part) {
    std::vector<float> values;
    for (const auto& picture : pictures)
      if (const float value = picture.parts.elements()[part]; std::isfinite(value)) values.push_back(value);
    if (2 * values.size() < pictures.size()) continue;
    const float usual = median(std::move(values));
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const float value = pictures[i].parts.elements()[part];
      if (!std::isfinite(value)) continue;
      known[i] += 1.0;
      if (value < kBlurred * usual) blurred[i] += 1.0;
    }
  }
  for (std::size_t i = 0; i < pictures.size(); ++i) blurred[i] = known[i] > 0.0 ? blurred[i] / known[i] : 0.0;
  return blurred;
}

}  // namespace kasumi

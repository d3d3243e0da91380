#include "pipeline/kiosk/snapshot/blurred_picture.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/vec3.hpp>

namespace kasumi {
namespace {

constexpr double kReachSigmas = 3.0;

// The weights by which one mean takes a row of pixels; they add up to 1.
struct MeanWeights {
  int first = 0;
  std::vector<float> weights;
};

// Of `means` along `pixels`, evenly spread.
std::vector<MeanWeights> mean_weights(int pixels, int means, double sigma_px) {
  std::vector<MeanWeights> all;
  for (int i = 0; i < means; ++i) {
    const double centre = (i + 0.5) * pixels / means - 0.5;
    MeanWeights of;
    of.first = std::clamp(static_cast<int>(std::ceil(centre - kReachSigmas * sigma_px)), 0, pixels - 1);
    const int last = std::clamp(static_cast<int>(std::floor(centre + kReachSigmas * sigma_px)), of.first, pixels - 1);
    double sum = 0.0;
    for (int x = of.first; x <= last; ++x) {
      const double z = (x - centre) / sigma_px;
      sum += std::exp(-0.5 * z * z);
      of.weights.push_back(static_cast<float>(std::exp(-0.5 * z * z)));
    }
    for (float& weight : of.weights) weight /= static_cast<float>(sum);
    all.push_back(std::move(of));
  }
  return all;
}

}  // namespace

Image<Rgb8> blurred_beyond_recognition(const Image<Rgb8>& picture) {
  if (picture.empty()) return {};
  const int longer = std::max(picture.width(), picture.height());
  const double sigma_px = static_cast<double>(longer) / kBlurredPixels;
  const auto means_of = [&](int pixels) { return std::max(1, static_cast<int>(std::lround(pixels / sigma_px))); };
  const int width = means_of(picture.width()), height = means_of(picture.height());
  const auto across = mean_weights(picture.width(), width, sigma_px);
  const auto down = mean_weights(picture.height(), height, sigma_px);

  Image<glm::vec3> rows(width, picture.height());
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < width; ++x) {
      const auto& of = across[static_cast<std::size_t>(x)];
      const Rgb8* pixel = picture.row(y) + of.first;
      for (const float weight : of.weights) rows.at(x, y) += weight * glm::vec3(*pixel++);
    }
  Image<Rgb8> blurred(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto& of = down[static_cast<std::size_t>(y)];
      glm::vec3 mean(0.5F);  // to round
      for (std::size_t i = 0; i < of.weights.size(); ++i)
        mean += of.weights[i] * rows.at(x, of.first + static_cast<int>(i));
      blurred.at(x, y) = Rgb8(mean);
    }
  return blurred;
}

}  // namespace kasumi

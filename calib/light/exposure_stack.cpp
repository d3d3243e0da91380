#include "calib/light/exposure_stack.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "base/statistics.hpp"

namespace kasumi {

namespace {

// Where the rim is: the circle that was given, else the picture's corners.
std::pair<glm::dvec2, double> reach_of(const std::vector<double>& circle, const glm::ivec2& size) {
  if (!circle.empty()) return {{circle[0], circle[1]}, circle[2]};
  const glm::dvec2 centre = 0.5 * (glm::dvec2(size) - 1.0);
  return {centre, glm::length(centre)};
}

}  // namespace

KnownStack known_exposures(ExposureStack stack, const std::vector<double>& exposures_s, double percent,
                           const glm::dvec3& black, const Image<std::uint8_t>& mask) {
  KnownStack known;
  if (!exposures_s.empty()) {
    for (const double seconds : exposures_s) stack.log_s.push_back(std::log(seconds));
    known.exposures = {stack.log_s, 0.01 * percent, true};
    known.stack = std::move(stack);
    return known;
  }
  const auto samples = sample_stack(stack.pictures, stack.quantum, black, mask, kStackPixels);
  const auto order = by_brightness(samples);
  const auto ratios = linear_ratios(samples, order);
  // The longest run of neighbours that overlap.
  std::size_t first = 0, length = 0;
  for (std::size_t from = 0; from < ratios.size(); ++from) {
    std::size_t to = from;
    while (to < ratios.size() && ratios[to]) ++to;
    if (to - from > length) {
      first = from;
      length = to - from;
    }
  }
  double log_s = 0.0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k < first || k > first + length) {
      known.left_out.push_back(stack.names[order[k]]);
      continue;
    }
    if (k > first) log_s += std::log(*ratios[k - 1]);
    known.stack.pictures.push_back(std::move(stack.pictures[order[k]]));
    known.stack.names.push_back(stack.names[order[k]]);
    known.stack.log_s.push_back(log_s);
  }
  known.stack.quantum = stack.quantum;
  known.exposures = {known.stack.log_s, 0.0, false};
  return known;
}

Image<std::uint8_t> circle_mask(const std::vector<double>& circle, const glm::ivec2& size) {
  if (circle.empty()) return {};
  Image<std::uint8_t> mask(size.x, size.y);
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) mask.at(x, y) = std::hypot(x - circle[0], y - circle[1]) < circle[2] ? 255 : 0;
  return mask;
}

DarkFrame measure_dark_frame(const std::vector<Image<glm::vec3>>& pictures, double quantum) {
  DarkFrame dark;
  if (pictures.empty()) return dark;
  const auto size = pictures.front().elements().size();
  std::vector<glm::dvec3> mean(size, glm::dvec3(0.0));
  for (const auto& picture : pictures)
    for (std::size_t i = 0; i < size; ++i)
      mean[i] += glm::dvec3(picture.elements()[i]) / static_cast<double>(pictures.size());
  for (int c = 0; c < 3; ++c) {
    // The mean of the middle half: a median of whole steps is a whole step.
    std::vector<double> values;
    for (const auto& value : mean) values.push_back(value[c]);
    std::sort(values.begin(), values.end());
    double sum = 0.0;
    for (std::size_t i = size / 4; i < size - size / 4; ++i) sum += values[i];
    dark.black[c] = sum / static_cast<double>(size - 2 * (size / 4));
    for (auto& value : values) value = std::abs(value - dark.black[c]);
    dark.hot_above =
        std::max(dark.hot_above, std::max(8.0 * quantum, 10.0 * kSigmaOverMedianSize * median(std::move(values))));
  }
  const int width = pictures.front().width();
  for (std::size_t i = 0; i < size; ++i)
    if (glm::any(glm::greaterThan(mean[i] - dark.black, glm::dvec3(dark.hot_above))))
      dark.hot.push_back({static_cast<int>(i) % width, static_cast<int>(i) / width});
  return dark;
}

Result<VignettingFit> fit_flat_fields(const std::vector<Image<glm::vec3>>& flats, const Response& response,
                                      const std::vector<double>& circle, const Image<std::uint8_t>& mask) {
  std::vector<Image<float>> lights;
  for (const auto& flat : flats) {
    Image<float> light(flat.width(), flat.height());
    for (std::size_t i = 0; i < light.elements().size(); ++i) {
      const auto& encoded = flat.elements()[i];
      const bool usable = std::max({encoded.x, encoded.y, encoded.z}) < static_cast<float>(kSaturated);
      light.elements()[i] = usable ? static_cast<float>(response.to_light(glm::dvec3(encoded)).y) : 0.0f;
    }
    lights.push_back(std::move(light));
  }
  const auto [centre, radius_px] = reach_of(circle, {flats.front().width(), flats.front().height()});
  return fit_vignetting(lights, mask, centre, radius_px);
}

}  // namespace kasumi

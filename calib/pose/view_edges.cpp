#include "calib/pose/view_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <glm/geometric.hpp>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

constexpr int kFieldsAcross = 24, kFieldsDown = 14, kPerField = 2;
constexpr int kReach = 8;               // px along the normal, either way
constexpr int kSteps = 4 * kReach + 1;  // half a pixel each
constexpr int kPlateau = 7;             // steps at either end that are the dark and the bright side
constexpr double kMinEdgeContrast = 0.06;
constexpr double kMaxRoughness = 0.2;      // deviation of a side, over the step
constexpr double kMinContrastKept = 0.15;  // of the contrast it had
constexpr int kMinEdges = 12;
constexpr double kDarkShare = 0.03;

double sample(const Image<float>& from, glm::dvec2 at) {
  const int x = static_cast<int>(at.x), y = static_cast<int>(at.y);
  const double fx = at.x - x, fy = at.y - y;
  const float *a = from.row(y) + x, *b = from.row(y + 1) + x;
  return (1 - fy) * ((1 - fx) * double{a[0]} + fx * double{a[1]}) + fy * ((1 - fx) * double{b[0]} + fx * double{b[1]});
}

struct Step {
  double spread_px, contrast, roughness, height;
};

double mean_of(const Image<float>& light) {
  double sum = 0.0;
  for (const float value : light.elements()) sum += double{value};
  return std::max(1e-9, sum / static_cast<double>(light.elements().size()));
}

// Along the normal, the mean over five parallel lines. Empty: out of the picture, or no step.
std::optional<Step> measure(const Image<float>& light, const glm::dvec2& pixel, const glm::dvec2& normal) {
  const double margin = kReach + 4.0;
  if (!(pixel.x > margin && pixel.y > margin && pixel.x < light.width() - 1 - margin &&
        pixel.y < light.height() - 1 - margin))
    return std::nullopt;
  const glm::dvec2 along{-normal.y, normal.x};
  std::array<double, kSteps> profile{};
  for (int i = 0; i < kSteps; ++i)
    for (int j = -2; j <= 2; ++j)
      profile[static_cast<std::size_t>(i)] +=
          0.2 * sample(light, pixel + (0.5 * i - kReach) * normal + 0.75 * j * along);
  const auto side = [&](int from) {
    double sum = 0.0, squares = 0.0;
    for (int i = from; i < from + kPlateau; ++i) {
      sum += profile[static_cast<std::size_t>(i)];
      squares += std::pow(profile[static_cast<std::size_t>(i)], 2);
    }
    const double mean = sum / kPlateau;
    return std::pair{mean, std::sqrt(std::max(0.0, squares / kPlateau - mean * mean))};
  };
  const auto [dark, dark_rough] = side(0);
  const auto [bright, bright_rough] = side(kSteps - kPlateau);
  const double step = bright - dark;
  if (!(step > 0.0) || !(bright > 0.0)) return std::nullopt;
  double steepest = 0.0;  // light per pixel
  for (std::size_t i = 8; i + 9 < profile.size(); ++i) steepest = std::max(steepest, profile[i + 1] - profile[i - 1]);
  if (!(steepest > 0.0)) return std::nullopt;
  return Step{step / steepest / std::sqrt(2.0 * std::numbers::pi), step / (bright + std::max(0.0, dark)),
              std::max(dark_rough, bright_rough) / step, step};
}

}  // namespace

std::vector<ViewEdge> find_edges(const Image<float>& light, const Image<std::uint8_t>& usable) {
  const cv::Mat linear(light.height(), light.width(), CV_32F, const_cast<float*>(light.elements().data()));
  cv::Mat soft, gx, gy, slope;
  cv::GaussianBlur(linear, soft, {}, 1.0);
  cv::Sobel(soft, gx, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(soft, gy, CV_32F, 0, 1, 3, 0.125);
  cv::magnitude(gx, gy, slope);
  slope /= soft + 0.01 * cv::mean(soft)[0];
  std::vector<ViewEdge> edges;
  const double mean = mean_of(light);
  const int wide = std::max(1, light.width() / kFieldsAcross), high = std::max(1, light.height() / kFieldsDown);
  for (int top = 0; top + high <= light.height(); top += high)
    for (int left = 0; left + wide <= light.width(); left += wide) {
      // The steepest places of the field, far enough from each other to be two.
      struct Place {
        float slope;
        int x, y;
      };
      std::vector<Place> places;
      for (int y = top; y < top + high; ++y)
        for (int x = left; x < left + wide; ++x)
          if (usable.empty() || usable.at(x, y)) places.push_back({slope.at<float>(y, x), x, y});
      std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
        return std::tuple(-a.slope, a.y, a.x) < std::tuple(-b.slope, b.y, b.x);
      });
      std::vector<ViewEdge> found;
      for (std::size_t i = 0; i < std::min<std::size_t>(places.size(), 40) && found.size() < kPerField; ++i) {
        const auto& place = places[i];
        const glm::dvec2 pixel{place.x, place.y};
        if (std::any_of(found.begin(), found.end(),
                        [&](const ViewEdge& edge) { return glm::distance(edge.pixel, pixel) < 2 * kReach; }))
          continue;
        const glm::dvec2 gradient{gx.at<float>(place.y, place.x), gy.at<float>(place.y, place.x)};
        if (!(glm::length(gradient) > 0.0)) break;
        const auto normal = glm::normalize(gradient);
        const auto step = measure(light, pixel, normal);
        if (!step || step->contrast < kMinEdgeContrast || step->roughness > kMaxRoughness || step->spread_px > 4.0)
          continue;
        found.push_back({pixel, normal, step->spread_px, step->contrast, step->height / mean});
      }
      edges.insert(edges.end(), found.begin(), found.end());
    }
  return edges;
}

std::optional<EdgeChange> compare_edges(const Lens& lens, std::span<const ViewEdge> reference, const ViewTurn& turn,
                                        const Image<float>& light) {
  const auto moved = [&](const glm::dvec2& pixel) -> std::optional<glm::dvec2> {
    const auto ray = lens.unproject(pixel);
    return ray ? lens.project(turned(turn, *ray)) : std::nullopt;
  };
  EdgeChange change;
  std::vector<double> ratios, before, now, contrasts, steps;
  const double mean = mean_of(light);
  for (const auto& edge : reference) {
    const auto pixel = moved(edge.pixel), along_normal = moved(edge.pixel + 4.0 * edge.normal);
    const double margin = kReach + 5.0;
    if (!pixel || !along_normal ||
        !(pixel->x > margin && pixel->y > margin && pixel->x < light.width() - margin - 1 &&
          pixel->y < light.height() - margin - 1))
      continue;
    ++change.sought;
    const auto step = measure(light, *pixel, glm::normalize(*along_normal - *pixel));
    const double contrast = step ? step->contrast / edge.contrast : 0.0;
    contrasts.push_back(contrast);
    steps.push_back(step ? step->height / mean / edge.step : 0.0);
    if (contrast < kMinContrastKept) continue;
    ratios.push_back(step->spread_px / edge.spread_px);
    before.push_back(edge.spread_px);
    now.push_back(step->spread_px);
  }
  if (change.sought < kMinEdges) return std::nullopt;
  change.edges = static_cast<int>(ratios.size());
  change.contrast_ratio = median(contrasts);
  std::sort(steps.begin(), steps.end());
  change.step_low = steps[steps.size() / 5];
  change.step_high = steps[steps.size() - 1 - steps.size() / 5];
  if (change.edges < kMinEdges) return change;
  change.spread_ratio = median(ratios);
  auto deviations = ratios;
  for (auto& value : deviations) value = std::abs(value - change.spread_ratio);
  change.spread_sigma =
      kMedianErrorOverMeanError * kSigmaOverMedianSize * median(deviations) / std::sqrt(double(ratios.size()));
  change.before_px = median(before);
  change.now_px = median(now);
  return change;
}

std::optional<Veil> compare_veil(const Lens& lens, const ShrunkView& reference, const ShrunkView& now,
                                 const ViewTurn& turn) {
  struct Place {
    double then, now;
  };
  std::vector<Place> places;
  double sum_then = 0.0, sum_now = 0.0;
  const auto& light_then = reference.light;
  for (int y = 0; y < light_then.height(); ++y)
    for (int x = 0; x < light_then.width(); ++x) {
      if (!reference.usable.empty() && !reference.usable.at(x, y)) continue;
      const auto ray = lens.unproject(reference.pixel(x, y));
      const auto pixel = ray ? lens.project(turned(turn, *ray)) : std::nullopt;
      if (!pixel) continue;
      const auto at = glm::ivec2(glm::round((*pixel + 0.5) / double(reference.factor) - 0.5));
      if (!now.light.contains(at.x, at.y)) continue;
      const double a = double{light_then.at(x, y)}, b = double{now.light.at(at.x, at.y)};
      places.push_back({a, b});
      sum_then += a;
      sum_now += b;
    }
  const auto count = static_cast<std::size_t>(kDarkShare * static_cast<double>(places.size()));
  if (count < 20 || !(sum_then > 0.0) || !(sum_now > 0.0)) return std::nullopt;
  std::nth_element(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(count), places.end(),
                   [](const Place& a, const Place& b) { return a.then < b.then; });
  std::vector<double> then_dark, now_dark;
  for (std::size_t i = 0; i < count; ++i) {
    then_dark.push_back(places[i].then);
    now_dark.push_back(places[i].now);
  }
  const double size = static_cast<double>(places.size());
  return Veil{median(then_dark) / (sum_then / size), median(now_dark) / (sum_now / size)};
}

}  // namespace kasumi

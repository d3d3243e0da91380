#include "calib/pose/view_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

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
constexpr std::size_t kFewestDark = 20, kMostDark = 500;

bool is_seen(const Lens& lens, const ShrunkView& view, int x, int y) {
  return (view.usable.empty() || view.usable.at(x, y)) && lens.unproject(unshrunk(x, y, view.factor));
}

double mean_seen(const Lens& lens, const ShrunkView& view) {
  double sum = 0.0;
  std::size_t seen = 0;
  for (int y = 0; y < view.light.height(); ++y)
    for (int x = 0; x < view.light.width(); ++x)
      if (is_seen(lens, view, x, y)) {
        sum += double{view.light.at(x, y)};
        ++seen;
      }
  return seen > 0 ? sum / static_cast<double>(seen) : 0.0;
}

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

std::optional<DarkPlaces> darkest_places(const Lens& lens, const ShrunkView& view) {
  std::vector<std::pair<float, glm::ivec2>> all;
  for (int y = 0; y < view.light.height(); ++y)
    for (int x = 0; x < view.light.width(); ++x)
      if (is_seen(lens, view, x, y)) all.emplace_back(view.light.at(x, y), glm::ivec2{x, y});
  const auto count = static_cast<std::size_t>(kDarkShare * static_cast<double>(all.size()));
  const double mean = mean_seen(lens, view);
  if (count < kFewestDark || !(mean > 0.0)) return std::nullopt;
  const auto last = all.begin() + static_cast<std::ptrdiff_t>(count);
  std::nth_element(all.begin(), last, all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  all.erase(last, all.end());
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return std::tie(a.second.y, a.second.x) < std::tie(b.second.y, b.second.x);
  });
  DarkPlaces dark;
  std::vector<double> light;
  const std::size_t apart = (count + kMostDark - 1) / kMostDark;
  for (std::size_t i = 0; i < count; ++i) {
    light.push_back(double{all[i].first});
    if (i % apart == 0) dark.places.push_back(all[i].second);
  }
  dark.light = median(std::move(light)) / mean;
  return dark;
}

std::optional<Veil> compare_veil(const Lens& lens, const DarkPlaces& reference, const ShrunkView& now,
                                 const ViewTurn& turn) {
  std::vector<double> light;
  for (const auto& place : reference.places) {
    const auto ray = lens.unproject(unshrunk(place.x, place.y, now.factor));
    const auto pixel = ray ? lens.project(turned(turn, *ray)) : std::nullopt;
    if (!pixel) continue;
    const auto at = glm::ivec2(glm::round((*pixel + 0.5) / double(now.factor) - 0.5));
    if (now.light.contains(at.x, at.y)) light.push_back(double{now.light.at(at.x, at.y)});
  }
  const double mean = mean_seen(lens, now);
  if (light.size() < kFewestDark || !(mean > 0.0)) return std::nullopt;
  return Veil{reference.light, median(std::move(light)) / mean};
}

}  // namespace kasumi

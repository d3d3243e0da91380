#include "estimator/proof/same_view.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

constexpr int kAcross = 1000;
constexpr double kClearest = 0.25;     // of the pictures may be the reference
constexpr double kLeftAlone_px = 0.3;  // at the corners
constexpr int kGrid_px = 16;           // of the way from picture to picture, in between it is straight

glm::dmat3 matrix_of(const glm::dvec3& turn) {
  const double angle = glm::length(turn);
  return angle < 1e-15 ? glm::dmat3{1.0} : glm::mat3_cast(glm::angleAxis(angle, turn / angle));
}

glm::dvec3 turn_of(const glm::dmat3& matrix) {
  const auto turn = glm::quat_cast(matrix);
  const double half = std::acos(std::clamp(turn.w, -1.0, 1.0)), sine = std::sin(half);
  return sine < 1e-12 ? glm::dvec3{0.0} : glm::dvec3{turn.x, turn.y, turn.z} * (2.0 * half / sine);
}

double strength_of(const ViewLines& lines) {
  const auto& all = lines.strength.elements();
  return all.empty() ? 0.0 : std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size());
}

// Those with the clearest lines first.
std::vector<std::size_t> by_clearness(std::span<const ViewLines> views) {
  std::vector<double> strength;
  for (const auto& view : views) strength.push_back(strength_of(view));
  std::vector<std::size_t> order(views.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater{}, [&](std::size_t i) { return strength[i]; });
  return order;
}

std::vector<PlacedView> turns_from(const Lens& lens, std::span<const ViewLines> views, std::size_t reference) {
  std::vector<PlacedView> placed(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (i == reference) {
      placed[i] = {glm::dvec3{0.0}, true, 1.0};
    } else if (const auto turn = find_turn(lens, views[reference], views[i])) {
      placed[i] = {turn->turn, true, turn->agreement};
    }
  }
  return placed;
}

glm::dvec3 middle_of(const std::vector<PlacedView>& views) {
  glm::dvec3 middle;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> turns;
    for (const auto& view : views)
      if (view.seen) turns.push_back(view.turn[k]);
    middle[k] = median(std::move(turns));
  }
  return middle;
}

void follow_neighbours(std::vector<PlacedView>& views) {
  const auto known = views;
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t away = 1; !known[i].seen && away < views.size(); ++away) {
      if (i >= away && known[i - away].seen) {
        views[i].turn = known[i - away].turn;
        break;
      }
      if (i + away < views.size() && known[i + away].seen) {
        views[i].turn = known[i + away].turn;
        break;
      }
    }
  }
}

}  // namespace

ViewLines lines_of_picture(const Lens& lens, const Image<glm::vec3>& encoded) {
  const int factor = std::max(1, encoded.width() / kAcross);
  ShrunkView view{Image<float>(encoded.width() / factor, encoded.height() / factor), factor, {}};
  for (int y = 0; y < view.light.height(); ++y)
    for (int x = 0; x < view.light.width(); ++x) {
      float sum = 0.0F;
      for (int j = 0; j < factor; ++j)
        for (int i = 0; i < factor; ++i) {
          const float green = encoded.at(x * factor + i, y * factor + j).g;
          sum += green * green;  // near enough to light: lines know no brightness
        }
      view.light.at(x, y) = sum / static_cast<float>(factor * factor);
    }
  return lines_of(lens, view);
}

std::optional<SameViews> place_views(const Lens& lens, std::span<const ViewLines> views,
                                     std::optional<std::size_t> reference) {
  if (views.empty()) return std::nullopt;
  const auto order = by_clearness(views);
  SameViews same{reference.value_or(order.front()), {}};
  same.views = turns_from(lens, views, same.reference);
  if (views.size() > 1 && std::ranges::count(same.views, true, &PlacedView::seen) < 2) return std::nullopt;
  if (!reference) {
    const auto middle = middle_of(same.views);
    const auto most = std::max<std::size_t>(1, static_cast<std::size_t>(kClearest * static_cast<double>(order.size())));
    for (std::size_t k = 0; k < most; ++k) {
      const auto &one = same.views[order[k]], &best = same.views[same.reference];
      if (one.seen && glm::length(one.turn - middle) < glm::length(best.turn - middle)) same.reference = order[k];
    }
    const auto back = glm::transpose(matrix_of(same.views[same.reference].turn));
    for (auto& view : same.views)
      if (view.seen) view.turn = turn_of(matrix_of(view.turn) * back);
  }
  follow_neighbours(same.views);
  return same;
}

Image<glm::vec3> turned_back(const Lens& lens, const Image<glm::vec3>& encoded, const glm::dvec3& turn) {
  const int width = encoded.width(), height = encoded.height();
  const auto matrix = matrix_of(turn);
  cv::Mat1f to_x(height / kGrid_px + 2, width / kGrid_px + 2), to_y(to_x.size());
  double farthest_px = 0.0;
  for (int j = 0; j < to_x.rows; ++j)
    for (int i = 0; i < to_x.cols; ++i) {
      const glm::dvec2 pixel{i * kGrid_px, j * kGrid_px};
      const auto ray = lens.unproject(pixel);
      const auto at = ray ? lens.project(matrix * *ray) : std::nullopt;
      const auto shift = at ? *at - pixel : glm::dvec2{0.0};
      to_x(j, i) = static_cast<float>(shift.x);
      to_y(j, i) = static_cast<float>(shift.y);
      farthest_px = std::max(farthest_px, glm::length(shift));
    }
  if (farthest_px < kLeftAlone_px) return encoded;
  cv::Mat1f map_x(height, width), map_y(height, width);
  const auto between = [](const cv::Mat1f& grid, int x, int y) {
    const int i = x / kGrid_px, j = y / kGrid_px;
    const float u = static_cast<float>(x % kGrid_px) / kGrid_px, v = static_cast<float>(y % kGrid_px) / kGrid_px;
    return (1 - v) * ((1 - u) * grid(j, i) + u * grid(j, i + 1)) + v * ((1 - u) * grid(j + 1, i) + u * grid(j + 1, i + 1));
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      map_x(y, x) = static_cast<float>(x) + between(to_x, x, y);
      map_y(y, x) = static_cast<float>(y) + between(to_y, x, y);
    }
  const cv::Mat from(height, width, CV_32FC3, const_cast<glm::vec3*>(encoded.elements().data()));
  Image<glm::vec3> back(width, height);
  cv::Mat to(height, width, CV_32FC3, back.elements().data());
  cv::remap(from, to, map_x, map_y, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  return back;
}

}  // namespace kasumi

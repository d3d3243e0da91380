#include "estimator/photograph/same_view.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

constexpr int kAcross = 1000;          // elements: lines stay sharp, and larger pictures cost no more
constexpr double kClearest = 0.25;     // of the pictures may be the reference
constexpr double kLeftAlone_px = 0.3;  // at the corners
constexpr double kSoft = 1.2;          // of lines, in elements of the shrunk picture
// The whole view may have jumped by this share of its sides, a part of it by so many elements more.
constexpr double kLargestJump = 0.08;
// Elements: wide enough to hold distinct lines, small enough that a part moves as one.
constexpr int kPart = 64, kPartJump = 6, kPartStep = 48;
constexpr double kSameWhole = 0.12, kSamePart = 0.5;  // correlations
constexpr double kLinesInPart = 1.5;                  // mean strength, of ViewLines::kStrongest: less is sky
constexpr int kFewestParts = 5;
constexpr double kAgree = 1.0;  // elements
constexpr int kRefinements = 8;

cv::Mat1f soft_lines(const ViewLines& lines) {
  const auto& strength = lines.strength;
  const cv::Mat bytes(strength.height(), strength.width(), CV_8U,
                      const_cast<std::uint8_t*>(strength.elements().data()));
  cv::Mat1f soft;
  bytes.convertTo(soft, CV_32F);
  cv::GaussianBlur(soft, soft, {}, kSoft);
  return soft;
}

// The vertex of a parabola through three values, from the middle one.
double vertex(double before, double middle, double after) {
  const double bent = before - 2.0 * middle + after;
  return bent < 0.0 ? std::clamp(0.5 * (before - after) / bent, -0.5, 0.5) : 0.0;
}

struct Match {
  glm::dvec2 shift{0.0};
  double likeness = 0.0;
};

// Of `box` in `now`, around a shift.
std::optional<Match> match(const cv::Mat1f& reference, const cv::Mat1f& now, const cv::Rect& box,
                           const cv::Point& around, int jump_x, int jump_y) {
  const cv::Rect whole(0, 0, now.cols, now.rows);
  const cv::Rect search(box.x + around.x - jump_x, box.y + around.y - jump_y, box.width + 2 * jump_x,
                        box.height + 2 * jump_y);
  const auto inside = search & whole;
  if (inside.width < box.width + 2 || inside.height < box.height + 2) return std::nullopt;
  cv::Mat1f score;
  cv::matchTemplate(now(inside), reference(box), score, cv::TM_CCOEFF_NORMED);
  double most = 0.0;
  cv::Point best;
  cv::minMaxLoc(score, nullptr, &most, nullptr, &best);
  if (!std::isfinite(most)) return std::nullopt;
  glm::dvec2 fine{0.0};
  if (best.x > 0 && best.x + 1 < score.cols)
    fine.x = vertex(double{score(best.y, best.x - 1)}, most, double{score(best.y, best.x + 1)});
  if (best.y > 0 && best.y + 1 < score.rows)
    fine.y = vertex(double{score(best.y - 1, best.x)}, most, double{score(best.y + 1, best.x)});
  return Match{glm::dvec2{best.x + inside.x - box.x, best.y + inside.y - box.y} + fine, most};
}

struct PartMove {
  glm::dvec2 from, to;
};

// Least squares, weighted.
ViewMove fitted(const std::vector<PartMove>& parts, const std::vector<double>& weights) {
  double sum = 0.0;
  glm::dvec2 from{0.0}, to{0.0};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    sum += weights[i];
    from += weights[i] * parts[i].from;
    to += weights[i] * parts[i].to;
  }
  from /= sum;
  to /= sum;
  double dots = 0.0, crosses = 0.0, squares = 1e-9;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto a = parts[i].from - from, b = parts[i].to - to;
    dots += weights[i] * glm::dot(a, b);
    crosses += weights[i] * (a.x * b.y - a.y * b.x);
    squares += weights[i] * glm::dot(a, a);
  }
  ViewMove move;
  move.along = {dots / squares, crosses / squares};
  move.shift = to - (move.at(from) - move.shift);
  return move;
}

// The move most parts agree on.
std::optional<ViewMove> agreed(const std::vector<PartMove>& parts) {
  if (static_cast<int>(parts.size()) < kFewestParts) return std::nullopt;
  std::vector<double> x, y;
  for (const auto& part : parts) {
    x.push_back(part.to.x - part.from.x);
    y.push_back(part.to.y - part.from.y);
  }
  ViewMove move;
  move.shift = {median(std::move(x)), median(std::move(y))};
  double reach = 4.0 * kAgree;
  for (int i = 0; i < kRefinements; ++i, reach = std::max(kAgree, 0.7 * reach)) {
    std::vector<double> weights;
    int near = 0;
    for (const auto& part : parts) {
      const double off = glm::distance(move.at(part.from), part.to);
      weights.push_back(tukey_weight(off / (2.0 * reach)));
      near += off <= reach;
    }
    if (near < kFewestParts || 3 * near < static_cast<int>(parts.size())) return std::nullopt;
    move = fitted(parts, weights);
  }
  return move;
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

glm::dvec2 middle_of(const std::vector<PlacedView>& views, const glm::dvec2& pixel) {
  std::vector<double> x, y;
  for (const auto& view : views)
    if (view.seen) {
      x.push_back(view.move.at(pixel).x);
      y.push_back(view.move.at(pixel).y);
    }
  return {median(std::move(x)), median(std::move(y))};
}

void follow_neighbours(std::vector<PlacedView>& views) {
  const auto known = views;
  for (std::size_t i = 0; i < views.size(); ++i)
    for (std::size_t away = 1; !known[i].seen && away < views.size(); ++away) {
      const bool before = i >= away && known[i - away].seen, after = i + away < views.size() && known[i + away].seen;
      if (!before && !after) continue;
      views[i].move = known[before ? i - away : i + away].move;
      break;
    }
}

}  // namespace

ViewLines lines_of_picture(const Lens& lens, const Image<glm::vec3>& encoded) {
  const int factor = std::max(1, static_cast<int>(std::lround(1.0 * encoded.width() / kAcross)));
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

ViewMove inverse_of(const ViewMove& move) {
  const double square = glm::dot(move.along, move.along);
  ViewMove back{{move.along.x / square, -move.along.y / square}, glm::dvec2{0.0}};
  back.shift = -back.at(move.shift);
  return back;
}

ViewMove joined(const ViewMove& outer, const ViewMove& inner) {
  const auto &a = outer.along, &b = inner.along;
  return {{a.x * b.x - a.y * b.y, a.y * b.x + a.x * b.y}, outer.at(inner.shift)};
}

std::optional<ViewMove> find_move(const ViewLines& reference, const ViewLines& now) {
  if (reference.strength.width() != now.strength.width() || reference.strength.height() != now.strength.height())
    return std::nullopt;
  const auto then = soft_lines(reference), is = soft_lines(now);
  const int jump_x = std::max(8, static_cast<int>(kLargestJump * then.cols)),
            jump_y = std::max(8, static_cast<int>(kLargestJump * then.rows));
  if (then.cols < 4 * jump_x || then.rows < 4 * jump_y) return std::nullopt;
  const cv::Rect inner(jump_x, jump_y, then.cols - 2 * jump_x, then.rows - 2 * jump_y);
  const auto whole = match(then, is, inner, {0, 0}, jump_x, jump_y);
  if (!whole || whole->likeness < kSameWhole) return std::nullopt;
  const cv::Point around(static_cast<int>(std::lround(whole->shift.x)), static_cast<int>(std::lround(whole->shift.y)));
  std::vector<PartMove> parts;
  const int side = std::min(kPart, then.rows / 2);
  for (int y = 0; y + side <= then.rows; y += std::min(kPartStep, side))
    for (int x = 0; x + side <= then.cols; x += kPartStep) {
      const cv::Rect box(x, y, side, side);
      if (cv::mean(then(box))[0] < kLinesInPart) continue;
      const auto found = match(then, is, box, around, kPartJump, kPartJump);
      if (!found || found->likeness < kSamePart) continue;
      const glm::dvec2 middle{x + 0.5 * (side - 1), y + 0.5 * (side - 1)};
      parts.push_back({middle, middle + found->shift});
    }
  auto move = agreed(parts);
  if (!move) return std::nullopt;
  // From elements of the shrunk pictures to pixels: p = f (e + 1/2) - 1/2.
  const double factor = reference.factor;
  const auto corner = move->at(glm::dvec2{0.5 / factor - 0.5});
  move->shift = factor * (corner + 0.5) - 0.5;
  return move;
}

std::optional<SameViews> place_views(std::span<const ViewLines> views, std::optional<std::size_t> reference) {
  if (views.empty()) return std::nullopt;
  const auto order = by_clearness(views);
  SameViews same{reference.value_or(order.front()), std::vector<PlacedView>(views.size())};
  for (std::size_t i = 0; i < views.size(); ++i)
    if (i == same.reference)
      same.views[i].seen = true;
    else if (const auto move = find_move(views[same.reference], views[i]))
      same.views[i] = {*move, true};
  if (views.size() > 1 && std::ranges::count(same.views, true, &PlacedView::seen) < 2) return std::nullopt;
  if (!reference) {
    const auto& lines = views.front();
    const glm::dvec2 pixel = 0.5 * lines.factor * glm::dvec2{lines.strength.width(), lines.strength.height()};
    const auto middle = middle_of(same.views, pixel);
    const auto away = [&](std::size_t i) { return glm::distance(same.views[i].move.at(pixel), middle); };
    const auto most = std::max<std::size_t>(1, static_cast<std::size_t>(kClearest * static_cast<double>(order.size())));
    for (std::size_t k = 0; k < most; ++k)
      if (same.views[order[k]].seen && away(order[k]) < away(same.reference)) same.reference = order[k];
    const auto back = inverse_of(same.views[same.reference].move);
    for (auto& view : same.views)
      if (view.seen) view.move = joined(view.move, back);
  }
  follow_neighbours(same.views);
  return same;
}

Image<glm::vec3> moved_back(const Image<glm::vec3>& encoded, const ViewMove& move) {
  const int width = encoded.width(), height = encoded.height();
  double farthest_px = 0.0;
  for (const double x : {0.0, width - 1.0})
    for (const double y : {0.0, height - 1.0})
      farthest_px = std::max(farthest_px, glm::distance(move.at({x, y}), glm::dvec2{x, y}));
  if (farthest_px < kLeftAlone_px) return encoded;
  const cv::Matx23d there(move.along.x, -move.along.y, move.shift.x, move.along.y, move.along.x, move.shift.y);
  const cv::Mat from(height, width, CV_32FC3, const_cast<glm::vec3*>(encoded.elements().data()));
  Image<glm::vec3> back(width, height);
  cv::Mat to(height, width, CV_32FC3, back.elements().data());
  cv::warpAffine(from, to, there, {width, height}, cv::INTER_CUBIC | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  return back;
}

}  // namespace kasumi

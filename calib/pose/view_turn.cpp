#include "calib/pose/view_turn.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

constexpr int kSmallest_px = 50;  // sides of a view that is compared
constexpr std::array kBlur_px{6.0, 3.0, 1.2};
constexpr int kIterations = 12;
constexpr int kBesideRim_px = 5;  // the pattern ends there, and its end does not move
constexpr int kPartsAcross = 16;
constexpr double kMinPartCorrelation = 0.5;  // correlation within a part that is taken for the same
constexpr double kMinAgreement = 0.25;
constexpr int kMinParts = 6, kMinInPart = 16;
constexpr int kMinPoints = 200;
constexpr double kMinSigma_px = 0.02;  // no picture is compared better, however well it happens to agree
constexpr int kCoarseFactor = 4;       // the search for a start is made on so much smaller pictures

cv::Mat mat_of(const Image<float>& image) {
  return cv::Mat(image.height(), image.width(), CV_32F, const_cast<float*>(image.elements().data())).clone();
}

cv::Mat mat_of(const Image<std::uint8_t>& image) {
  const cv::Mat bytes(image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.elements().data()));
  cv::Mat floats;
  bytes.convertTo(floats, CV_32F, 1.0 / ViewLines::kStrongest);
  return floats;
}

glm::dmat3 rotation(const glm::dvec3& turn) {
  const double angle = glm::length(turn);
  if (angle < 1e-15) return glm::dmat3{1.0};
  return glm::mat3_cast(glm::angleAxis(angle, turn / angle));
}

struct Point {
  glm::dvec3 ray;
  int x = 0, y = 0;
  int part = 0;
};

class Comparison {
 public:
  Comparison(const Lens& lens, const ViewLines& reference, const ViewLines& now)
      : lens_(lens),
        view_(reference),
        seen_(mat_of(seen_by(lens, reference.strength.width(), reference.strength.height(), reference.factor))),
        reference_(mat_of(reference.strength)),
        now_(mat_of(now.strength)) {
    choose_points();
  }
  bool enough() const { return points_.size() >= kMinPoints; }

  std::optional<ViewTurn> solve() {
    std::optional<ViewTurn> best;
    for (const auto& begin : {glm::dvec3{0.0}, start()}) {
      auto found = solve_from(begin);
      if (found && (!best || found->agreement > best->agreement)) best = std::move(found);
    }
    return best;
  }

 private:
  std::optional<ViewTurn> solve_from(glm::dvec3 turn) {
    for (const double blur_px : kBlur_px) {
      prepare(blur_px);
      for (int i = 0; i < kIterations; ++i) {
        const auto step = improve(turn, nullptr);
        if (!step) return std::nullopt;
        turn += *step;
        if (glm::length(*step) < 1e-3 * pixel_angle_) break;
      }
    }
    ViewTurn found;
    if (!improve(turn, &found.covariance)) return std::nullopt;
    const double least = kMinSigma_px * pixel_angle_;
    for (int i = 0; i < 3; ++i) found.covariance[i][i] += least * least;
    found.turn = turn;
    std::tie(found.agreement, found.parts) = agreement(turn);
    if (found.parts < kMinParts || found.agreement < kMinAgreement) return std::nullopt;
    return found;
  }

  // Points with the steepest gradients: only these reveal a shift.
  void choose_points() {
    cv::Mat soft, gx, gy, slope;
    cv::GaussianBlur(reference_, soft, {}, 1.2);
    cv::Sobel(soft, gx, CV_32F, 1, 0);
    cv::Sobel(soft, gy, CV_32F, 0, 1);
    cv::magnitude(gx, gy, slope);
    std::vector<float> slopes;
    cv::Mat inside;
    cv::erode(seen_, inside, {}, {-1, -1}, kBesideRim_px, cv::BORDER_REPLICATE);
    const auto usable = [&](int x, int y) {
      return inside.at<float>(y, x) > 0.0f && (view_.usable.empty() || view_.usable.at(x, y) != 0);
    };
    for (int y = 2; y < slope.rows - 2; y += 2)
      for (int x = 2; x < slope.cols - 2; x += 2)
        if (usable(x, y)) slopes.push_back(slope.at<float>(y, x));
    if (slopes.size() < kMinPoints) return;
    const float least = median(std::move(slopes));
    const int side = std::max(8, slope.cols / kPartsAcross);
    for (int y = 2; y < slope.rows - 2; ++y)
      for (int x = 2 + y % 2; x < slope.cols - 2; x += 2) {
        if (!usable(x, y) || slope.at<float>(y, x) < least) continue;
        const auto ray = lens_.unproject(pixel(x, y));
        if (ray) points_.push_back({glm::normalize(*ray), x, y, (y / side) * (kPartsAcross + 2) + x / side});
      }
    const auto axis = lens_.project({0.0, 0.0, 1.0}), off_axis = lens_.project({1e-3, 0.0, 1.0});
    if (axis && off_axis) pixel_angle_ = 1e-3 * view_.factor / std::max(1e-9, glm::distance(*axis, *off_axis));
  }

  void prepare(double blur_px) {
    cv::GaussianBlur(reference_, soft_reference_, {}, blur_px);
    cv::GaussianBlur(now_, soft_now_, {}, blur_px);
    cv::Sobel(soft_now_, gradient_x_, CV_32F, 1, 0, 3, 0.125);
    cv::Sobel(soft_now_, gradient_y_, CV_32F, 0, 1, 3, 0.125);
  }

  glm::dvec2 pixel(double x, double y) const { return unshrunk(x, y, view_.factor); }
  // In elements of the shrunk picture.
  std::optional<glm::dvec2> place(const glm::dvec3& ray) const {
    const auto pixel = lens_.project(ray);
    if (!pixel) return std::nullopt;
    const auto at = (*pixel + 0.5) / double(view_.factor) - 0.5;
    if (at.x < 1 || at.y < 1 || at.x > now_.cols - 2 || at.y > now_.rows - 2) return std::nullopt;
    return at;
  }
  static double sample(const cv::Mat& from, const glm::dvec2& at) {
    const int x = static_cast<int>(at.x), y = static_cast<int>(at.y);
    const double fx = at.x - x, fy = at.y - y;
    const float *a = from.ptr<float>(y) + x, *b = from.ptr<float>(y + 1) + x;
    return (1 - fy) * ((1 - fx) * double{a[0]} + fx * double{a[1]}) +
           fy * ((1 - fx) * double{b[0]} + fx * double{b[1]});
  }

  struct Row {
    glm::dvec3 slope;
    double residual;
    int part;
  };
  // One step of Gauss and Newton with Tukey's weights.
  std::optional<glm::dvec3> improve(const glm::dvec3& turn, glm::dmat3* covariance) const {
    const auto turn_now = rotation(turn);
    constexpr double kDelta = 1e-4;
    const std::array nudges{rotation({kDelta, 0, 0}), rotation({0, kDelta, 0}), rotation({0, 0, kDelta})};
    std::vector<Row> rows;
    rows.reserve(points_.size());
    std::vector<double> residuals;
    for (const auto& point : points_) {
      const glm::dvec3 ray = turn_now * point.ray;
      const auto at = place(ray);
      if (!at) continue;
      const glm::dvec2 gradient{sample(gradient_x_, *at), sample(gradient_y_, *at)};
      Row row{{}, sample(soft_now_, *at) - double{soft_reference_.at<float>(point.y, point.x)}, point.part};
      bool whole = true;
      for (int k = 0; k < 3; ++k) {
        const auto moved = place(nudges[static_cast<std::size_t>(k)] * ray);
        whole = whole && moved;
        if (moved) row.slope[k] = glm::dot(gradient, *moved - *at) / kDelta;
      }
      if (!whole) continue;
      rows.push_back(row);
      residuals.push_back(row.residual);
    }
    if (rows.size() < kMinPoints) return std::nullopt;
    const double bound = kTukeyReach * std::max(1e-3, robust_sigma(std::move(residuals)));
    glm::dmat3 normal{0.0};
    glm::dvec3 right{0.0};
    std::vector<glm::dvec3> sums(kPartsAcross * 64 + 64);
    for (const auto& row : rows) {
      const double u = row.residual / bound;
      if (std::abs(u) >= 1.0) continue;
      const double weight = tukey_weight(u);
      normal += weight * glm::outerProduct(row.slope, row.slope);
      right -= weight * row.residual * row.slope;
      if (static_cast<std::size_t>(row.part) < sums.size())
        sums[static_cast<std::size_t>(row.part)] += weight * row.residual * row.slope;
    }
    const double size = normal[0][0] + normal[1][1] + normal[2][2];
    if (!(size > 0.0) || !(std::abs(glm::determinant(normal)) > 1e-12 * size * size * size)) return std::nullopt;
    const auto inverse = glm::inverse(normal);
    if (covariance) {
      glm::dmat3 scatter{0.0};
      for (const auto& sum : sums) scatter += glm::outerProduct(sum, sum);
      *covariance = inverse * scatter * inverse;
    }
    const auto step = inverse * right;
    const double length = glm::length(step), longest = 10.0 * pixel_angle_;
    return length > longest ? step * (longest / length) : step;
  }

  // Correlation of the two patterns over all points, for the choice of a start.
  double likeness(const glm::dvec3& turn) const {
    const auto turn_now = rotation(turn);
    double ab = 0.0, aa = 1e-9, bb = 1e-9;
    for (std::size_t i = 0; i < points_.size(); i += 3) {
      const auto at = place(turn_now * points_[i].ray);
      if (!at) continue;
      const double a = sample(soft_now_, *at), b = soft_reference_.at<float>(points_[i].y, points_[i].x);
      ab += a * b;
      aa += a * a;
      bb += b * b;
    }
    return ab / std::sqrt(aa * bb);
  }

  // Start of the search: unchanged, shifted, or rotated about the axis, whichever correlates best.
  glm::dvec3 start() {
    prepare(kBlur_px[0]);
    std::vector<glm::dvec3> candidates{glm::dvec3{0.0}};
    cv::Mat small_reference, small_now;
    cv::resize(reference_, small_reference, {}, 1.0 / kCoarseFactor, 1.0 / kCoarseFactor, cv::INTER_AREA);
    cv::resize(now_, small_now, {}, 1.0 / kCoarseFactor, 1.0 / kCoarseFactor, cv::INTER_AREA);
    const int x = small_reference.cols / 5, y = small_reference.rows / 5;
    const cv::Rect inner(x, y, small_reference.cols - 2 * x, small_reference.rows - 2 * y);
    if (inner.width > 8 && inner.height > 8) {
      cv::Mat score;
      cv::matchTemplate(small_now, small_reference(inner), score, cv::TM_CCOEFF_NORMED);
      cv::Point best;
      cv::minMaxLoc(score, nullptr, nullptr, nullptr, &best);
      const glm::dvec2 middle{reference_.cols / 2.0, reference_.rows / 2.0};
      const auto from = lens_.unproject(pixel(middle.x, middle.y)),
                 to = lens_.unproject(
                     pixel(middle.x + kCoarseFactor * (best.x - x), middle.y + kCoarseFactor * (best.y - y)));
      if (from && to) candidates.push_back(glm::cross(glm::normalize(*from), glm::normalize(*to)));
    }
    for (int half_deg = -20; half_deg <= 20; ++half_deg)
      candidates.push_back({0.0, 0.0, from_degrees(0.5 * half_deg).value});
    const auto best = std::max_element(candidates.begin(), candidates.end(),
                                       [&](const auto& a, const auto& b) { return likeness(a) < likeness(b); });
    return *best;
  }

  std::pair<double, int> agreement(const glm::dvec3& turn) const {
    struct Sums {
      double n = 0, a = 0, b = 0, ab = 0, aa = 0, bb = 0;
    };
    std::vector<Sums> parts(kPartsAcross * 64 + 64);
    const auto turn_now = rotation(turn);
    for (const auto& point : points_) {
      const auto at = place(turn_now * point.ray);
      if (!at || static_cast<std::size_t>(point.part) >= parts.size()) continue;
      auto& part = parts[static_cast<std::size_t>(point.part)];
      const double a = sample(soft_now_, *at), b = soft_reference_.at<float>(point.y, point.x);
      part.n += 1;
      part.a += a;
      part.b += b;
      part.ab += a * b;
      part.aa += a * a;
      part.bb += b * b;
    }
    int full = 0, same = 0;
    for (const auto& part : parts) {
      if (part.n < kMinInPart) continue;
      ++full;
      const double covariance = part.ab - part.a * part.b / part.n;
      const double aa = part.aa - part.a * part.a / part.n, bb = part.bb - part.b * part.b / part.n;
      if (covariance > kMinPartCorrelation * std::sqrt(std::max(1e-12, aa * bb))) ++same;
    }
    return {full > 0 ? double(same) / full : 0.0, full};
  }

  const Lens& lens_;
  const ViewLines& view_;
  cv::Mat seen_, reference_, now_, soft_reference_, soft_now_, gradient_x_, gradient_y_;
  std::vector<Point> points_;
  double pixel_angle_ = 1e-3;
};

}  // namespace

Radians ViewTurn::angle() const {
  return {glm::length(turn)};
}

Radians ViewTurn::sigma() const {
  const double length = glm::length(turn);
  if (length < 1e-12) return {std::sqrt((covariance[0][0] + covariance[1][1] + covariance[2][2]) / 3.0)};
  const auto along = turn / length;
  return {std::sqrt(std::max(0.0, glm::dot(along, covariance * along)))};
}

glm::dvec3 turned(const ViewTurn& turn, const glm::dvec3& ray) {
  return rotation(turn.turn) * ray;
}

std::optional<ViewTurn> find_turn(const Lens& lens, const ViewLines& reference, const ViewLines& now) {
  const int width = reference.strength.width(), height = reference.strength.height();
  if (width != now.strength.width() || height != now.strength.height() || width < kSmallest_px || height < kSmallest_px)
    return std::nullopt;
  Comparison comparison(lens, reference, now);
  if (!comparison.enough()) return std::nullopt;
  return comparison.solve();
}

}  // namespace kasumi

#include "estimator/sky_camera/aureole_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Dense>
#include <glm/geometric.hpp>

#include "base/square.hpp"
#include "base/statistics.hpp"

namespace kasumi {

namespace {

// Of the aureole by distance, a quadratic sky, and the sun's place.
constexpr int kRadialTerms = 4, kSkyTerms = kRadialTerms + 6, kFitTerms = kSkyTerms + 2;
// Jackknife: sigma of the sun's place from leaving out 30 deg of azimuth at a time.
constexpr std::size_t kFitSectors = 12;
constexpr Radians kFarthestSpot = from_degrees(50.0);  // beyond, a quadratic in direction is no sky
using Row = Eigen::Matrix<double, kFitTerms, 1>;
using Square = Eigen::Matrix<double, kFitTerms, kFitTerms>;

struct Spot {
  glm::vec3 direction;
  float light;  // ln, of the dimmest channel
  bool clipped;
  float share;  // weight: the elements that it stands for
};

struct Around {
  glm::dvec2 offset{};  // in the plane
  double distance = 0.0;
  std::size_t sector = 0;
};

class Touching {  // the plane that touches the sphere at a point; distances from it are kept
 public:
  explicit Touching(const glm::dvec3& point) : point_(point) {
    const glm::dvec3 other = std::abs(point.z) < 0.9 ? glm::dvec3{0.0, 0.0, 1.0} : glm::dvec3{1.0, 0.0, 0.0};
    a_ = glm::normalize(glm::cross(point, other));
    b_ = glm::cross(point, a_);
  }
  Around seen(const glm::vec3& direction) const {
    const glm::dvec3 d(direction);
    const glm::dvec2 flat{glm::dot(d, a_), glm::dot(d, b_)};
    const double sine = glm::length(flat);
    Around around;
    around.distance = std::atan2(sine, glm::dot(d, point_));
    around.offset = sine > 1e-9 ? flat * (around.distance / sine) : glm::dvec2{0.0};
    around.sector = sector_of(flat);
    return around;
  }
  glm::dvec3 at(const glm::dvec2& offset) const { return glm::normalize(point_ + offset.x * a_ + offset.y * b_); }

 private:
  // Of 30 deg each, counter-clockwise from the negative x axis: without an arc tangent.
  static std::size_t sector_of(const glm::dvec2& flat) {
    static_assert(kFitSectors == 12);
    // 1 / sqrt(3), sqrt(3).
    constexpr double kTan30 = 0.57735026918962576, kTan60 = 1.7320508075688773;
    const double x = std::abs(flat.x), y = std::abs(flat.y);
    const std::size_t from_axis = y < kTan30 * x ? 0 : y < kTan60 * x ? 1 : 2;
    if (flat.y < 0.0) return flat.x < 0.0 ? from_axis : 5 - from_axis;
    return flat.x < 0.0 ? 11 - from_axis : 6 + from_axis;
  }

  glm::dvec3 point_, a_, b_;
};

double bisquare(double x) {
  const double u = std::max(0.0, 1.0 - x * x);
  return u * u;
}

// The lower half, to which the solver looks, in blocks of four columns.
void add_product(Square& sum, double weight, const Row& row) {
  static_assert(kFitTerms == 12);
  const Row weighted = weight * row;
  sum.block<12, 4>(0, 0).noalias() += weighted * row.segment<4>(0).transpose();
  sum.block<8, 4>(4, 4).noalias() += weighted.segment<8>(4) * row.segment<4>(4).transpose();
  sum.block<4, 4>(8, 8).noalias() += weighted.segment<4>(8) * row.segment<4>(8).transpose();
}

// Distance at which half of the surroundings are no longer clipped.
double clipped_radius(const CoarseMaps& sky, const std::vector<Spot>& spots, const std::vector<Around>& seen) {
  std::array<double, 80> clipped{}, all{};
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const auto ring = static_cast<std::size_t>(seen[i].distance / sky.resolution.value);
    if (ring >= all.size()) continue;
    const auto share = static_cast<double>(spots[i].share);
    all[ring] += share;
    if (spots[i].clipped) clipped[ring] += share;
  }
  for (std::size_t ring = 0; ring < all.size(); ++ring)
    if (all[ring] > 0.0 && clipped[ring] < 0.5 * all[ring]) return static_cast<double>(ring) * sky.resolution.value;
  return static_cast<double>(all.size()) * sky.resolution.value;
}

struct Radial {
  double softened;  // ln(distance + this)
  double scale;
  std::array<double, kRadialTerms> at(double distance) const {
    const double u = std::log((distance + softened) / scale);
    return {1.0, u, u * u, u * u * u};
  }
  // d / d distance of the sum with these factors
  double slope(double distance, const Row& x) const {
    const double u = std::log((distance + softened) / scale);
    return (x[1] + 2.0 * x[2] * u + 3.0 * x[3] * u * u) / (distance + softened);
  }
};

// A thin sky grows brighter towards the horizon as the air along the view does, 1 / cos zenith; a thick one less.
float added_by_horizon(float cosine_of_zenith) {
  // Between a thin sky's 1 and a thick one's 0; the cosine's floor keeps the horizon finite.
  constexpr float kShare = 0.6f, kLeastCosine = 0.1f;
  return -kShare * std::log(std::max(cosine_of_zenith, 0.0f) + kLeastCosine);
}

// What is known of the sky within the widest reach of a direction; far from it every second row and column will do.
std::vector<Spot> spots_around(const CoarseMaps& sky, const SunDirection& direction, bool less_horizon) {
  // The aureole is steep within 10 deg; farther out a quarter of the elements shows as much.
  constexpr int kThinning = 2;
  const auto dense = static_cast<float>(std::cos(from_degrees(10.0).value));
  const auto farthest = static_cast<float>(std::cos(kFarthestSpot.value));
  std::vector<Spot> spots;
  for (int y = 0; y < sky.open.height(); ++y)
    for (int x = 0; x < sky.open.width(); ++x) {
      if (sky.open.at(x, y) == 0) continue;
      const glm::vec3& d = sky.direction.at(x, y);
      const float cosine = glm::dot(d, glm::vec3(direction));
      if (cosine < farthest) continue;
      const bool thinned = cosine < dense;
      if (thinned && (x % kThinning != 0 || y % kThinning != 0)) continue;
      const float light = sky.dimmest.at(x, y) - (less_horizon ? added_by_horizon(d.z) : 0.0f);
      spots.push_back({d, light, sky.clipped.at(x, y) != 0, thinned ? 1.0f * kThinning * kThinning : 1.0f});
    }
  return spots;
}

// The fit, one round after the other.
class Fitting {
 public:
  Fitting(const CoarseMaps& sky, const SunDirection& start, const AureoleReach& limits)
      : sky_(sky),
        limits_(limits),
        element_(sky.resolution.value),
        spots_(spots_around(sky, start, limits.less_horizon)),
        centre_(start) {}

  // False: too little is seen around the centre.
  bool round(bool moves) {
    const Touching plane(centre_);
    seen_.clear();
    for (const Spot& spot : spots_) seen_.push_back(plane.seen(spot.direction));
    hole_ = clipped_radius(sky_, spots_, seen_);
    if (hole_ > from_degrees(40.0).value) return false;
    reach_ = std::min(kFarthestSpot.value, (1.0 + limits_.wide) * hole_ + limits_.further.value);
    inner_ = std::max(hole_, 1.5 * element_);
    radial_ = {0.7 * element_, 1.5 * inner_};
    gather(moves);
    if (left_.size() < 40 || !(total_ > 0.0)) return false;
    factors_ = solved_without(kFitSectors);
    if (!factors_.allFinite()) return false;
    glm::dvec2 step{factors_[kSkyTerms], factors_[kSkyTerms + 1]};
    step_ = glm::length(step);
    const double longest = std::max(from_degrees(1.0).value, 0.4 * inner_);
    if (step_ > longest) step *= longest / step_;
    centre_ = plane.at(step);
    window_ = std::max(kNarrowest, std::min(0.75 * window_, moves ? 4.0 * scatter() : window_));
    return true;
  }
  const SunDirection& centre() const { return centre_; }
  double step() const { return step_; }

  AureoleFit result() {
    AureoleFit fit;
    fit.centre = centre_;
    fit.hole = Radians{hole_};
    fit.explained = explained_;
    double jackknife = 0.0;
    for (std::size_t k = 0; k < kFitSectors; ++k) {
      if (normal_[k](0, 0) <= 0.002 * total_) continue;
      const Row apart = solved_without(k) - factors_;
      jackknife += 0.5 * (square(apart[kSkyTerms]) + square(apart[kSkyTerms + 1]));
    }
    fit.sigma = Radians{std::sqrt(jackknife)};
    const double rim = inner_ + element_, far = std::min(reach_, inner_ + from_degrees(10.0).value);
    fit.rim = Radians{rim};
    fit.fall = -radial_.slope(rim, factors_) * rim;
    fit.rise = light_at(rim) - light_at(far);
    fit.above = light_at(rim) - sky_.middle;
    fit.clipped = own_share_of_clipped();
    return fit;
  }

 private:
  static constexpr double kWidest = 1.5, kNarrowest = 0.3;  // windows of Tukey's weights, ln light

  // The terms at a place. The last two are the derivatives of the light there by the sun's place.
  Row terms_at(const Around& around, bool moves) const {
    Row row;
    const auto f = radial_.at(around.distance);
    for (int k = 0; k < kRadialTerms; ++k) row[k] = f[static_cast<std::size_t>(k)];
    const glm::dvec2 o = around.offset / inner_;
    const double further = glm::length(o);
    row[4] = o.x;  // slope
    row[5] = o.y;
    row[6] = o.x * o.x - o.y * o.y;  // saddle
    row[7] = 2.0 * o.x * o.y;
    row[8] = o.x * further;  // a slope that grows with the distance
    row[9] = o.y * further;
    row[10] = row[11] = 0.0;
    if (!moves) return row;
    const double least = 0.2 / (around.distance + radial_.softened);
    const double fall = std::max(least, -radial_.slope(around.distance, factors_));
    const glm::dvec2 away = around.offset / std::max(around.distance, 1e-6);
    row[10] = fall * away.x;
    row[11] = fall * away.y;
    return row;
  }

  void gather(bool moves) {
    constexpr double kFollows = 0.15;  // ln light
    for (auto& n : normal_) n.setZero();
    for (auto& r : right_) r.setZero();
    left_.clear();
    double follow = 0.0, all = 0.0;
    for (std::size_t i = 0; i < spots_.size(); ++i) {
      const Spot& spot = spots_[i];
      const Around& around = seen_[i];
      if (around.distance > reach_) continue;
      const Row row = terms_at(around, moves);
      const auto value = static_cast<double>(spot.light);
      const double residual = moves ? value - row.head<kSkyTerms>().dot(factors_.head<kSkyTerms>()) : 0.0;
      // A clipped place is ignored where the fit is already above the clipping level.
      if (spot.clipped && (!moves || residual < 0.0)) continue;
      const double area = static_cast<double>(spot.share) / square(around.distance + element_);
      if (!spot.clipped) {
        all += area;
        if (moves && std::abs(residual) < kFollows) follow += area;
        left_.push_back(static_cast<float>(std::abs(residual)));
      }
      const double weight = area * (moves ? bisquare(residual / window_) : 1.0);
      if (weight <= 0.0) continue;
      add_product(normal_[around.sector], weight, row);
      right_[around.sector] += weight * value * row;
    }
    total_ = 0.0;
    for (const auto& n : normal_) total_ += n(0, 0);
    explained_ = all > 0.0 ? follow / all : 0.0;
    moves_ = moves;
  }

  Row solved_without(std::size_t left_out) const {
    // The sky's own terms are about 1/rad and 1/rad^2.
    const double slope = 0.01 / square(inner_), bend = 0.01 / square(square(inner_));
    const double move = moves_ && !limits_.held ? 1e-3 : 1e6;
    Square n = Square::Zero();
    n.diagonal() << 1e-6, 1e-4, 1e-2, 1e-2, slope, slope, bend, bend, bend, bend, move, move;
    n *= total_;
    Row r = Row::Zero();
    for (std::size_t k = 0; k < kFitSectors; ++k) {
      if (k == left_out) continue;
      n += normal_[k];
      r += right_[k];
    }
    return n.ldlt().solve(r);
  }

  double scatter() { return kSigmaOverMedianSize * static_cast<double>(median_in_place(left_)); }
  double light_at(double distance) const {
    const auto f = radial_.at(distance);
    double sum = 0.0;
    for (std::size_t k = 0; k < kRadialTerms; ++k) sum += factors_[static_cast<int>(k)] * f[k];
    return sum;
  }
  double own_share_of_clipped() const {
    const Touching plane(centre_);
    constexpr double kFew = 4.0;  // elements: as good as none
    double own = 0.0;
    for (const Spot& spot : spots_)
      if (spot.clipped && plane.seen(spot.direction).distance < 1.3 * inner_ + 2.0 * element_)
        own += static_cast<double>(spot.share);
    return (own + kFew) / (std::max(own, sky_.clipped_elements) + kFew);
  }

  const CoarseMaps& sky_;
  AureoleReach limits_;
  double element_;  // [rad]
  std::vector<Spot> spots_;
  std::vector<Around> seen_;  // the spots, from the centre of this round
  SunDirection centre_;
  double hole_ = 0.0, inner_ = 0.0, reach_ = 0.0, step_ = 0.0;  // [rad]
  double window_ = kWidest;
  bool moves_ = false;
  Radial radial_{};
  Row factors_ = Row::Zero();
  std::array<Square, kFitSectors> normal_{};
  std::array<Row, kFitSectors> right_{};
  std::vector<float> left_;  // residuals, without sign
  double total_ = 0.0, explained_ = 0.0;
};

}  // namespace

std::optional<AureoleFit> fit_aureole(const CoarseMaps& sky, const SunDirection& start, const AureoleReach& limits) {
  // The reach shrinks with the rounds, so at least eight; then until a step is below .03 deg.
  constexpr int kMostRounds = 12, kLeastRounds = 8;
  Fitting fitting(sky, start, limits);
  for (int round = 0; round < kMostRounds; ++round) {
    if (!fitting.round(round > 0)) return std::nullopt;
    if (round + 1 >= kLeastRounds && fitting.step() < from_degrees(0.03).value) break;
  }
  if (angle_between(fitting.centre(), start) > from_degrees(25.0)) return std::nullopt;
  return fitting.result();
}

}  // namespace kasumi

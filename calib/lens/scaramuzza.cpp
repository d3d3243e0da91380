#include <algorithm>
#include <cmath>
#include <cstddef>

#include "calib/lens/fisheye.hpp"
#include "calib/lens/polynomial.hpp"

namespace kasumi {
namespace {

// The angle from the axis that a radius rho in the image plane sees: tan(theta) = rho / forward(rho).
struct AngleOfRadius {
  Polynomial forward;  // the model's polynomial with z along the optical axis
  Polynomial gain;     // forward - rho forward': d theta / d rho = gain / (rho^2 + forward^2)

  explicit AngleOfRadius(const Polynomial& polynomial) : forward(scaled(polynomial, -1.0)), gain(forward) {
    for (std::size_t i = 0; i < gain.size(); ++i) gain[i] *= 1.0 - static_cast<double>(i);
  }
  double operator()(double rho) const { return std::atan2(rho, evaluate(forward, rho)); }
  double slope(double rho) const {
    const double ahead = evaluate(forward, rho);
    return evaluate(gain, rho) / (rho * rho + ahead * ahead);
  }
  double radius(double angle, double largest_radius) const {
    return solve_increasing(
        *this, [this](double rho) { return slope(rho); }, angle, 0.0, largest_radius);
  }
};

struct Reach {
  double angle;
  double radius;
};

// As far as the angle grows with the radius; beyond, two radii would see one angle. A hair short of the turn itself,
// where the inverse would lose half its digits.
Reach reach(const AngleOfRadius& angle, double largest_angle) {
  const double focal = std::abs(angle.forward.front());
  const double end = 0.9999 * first_positive_root(angle.gain).value_or(1e9 * focal);
  double radius = std::min(focal, end);
  while (radius < end && angle(radius) < largest_angle) radius = std::min(2.0 * radius, end);
  if (angle(radius) <= largest_angle) return {angle(radius), radius};
  return {largest_angle, angle.radius(largest_angle, radius)};
}

class ScaramuzzaLens final : public FisheyeLens {
 public:
  ScaramuzzaLens(const ScaramuzzaParameters& model, AngleOfRadius angle, Reach reach)
      : FisheyeLens(model.centre, {1.0, model.d, model.e, model.c}, reach.angle, reach.radius),
        angle_(std::move(angle)),
        largest_radius_(reach.radius) {}
  std::string_view name() const override { return "scaramuzza"; }

 private:
  double radius(double angle) const override { return angle_.radius(angle, largest_radius_); }
  double angle(double radius) const override { return angle_(radius); }

  AngleOfRadius angle_;
  double largest_radius_;
};

}  // namespace

LensPtr scaramuzza_lens(ScaramuzzaParameters model, Radians largest_angle) {
  AngleOfRadius angle(model.polynomial);
  const auto end = reach(angle, largest_angle.value);
  return std::make_shared<ScaramuzzaLens>(model, std::move(angle), end);
}

}  // namespace kasumi

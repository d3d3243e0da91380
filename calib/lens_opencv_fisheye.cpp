#include <algorithm>

#include "calib/lens_fisheye.hpp"
#include "calib/polynomial.hpp"

namespace kasumi {
namespace {

// theta_d as a polynomial of theta.
Polynomial distorted_angle(const std::array<double, 4>& k) {
  return {0.0, 1.0, 0.0, k[0], 0.0, k[1], 0.0, k[2], 0.0, k[3]};
}

// Where the polynomial turns back, two angles share a pixel: the model ends there.
double reach(const Polynomial& distorted, double largest_angle) {
  return std::min(largest_angle, first_positive_root(derivative(distorted)).value_or(largest_angle));
}

class OpencvFisheyeLens final : public FisheyeLens {
 public:
  OpencvFisheyeLens(glm::dvec2 focal_px, glm::dvec2 centre, Polynomial distorted, double largest_angle)
      : FisheyeLens(centre, glm::dmat2{focal_px.x, 0.0, 0.0, focal_px.y}, largest_angle,
                    evaluate(distorted, largest_angle)),
        distorted_(std::move(distorted)),
        slope_(derivative(distorted_)),
        largest_angle_(largest_angle) {}
  std::string_view name() const override { return "opencv_fisheye"; }

 private:
  double radius(double angle) const override { return evaluate(distorted_, angle); }
  double angle(double radius) const override {
    return solve_increasing([&](double angle) { return evaluate(distorted_, angle); },
                            [&](double angle) { return evaluate(slope_, angle); }, radius, 0.0, largest_angle_);
  }

  Polynomial distorted_;
  Polynomial slope_;
  double largest_angle_;
};

}  // namespace

LensPtr opencv_fisheye_lens(glm::dvec2 focal_px, glm::dvec2 centre, std::array<double, 4> k, Radians largest_angle) {
  const auto distorted = distorted_angle(k);
  return std::make_shared<OpencvFisheyeLens>(focal_px, centre, distorted, reach(distorted, largest_angle.value));
}

}  // namespace kasumi

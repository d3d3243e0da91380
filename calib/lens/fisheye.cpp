#include "calib/lens/fisheye.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/lens/polynomial.hpp"

namespace kasumi {
namespace {
// Keeps rays on the rim inside despite rounding.
constexpr double kRimTolerance = 1e-9;
}  // namespace

FisheyeLens::FisheyeLens(glm::dvec2 centre, const glm::dmat2& pixels_from_plane, double largest_angle,
                         double largest_radius)
    : centre_(centre),
      pixels_from_plane_(pixels_from_plane),
      plane_from_pixels_(glm::inverse(pixels_from_plane)),
      largest_angle_(largest_angle),
      largest_radius_(largest_radius) {}

std::optional<glm::dvec2> FisheyeLens::project(const glm::dvec3& ray) const {
  const double off_axis = std::hypot(ray.x, ray.y);
  if (off_axis == 0.0) {
    if (ray.z > 0.0) return centre_;
    return std::nullopt;  // straight behind is a whole circle of pixels, and no ray at all is nowhere
  }
  const double from_axis = std::atan2(off_axis, ray.z);
  if (!(from_axis <= largest_angle_ + kRimTolerance)) return std::nullopt;
  const double r = radius(std::min(from_axis, largest_angle_));
  return centre_ + pixels_from_plane_ * (r / off_axis * glm::dvec2{ray.x, ray.y});
}

std::optional<glm::dvec3> FisheyeLens::unproject(const glm::dvec2& pixel) const {
  const glm::dvec2 point = plane_from_pixels_ * (pixel - centre_);
  const double r = glm::length(point);
  if (r == 0.0) return glm::dvec3{0.0, 0.0, 1.0};
  if (!(r <= largest_radius_ * (1.0 + kRimTolerance))) return std::nullopt;
  const double from_axis = angle(std::min(r, largest_radius_));
  return glm::dvec3{std::sin(from_axis) / r * point, std::cos(from_axis)};
}

namespace {

class EquidistantLens final : public FisheyeLens {
 public:
  EquidistantLens(glm::dvec2 centre, double focal_px, double largest_angle)
      : FisheyeLens(centre, glm::dmat2(focal_px), largest_angle, largest_angle) {}
  std::string_view name() const override { return "equidistant"; }

 private:
  double radius(double angle) const override { return angle; }
  double angle(double radius) const override { return radius; }
};

class EquisolidLens final : public FisheyeLens {
 public:
  EquisolidLens(glm::dvec2 centre, double focal_px, double largest_angle)
      : FisheyeLens(centre, glm::dmat2(focal_px), largest_angle, 2.0 * std::sin(0.5 * largest_angle)) {}
  std::string_view name() const override { return "equisolid"; }

 private:
  double radius(double angle) const override { return 2.0 * std::sin(0.5 * angle); }
  double angle(double radius) const override { return 2.0 * std::asin(0.5 * radius); }
};

// theta_d as a polynomial of theta.
Polynomial distorted_angle(const std::array<double, 4>& k) {
  return {0.0, 1.0, 0.0, k[0], 0.0, k[1], 0.0, k[2], 0.0, k[3]};
}

// Beyond the polynomial's maximum two angles would share a pixel: the model ends there. Its slope is a polynomial of the
// angle's square. A fit asks for this with every step.
double reach(const std::array<double, 4>& k, double largest_angle) {
  const double most = largest_angle * largest_angle;
  return std::sqrt(first_positive_root({1.0, 3.0 * k[0], 5.0 * k[1], 7.0 * k[2], 9.0 * k[3]}, most).value_or(most));
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

class MirroredLens final : public Lens {
 public:
  explicit MirroredLens(LensPtr lens) : lens_(std::move(lens)) {}
  std::string_view name() const override { return lens_->name(); }
  std::optional<glm::dvec2> project(const glm::dvec3& ray) const override {
    return lens_->project({-ray.x, ray.y, ray.z});
  }
  std::optional<glm::dvec3> unproject(const glm::dvec2& pixel) const override {
    const auto ray = lens_->unproject(pixel);
    if (!ray) return std::nullopt;
    return glm::dvec3{-ray->x, ray->y, ray->z};
  }

 private:
  LensPtr lens_;
};

}  // namespace

LensPtr mirrored_lens(LensPtr lens) {
  return std::make_shared<MirroredLens>(std::move(lens));
}

LensPtr equidistant_lens(glm::dvec2 centre, double focal_px, Radians largest_angle) {
  return std::make_shared<EquidistantLens>(centre, focal_px, largest_angle.value);
}

LensPtr equisolid_lens(glm::dvec2 centre, double focal_px, Radians largest_angle) {
  return std::make_shared<EquisolidLens>(centre, focal_px, largest_angle.value);
}

LensPtr opencv_fisheye_lens(glm::dvec2 focal_px, glm::dvec2 centre, std::array<double, 4> k, Radians largest_angle) {
  const auto distorted = distorted_angle(k);
  return std::make_shared<OpencvFisheyeLens>(focal_px, centre, distorted, reach(k, largest_angle.value));
}

}  // namespace kasumi

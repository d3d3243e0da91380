#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/matrix.hpp>

#include "calib/lens/lens.hpp"
#include "calib/lens/polynomial.hpp"

namespace kasumi {
namespace {

// Brown's distortion of the plane at z = 1.
struct BrownDistortion {
  double k1, k2, p1, p2, k3;

  double radial(double r2) const { return 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3)); }
  double radial_slope(double r2) const { return k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3); }

  glm::dvec2 operator()(const glm::dvec2& at) const {
    const double x = at.x, y = at.y, r2 = glm::dot(at, at);
    return radial(r2) * at +
           glm::dvec2{2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
  }
  glm::dmat2 jacobian(const glm::dvec2& at) const {
    const double x = at.x, y = at.y, r2 = glm::dot(at, at);
    const double stretch = radial(r2), bend = 2.0 * radial_slope(r2);
    const double across = bend * x * y + 2.0 * (p1 * x + p2 * y);
    return {stretch + bend * x * x + 2.0 * p1 * y + 6.0 * p2 * x, across,  //
            across, stretch + bend * y * y + 6.0 * p1 * y + 2.0 * p2 * x};
  }
};

// The radius at which the distortion first folds the plane along a direction: where its Jacobian's determinant, a
// polynomial of the radius, vanishes.
double fold(const BrownDistortion& brown, double x, double y) {
  const Polynomial stretch{1.0, 0.0, brown.k1, 0.0, brown.k2, 0.0, brown.k3};
  const Polynomial bend{0.0, 0.0, 2.0 * brown.k1, 0.0, 4.0 * brown.k2, 0.0, 6.0 * brown.k3};
  const double p1 = brown.p1, p2 = brown.p2;
  const auto xx = sum(sum(stretch, scaled(bend, x * x)), {0.0, 2.0 * p1 * y + 6.0 * p2 * x});
  const auto yy = sum(sum(stretch, scaled(bend, y * y)), {0.0, 6.0 * p1 * y + 2.0 * p2 * x});
  const auto xy = sum(scaled(bend, x * y), {0.0, 2.0 * p1 * x + 2.0 * p2 * y});
  const auto determinant = sum(product(xx, yy), scaled(product(xy, xy), -1.0));
  return first_positive_root(determinant).value_or(std::numeric_limits<double>::infinity());
}

// Radius of the disc of the plane in which no two points share a pixel.
double reach(const BrownDistortion& brown) {
  const int directions = brown.p1 == 0.0 && brown.p2 == 0.0 ? 1 : 72;
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < directions; ++i) {
    const double turn = 2.0 * kPi * i / directions;
    nearest = std::min(nearest, fold(brown, std::cos(turn), std::sin(turn)));
  }
  return 0.999 * nearest;
}

class PinholeLens final : public Lens {
 public:
  explicit PinholeLens(const PinholeParameters& model)
      : model_(model),
        brown_{model.distortion[0], model.distortion[1], model.distortion[2], model.distortion[3], model.distortion[4]},
        reach_(reach(brown_)) {}
  std::string_view name() const override { return "pinhole"; }
  const PinholeParameters& model() const { return model_; }

  std::optional<glm::dvec2> project(const glm::dvec3& ray) const override {
    if (!(ray.z > 0.0)) return std::nullopt;
    const glm::dvec2 point{ray.x / ray.z, ray.y / ray.z};
    if (!(glm::length(point) < reach_)) return std::nullopt;
    return model_.centre + model_.focal_px * brown_(point);
  }

  std::optional<glm::dvec3> unproject(const glm::dvec2& pixel) const override {
    const auto point = undistorted((pixel - model_.centre) / model_.focal_px);
    if (!point) return std::nullopt;
    return glm::normalize(glm::dvec3{*point, 1.0});
  }

 private:
  // Newton's iteration in two dimensions. Each step is halved until it brings the point nearer and keeps it inside the
  // reach, so that it cannot end on the far side of a fold.
  std::optional<glm::dvec2> undistorted(const glm::dvec2& distorted) const {
    const double size = glm::length(distorted);
    if (!std::isfinite(size)) return std::nullopt;
    glm::dvec2 point = size < reach_ ? distorted : distorted * (0.9 * reach_ / size);
    double miss = glm::length(brown_(point) - distorted);
    for (int i = 0; i < 100 && miss > 0.0; ++i) {
      const glm::dvec2 step = glm::inverse(brown_.jacobian(point)) * (distorted - brown_(point));
      double part = 1.0;
      glm::dvec2 next = point + step;
      while (part > 1e-6 && !(glm::length(next) < reach_ && glm::length(brown_(next) - distorted) < miss)) {
        part *= 0.5;
        next = point + part * step;
      }
      if (part <= 1e-6) break;  // as near as numbers, or the reach, allow
      point = next;
      miss = glm::length(brown_(point) - distorted);
    }
    if (miss > 1e-12 * (1.0 + size)) return std::nullopt;
    return point;
  }

  PinholeParameters model_;
  BrownDistortion brown_;
  double reach_;
};

}  // namespace

LensPtr pinhole_lens(const PinholeParameters& model) {
  return std::make_shared<PinholeLens>(model);
}

std::optional<PinholeParameters> pinhole_model(const Lens& lens) {
  const auto* pinhole = dynamic_cast<const PinholeLens*>(&lens);
  if (!pinhole) return std::nullopt;
  return pinhole->model();
}

}  // namespace kasumi

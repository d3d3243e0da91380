#include <cmath>

#include "calib/lens_fisheye.hpp"

namespace kasumi {
namespace {

class EquisolidLens final : public FisheyeLens {
 public:
  EquisolidLens(glm::dvec2 centre, double focal_px, double largest_angle)
      : FisheyeLens(centre, glm::dmat2(focal_px), largest_angle, 2.0 * std::sin(0.5 * largest_angle)) {}
  std::string_view name() const override { return "equisolid"; }

 private:
  double radius(double angle) const override { return 2.0 * std::sin(0.5 * angle); }
  double angle(double radius) const override { return 2.0 * std::asin(0.5 * radius); }
};

}  // namespace

LensPtr equisolid_lens(glm::dvec2 centre, double focal_px, Radians largest_angle) {
  return std::make_shared<EquisolidLens>(centre, focal_px, largest_angle.value);
}

}  // namespace kasumi

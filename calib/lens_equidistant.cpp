#include "calib/lens_fisheye.hpp"

namespace kasumi {
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

}  // namespace

LensPtr equidistant_lens(glm::dvec2 centre, double focal_px, Radians largest_angle) {
  return std::make_shared<EquidistantLens>(centre, focal_px, largest_angle.value);
}

}  // namespace kasumi

// A real building's facade: measured in clear air, and put back into pictures under other air as the program draws
// (M Eq 12: I = Linf (1 - Gamma) + Gamma L0; docs/physics.md 8).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/image.hpp"

namespace kasumi {

// Light from infinity beside the building, row by row: the horizon brightens downwards.
struct FacadeBackdrop {
  glm::dvec3 light{0.0};            // linear, at row 0 of the facade
  glm::dvec3 per_row{0.0};          // and what a row adds
  glm::dvec3 variance{0.0};         // of `light`
  glm::dvec3 at(double row) const;  // never below a hundredth of `light`
};

struct FacadeView {
  Image<glm::vec3> light;  // linear, of the facade's pixels; all views of one size
  FacadeBackdrop sky;
  glm::dvec3 depth{0.0};        // optical depth of the air before it, by other landmarks
  glm::dvec3 depth_sigma{0.0};  // one standard deviation
  double sunlit = 0.0;          // cosine of the sun's incidence; 0: in the shade
};

// In units of the light from infinity beside it, without air.
struct Facade {
  Image<glm::vec3> shade;       // L0 / Linf of each pixel where the sun does not reach it
  Image<glm::vec3> lit;         // what a sun at right angles adds; empty: never seen
  glm::dvec3 shade_sigma{0.0};  // of the whole facade's mean, from picture to picture
  glm::dvec3 lit_sigma{0.0};
  int shaded_views = 0, lit_views = 0;

  glm::dvec3 mean_shade() const;
};

struct FacadeNeeds {
  int least_views = 3;
  double least_sunlit = 0.15;  // grazing sun: whether it reaches the facade is not sure
};

// Pixel by pixel the median of what the views show once the air before it is taken away. Nothing: too few views in the shade.
std::optional<Facade> measure_facade(const std::vector<const FacadeView*>& views, const FacadeNeeds& needs = {});

// What the camera would see, linear, through air of that depth. Where `lit` is empty a sunlit facade is drawn in the shade.
Image<glm::vec3> put_back(const Facade& facade, const FacadeBackdrop& sky, const glm::dvec3& depth, double sunlit);

// Of the drawn facade's mean light: by air, by the facade's own light, by the sky beside it. One standard deviation.
glm::dvec3 put_back_sigma(const Facade& facade, const FacadeView& view);

glm::dvec3 mean_of(const Image<glm::vec3>& light);

}  // namespace kasumi

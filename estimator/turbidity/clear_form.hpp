// What all clear skies have in common, whatever their aerosol: they are smooth, around the sun and in direction.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "estimator/atmosphere.hpp"

namespace kasumi {

// ln light = a function of the distance from the sun + a function of the direction that varies slowly. Neither can
// follow a cloud's outline. Clear skies of any aerosol, drawn or measured, leave 1 to 3 %.
class ClearForm {
 public:
  explicit ClearForm(const SunDirection& sun);

  // Around the sun, and slow ones over the sky: 26 stay smoother than a cloud's outline.
  static constexpr std::size_t kRadial = 10, kSlow = 16, kTerms = kRadial + kSlow;
  using Terms = std::array<float, kTerms>;
  Terms at(const glm::vec3& direction) const;

 private:
  glm::vec3 sun_;
  glm::vec2 ahead_{};  // east and north, towards the sun
};

struct LookedAt {
  ClearForm::Terms terms{};
  float luminance = 0.0f, colour = 0.0f;  // ln Y, ln R/B
  float weight = 0.0f;                    // to begin with
};

// One sky of this form.
struct ClearFormFit {
  ClearForm::Terms luminance{}, colour{};  // factors of the terms
  // Standard deviations, of the places that agree.
  float luminance_scatter = 0.0f, colour_scatter = 0.0f;

  float luminance_at(const ClearForm::Terms& terms) const;
  float colour_at(const ClearForm::Terms& terms) const;
};

// Half widths of the window, in ln Y: from what clouds differ by to what clear air does.
struct ClearFormWindow {
  float widest = 0.6f, narrowest = 0.10f;
  int rounds = 9;
};

// The sky that most places agree on in luminance and colour at once: least squares with Tukey's weights, whose window
// narrows. Empty when too few agree.
std::optional<ClearFormFit> fit_clear_form(const std::vector<LookedAt>& places, const ClearFormWindow& window = {});

}  // namespace kasumi

// Which elements of a sky picture are clear air, of whatever aerosol. Clear air is smooth around its sun and varies
// slowly beside (ClearForm), a cloud has texture, edges and a colour of its own. A sky model gives no more than a place
// to begin, or the shape that the form is laid over.
#pragma once

#include <functional>

#include <glm/vec2.hpp>

#include "estimator/turbidity/clear_form.hpp"
#include "estimator/turbidity/element_looks.hpp"

namespace kasumi {

struct ClearAir {
  bool found = false;           // a sky of this form; else nothing is marked
  double clear_fraction = 0.0;  // of the solid angle that could be judged; clouds' margins count as clear
  // How many places agree on this sky and how closely: log likelihood per place. Above 0 the sky is found; some 4 at best.
  double agreement = 0.0;
  // Of the places that agree, standard deviations of ln Y and ln R/B.
  double luminance_scatter = 0.0, colour_scatter = 0.0;
};

// What a model expects: ln Y and ln R/B of the camera's channels, each but for a constant.
using ExpectedLook = std::function<glm::vec2(const Direction&)>;

// How far from the sky's own form clear air may be.
struct ClearAirLimits {
  ClearFormWindow window{.narrowest = 0.06f, .rounds = 11};
  double scatters = 4.0;  // of the places that agree
  double least = 0.03, most_luminance = 0.12, most_colour = 0.10;
  double texture_scatter = 5.0, least_texture = 0.02;  // as CloudMaskLimits has them
};

// Turns PixelUse::clear into PixelUse::cloud where the sky is not of that form. `begin`: what is taken for clear at
// first. `expected`: subtracted from what is seen, so that the form has only the difference to follow.
ClearAir mask_all_but_clear_air(ElementLight& sky, const ElementLooks& looks, const ElementGeometry& geometry,
                                const Image<PixelUse>& begin, const SunDirection& sun,
                                const ClearAirLimits& limits = {}, const ExpectedLook& expected = {});

}  // namespace kasumi

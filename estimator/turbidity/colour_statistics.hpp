// How a sky looks, before any model of the clear sky is fitted: whether it has colour, whether it is as smooth as clear
// air is around its sun, and how much of it is whiter than its bluest part.
#pragma once

#include "estimator/turbidity/sky_samples.hpp"

namespace kasumi {

// Of places some 3 deg apart, each a mean over as much.
struct ColourStatistics {
  int places = 0;            // fewer than kFewestPlaces say nothing: then all below is 0
  double bluest = 0.0;       // ln R/B of the bluest tenth
  double colour_span = 0.0;  // of ln R/B, from the bluest tenth to the whitest
  double smooth = 0.0;       // share that agrees with one smooth sky (ClearForm) in light, colour and texture
  double cover = 0.0;        // share that does not, and is whiter than the bluest sky there
  bool sun_seen = false;     // a small saturated spot stands where the sun is
  bool sun_hidden = false;   // nothing there is saturated
};
constexpr int kFewestPlaces = 150;  // fewer do not show a sky's form, which has 26 terms

// What is much darker than the sky around it, trees and masts, counts as no sky. `light`: clouds not marked.
ColourStatistics look_of(const SkyPicture& picture, const ElementGeometry& geometry, const ElementLight& light,
                         const SunDirection& sun);

// The same without what is compared with one smooth sky, which takes most of the time: `smooth` and `cover` stay 0.
ColourStatistics colours_of(const SkyPicture& picture, const ElementGeometry& geometry, const ElementLight& light,
                            const SunDirection& sun);

// Sets sun_seen and sun_hidden alone.
void look_at_sun(ColourStatistics& look, const SkyPicture& picture, const ElementGeometry& geometry,
                 const SunDirection& sun);

}  // namespace kasumi

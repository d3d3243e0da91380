#include "estimator/turbidity/clear_air.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <glm/geometric.hpp>

#include "estimator/turbidity/element_maps.hpp"
#include "estimator/turbidity/expected_elements.hpp"

namespace kasumi {

namespace {

// `if_cloud`: weight to begin with of what `begin` calls cloud.
std::vector<LookedAt> places_to_fit(const ElementLooks& looks, const ElementGeometry& geometry,
                                    const Image<PixelUse>& begin, float if_cloud, const ClearForm& form,
                                    const ExpectedLook& expected, float rough) {
  constexpr double kPlaces = 1200.0;  // more add nothing
  const int step = std::max(1, static_cast<int>(std::lround(std::sqrt(cv::sum(looks.known)[0] / kPlaces))));
  std::vector<LookedAt> places;
  for (int y = step / 2; y < looks.known.rows; y += step)
    for (int x = step / 2; x < looks.known.cols; x += step) {
      if (looks.known(y, x) == 0.0f || looks.alone(y, x) != 0) continue;
      const glm::vec3& direction = geometry.direction.at(x, y);
      const glm::vec2 model = expected ? expected(Direction(direction)) : glm::vec2{0.0f};
      LookedAt place{form.at(direction), looks.luminance(y, x) - model.x, looks.colour(y, x) - model.y, 0.0f};
      if (!std::isfinite(place.luminance) || !std::isfinite(place.colour)) continue;
      if (looks.texture(y, x) < rough) place.weight = begin.at(x, y) == PixelUse::cloud ? if_cloud : 1.0f;
      places.push_back(place);
    }
  return places;
}

// Log likelihood, per place, that those within reach of this sky lie so close to it and the rest anywhere.
double agreement_with(const ClearFormFit& sky, const std::vector<LookedAt>& places) {
  constexpr float kReach = 3.0f, kLeast = 0.01f;  // standard deviations; no sky agrees better than 1 %
  constexpr double kAnywhere = 6.0;               // area in ln Y and ln R/B
  const float dy = kReach * std::max(kLeast, sky.luminance_scatter), dc = kReach * std::max(kLeast, sky.colour_scatter);
  const auto agreeing = static_cast<double>(std::ranges::count_if(places, [&](const LookedAt& p) {
    return std::abs(p.luminance - sky.luminance_at(p.terms)) < dy && std::abs(p.colour - sky.colour_at(p.terms)) < dc;
  }));
  const auto all = static_cast<double>(places.size()), rest = all - agreeing;
  const double area = 4.0 * static_cast<double>(dy * dc);
  return ((agreeing > 0.0 ? agreeing * std::log(agreeing / (all * area)) : 0.0) +
          (rest > 0.0 ? rest * std::log(rest / (all * kAnywhere)) : 0.0)) /
         all;
}

}  // namespace

ClearAir mask_all_but_clear_air(ElementLight& sky, const ElementLooks& looks, const ElementGeometry& geometry,
                                const Image<PixelUse>& begin, const SunDirection& sun, const ClearAirLimits& limits,
                                const ExpectedLook& expected) {
  ClearAir air;
  const float rough = looks.rough(limits.texture_scatter, limits.least_texture);
  const ClearForm form(sun);
  // From what looks clear alone, and from all that is not rough: the sky on which more places agree more closely.
  constexpr float kBegun = 0.2f;      // the window of the first fit, to elements that look clear
  constexpr double kNearlyAll = 2.5;  // agreement that no other beginning betters
  std::optional<ClearFormFit> by_form;
  double best = -std::numeric_limits<double>::infinity();
  for (const float if_cloud : {0.0f, 0.3f}) {
    const auto places = places_to_fit(looks, geometry, begin, if_cloud, form, expected, rough);
    ClearFormWindow window = limits.window;
    if (if_cloud == 0.0f) window.widest = std::min(window.widest, kBegun);
    const auto tried = fit_clear_form(places, window);
    if (!tried) continue;
    const double score = agreement_with(*tried, places);
    if (score > best) best = score, by_form = tried;
    if (best > kNearlyAll) break;
  }
  if (!by_form) return air;
  air.found = true;
  air.agreement = best;
  air.luminance_scatter = static_cast<double>(by_form->luminance_scatter);
  air.colour_scatter = static_cast<double>(by_form->colour_scatter);
  const auto limit_of = [&limits](double scatter, double most) {
    return static_cast<float>(std::clamp(limits.scatters * scatter, limits.least, most));
  };
  const float luminance_limit = limit_of(air.luminance_scatter, limits.most_luminance),
              colour_limit = limit_of(air.colour_scatter, limits.most_colour);
  constexpr float kOfStep = 0.3f;  // what the mean of nine elements leaves of the quantisation
  ExpectedElements elements(geometry, sun, [&](const glm::vec3& direction) {
    const ClearForm::Terms terms = form.at(direction);
    const glm::vec2 here{by_form->luminance_at(terms), by_form->colour_at(terms)};
    return expected ? here + expected(Direction(direction)) : here;
  });
  constexpr float kFar = 3.0f;  // limits: no noise, even of a single element
  cv::Mat1b marked(looks.known.size(), std::uint8_t{0}), far(looks.known.size(), std::uint8_t{0});
  for (int y = 0; y < marked.rows; ++y) {
    elements.begin_row(y);
    for (int x = 0; x < marked.cols; ++x) {
      if (looks.known(y, x) == 0.0f) continue;
      const glm::vec2 by = elements.at(x);
      const float over =
          std::max(std::abs(looks.luminance(y, x) - by.x) / (luminance_limit + kOfStep * looks.luminance_step(y, x)),
                   std::abs(looks.colour(y, x) - by.y) / (colour_limit + kOfStep * looks.colour_step(y, x)));
      if (over > 1.0f || looks.texture(y, x) > rough) marked(y, x) = 1;
      if (over > kFar || looks.alone(y, x) != 0) far(y, x) = 1;
    }
  }

  const cv::Mat1b grown = grown_over_soft_edges(marked);
  double clear = 0.0, all = 0.0;
  for (int y = 0; y < marked.rows; ++y)
    for (int x = 0; x < marked.cols; ++x) {
      if (looks.known(y, x) == 0.0f) continue;
      const auto angle = static_cast<double>(geometry.solid_angle.at(x, y));
      all += angle;
      if (marked(y, x) == 0 && far(y, x) == 0) clear += angle;
      PixelUse& use = sky.use.at(x, y);
      if (use == PixelUse::clear || use == PixelUse::cloud)
        use = grown(y, x) != 0 || far(y, x) != 0 ? PixelUse::cloud : PixelUse::clear;
    }
  air.clear_fraction = all > 0.0 ? clear / all : 0.0;
  return air;
}

}  // namespace kasumi

#include "estimator/haze/diffusion.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/haze/passes.hpp"

namespace kasumi {
namespace {

double widest_of(const BlurMap& map) {
  if (map.sigma_px.empty()) return map.inner_px;
  return static_cast<double>(*std::ranges::max_element(map.sigma_px.elements()));
}

Result<> check(const Image<glm::vec4>& light, const BlurMap& map) {
  Problems problems;
  const auto same = [&](const Image<float>& image) {
    return image.width() == light.width() && image.height() == light.height();
  };
  if (light.empty()) problems.add("no picture to blur");
  if (!same(map.sigma_px))
    problems.add("blur widths of {} x {} pixels: expected {} x {}, the size of the picture", map.sigma_px.width(),
                 map.sigma_px.height(), light.width(), light.height());
  for (const auto* steps : {&map.steps_along_row, &map.steps_down_column})
    if (!steps->empty() && !same(*steps))
      problems.add("range steps of {} x {} pixels: expected {} x {}, the size of the picture", steps->width(),
                   steps->height(), light.width(), light.height());
  if (!(map.inner_px > 0.0)) problems.add("inner scale of {} px: expected more than 0", map.inner_px);
  const auto good = [&](float sigma) { return sigma >= static_cast<float>(map.inner_px) && std::isfinite(sigma); };
  if (const auto bad = std::ranges::find_if_not(map.sigma_px.elements(), good); bad != map.sigma_px.elements().end())
    problems.add("a blur of {} px: expected at least the inner scale, {} px", *bad, map.inner_px);
  if (!problems.empty()) return fail(problems.fault());
  return {};
}

// The variance a pixel wants beyond the picture's own blur.
Image<float> wanted_variance(const BlurMap& map) {
  Image<float> variance(map.sigma_px.width(), map.sigma_px.height());
  const auto own = static_cast<float>(map.inner_px * map.inner_px);
  std::ranges::transform(map.sigma_px.elements(), variance.elements().begin(),
                         [&](float sigma) { return std::max(sigma * sigma - own, 0.0F); });
  return variance;
}

}  // namespace

std::string_view name_of(DiffusionScheme scheme) {
  switch (scheme) {
    case DiffusionScheme::explicit_steps: return "explicit";
    case DiffusionScheme::invariant: return "invariant";
    case DiffusionScheme::matched: return "matched";
  }
  return {};
}

std::optional<DiffusionScheme> diffusion_scheme_named(std::string_view name) {
  for (const auto scheme : {DiffusionScheme::explicit_steps, DiffusionScheme::invariant, DiffusionScheme::matched})
    if (name_of(scheme) == name) return scheme;
  return std::nullopt;
}

int passes_of(DiffusionScheme scheme, double inner_px, double widest_px) {
  if (!(widest_px > inner_px * (1.0 + 1e-6))) return 0;
  if (scheme == DiffusionScheme::explicit_steps)
    return static_cast<int>(std::ceil((widest_px * widest_px - inner_px * inner_px) / (2.0 * kLargestRate) - 1e-9));
  return static_cast<int>(std::ceil(std::log(widest_px / inner_px) / kLargestRate - 1e-9));
}

DiffusionCost cost_of(DiffusionScheme scheme, double inner_px, double widest_px) {
  // The pixel's own light and rate, then those of four neighbours.
  const int taps = scheme == DiffusionScheme::invariant ? 2 + 4 * 2 * 4 : 2 + 4 * 2;
  return {passes_of(scheme, inner_px, widest_px), taps};
}

double MatchedPass::rate(double wanted_px2) const {
  return std::clamp(wanted_px2 - from_px2, 0.0, variance_px2) / (2.0 * offset_px * offset_px);
}

std::vector<MatchedPass> matched_passes(double inner_px, double widest_px) {
  const int count = passes_of(DiffusionScheme::matched, inner_px, widest_px);
  const auto variance_after = [&](int passes) {
    const double part = static_cast<double>(passes) / count;
    const double sigma = inner_px + (widest_px - inner_px) * part * part;
    return sigma * sigma - inner_px * inner_px;
  };
  std::vector<MatchedPass> passes;
  for (int k = 0; k < count; ++k) {
    MatchedPass pass;
    pass.from_px2 = variance_after(k);
    pass.variance_px2 = variance_after(k + 1) - pass.from_px2;
    pass.offset_px = std::max(1, static_cast<int>(std::ceil(std::sqrt(pass.variance_px2 / (2.0 * kLargestRate)))));
    passes.push_back(pass);
  }
  return passes;
}

Result<Image<glm::vec4>> diffuse(DiffusionScheme scheme, const Image<glm::vec4>& light, const BlurMap& map) {
  if (auto fine = check(light, map); !fine) return fail(fine.error());
  const double widest = widest_of(map);
  const int count = passes_of(scheme, map.inner_px, widest);
  Image<glm::vec4> now = light;
  if (count == 0) return now;
  if (scheme == DiffusionScheme::invariant) {
    Image<glm::vec4> next(light.width(), light.height());
    Image<float> rate(light.width(), light.height());  // H Eq 18
    std::ranges::transform(map.sigma_px.elements(), rate.elements().begin(), [&](float sigma) {
      return static_cast<float>(std::log(static_cast<double>(sigma) / map.inner_px) / count);
    });
    for (int k = 0; k < count; ++k) {
      invariant_pass(now, rate, map.inner_px, k, next);
      std::swap(now, next);
    }
    return now;
  }

  FlowMap flow{wanted_variance(map)};
  std::vector<FlowRule> rules(static_cast<std::size_t>(count), explicit_rule(count));
  if (scheme == DiffusionScheme::matched) {
    if (!map.steps_along_row.empty() && !map.steps_down_column.empty()) {
      flow.steps_along_row = &map.steps_along_row;
      flow.steps_down_column = &map.steps_down_column;
    }
    std::ranges::transform(matched_passes(map.inner_px, widest), rules.begin(), matched_rule);
    const int farthest = std::ranges::max(rules, {}, &FlowRule::offset_px).offset_px;
    if (farthest > std::min(light.width(), light.height()))
      return fail(FaultKind::bad_input, "a blur of {:.1f} px takes steps of {} pixels: the picture has {} x {}", widest,
                  farthest, light.width(), light.height());
  }
  run_passes(rules, flow, now);
  return now;
}

}  // namespace kasumi

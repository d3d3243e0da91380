#include "estimator/photograph/facade.hpp"

#include <algorithm>

#include <glm/common.hpp>
#include <glm/exponential.hpp>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

// L0 / Linf of each pixel without the air before it.
Image<glm::vec3> without_air(const FacadeView& view) {
  Image<glm::vec3> relative(view.light.width(), view.light.height());
  const auto amplify = glm::exp(view.depth);
  for (int y = 0; y < relative.height(); ++y) {
    const auto sky = view.sky.at(y);
    for (int x = 0; x < relative.width(); ++x)
      relative.at(x, y) = 1.0 - (1.0 - glm::dvec3(view.light.at(x, y)) / sky) * amplify;
  }
  return relative;
}

Image<glm::vec3> median_of(const std::vector<Image<glm::vec3>>& pictures) {
  Image<glm::vec3> middle(pictures.front().width(), pictures.front().height());
  std::vector<float> values(pictures.size());
  for (std::size_t i = 0; i < middle.elements().size(); ++i)
    for (int c = 0; c < 3; ++c) {
      for (std::size_t k = 0; k < pictures.size(); ++k) values[k] = pictures[k].elements()[i][c];
      middle.elements()[i][c] = median(values);
    }
  return middle;
}

// Scatter of the pictures' means about that of their middle.
glm::dvec3 spread_of(const std::vector<Image<glm::vec3>>& pictures, const Image<glm::vec3>& middle) {
  glm::dvec3 spread;
  const auto whole = mean_of(middle);
  for (int c = 0; c < 3; ++c) {
    std::vector<double> off;
    for (const auto& picture : pictures) off.push_back(mean_of(picture)[c] - whole[c]);
    spread[c] = robust_sigma(std::move(off));
  }
  return spread;
}

}  // namespace

glm::dvec3 FacadeBackdrop::at(double row) const {
  return glm::max(light + row * per_row, 0.01 * light);
}

glm::dvec3 mean_of(const Image<glm::vec3>& light) {
  glm::dvec3 sum{0.0};
  for (const auto& pixel : light.elements()) sum += glm::dvec3(pixel);
  return light.empty() ? sum : sum / static_cast<double>(light.elements().size());
}

glm::dvec3 Facade::mean_shade() const {
  return mean_of(shade);
}

std::optional<Facade> measure_facade(const std::vector<const FacadeView*>& views, const FacadeNeeds& needs) {
  std::vector<Image<glm::vec3>> shaded;
  for (const auto* view : views)
    if (view->sunlit == 0.0) shaded.push_back(without_air(*view));
  if (static_cast<int>(shaded.size()) < needs.least_views) return std::nullopt;
  Facade facade;
  facade.shade = median_of(shaded);
  facade.shade_sigma = spread_of(shaded, facade.shade);
  facade.shaded_views = static_cast<int>(shaded.size());

  std::vector<Image<glm::vec3>> added;
  for (const auto* view : views) {
    if (view->sunlit < needs.least_sunlit) continue;
    auto more = without_air(*view);
    for (std::size_t i = 0; i < more.elements().size(); ++i)
      more.elements()[i] = (more.elements()[i] - facade.shade.elements()[i]) / static_cast<float>(view->sunlit);
    added.push_back(std::move(more));
  }
  facade.lit_views = static_cast<int>(added.size());
  if (facade.lit_views < needs.least_views) return facade;
  facade.lit = median_of(added);
  facade.lit_sigma = spread_of(added, facade.lit);
  return facade;
}

Image<glm::vec3> put_back(const Facade& facade, const FacadeBackdrop& sky, const glm::dvec3& depth, double sunlit) {
  Image<glm::vec3> drawn(facade.shade.width(), facade.shade.height());
  const auto gamma = glm::exp(-depth);
  for (int y = 0; y < drawn.height(); ++y) {
    const auto infinity = sky.at(y);
    for (int x = 0; x < drawn.width(); ++x) {
      glm::dvec3 own(facade.shade.at(x, y));
      if (!facade.lit.empty()) own += sunlit * glm::dvec3(facade.lit.at(x, y));
      drawn.at(x, y) = glm::max(infinity * (1.0 - gamma) + gamma * own * infinity, 0.0);
    }
  }
  return drawn;
}

glm::dvec3 put_back_sigma(const Facade& facade, const FacadeView& view) {
  const auto infinity = view.sky.at(0.5 * (facade.shade.height() - 1));
  const auto gamma = glm::exp(-view.depth);
  const auto own = facade.mean_shade() + (facade.lit.empty() ? glm::dvec3{0.0} : view.sunlit * mean_of(facade.lit));
  const auto by_air = gamma * infinity * (1.0 - own) * view.depth_sigma;
  const auto by_light = gamma * infinity * facade.shade_sigma;
  const auto by_sun = gamma * infinity * view.sunlit * facade.lit_sigma;
  const auto by_sky = (1.0 - gamma + gamma * own) * glm::sqrt(view.sky.variance);
  return glm::sqrt(by_air * by_air + by_light * by_light + by_sun * by_sun + by_sky * by_sky);
}

}  // namespace kasumi

#include "pipeline/kiosk/content/reduction_loss.hpp"

#include <algorithm>
#include <array>

#include <glm/common.hpp>

#include "pipeline/show/scene/clear_day.hpp"

namespace kasumi {

namespace {

constexpr std::array kSuns{kAfternoon, Direction{0.8, -0.4, 0.35}, Direction{0.1, -0.2, 1.0}};

glm::ivec3 apart(const Rgb8& one, const Rgb8& other) {
  return glm::abs(glm::ivec3(one) - glm::ivec3(other));
}

bool changed(const Rgb8& now, const Rgb8& before) {
  const glm::ivec3 by = apart(now, before);
  return std::max({by.r, by.g, by.b}) > 2;
}

}  // namespace

Result<ReductionDrawings> ReductionDrawings::draw(GlContext& context, const Installation& installation,
                                                  const std::vector<std::shared_ptr<const Model>>& scenes) {
  Installation quiet = installation;
  quiet.scene_quality.full_scale_electrons = 0.0;
  quiet.scene_quality.jpeg_blocks = false;
  quiet.people_in_front = false;
  std::vector<ClearDay> days;
  for (const Direction& sun : kSuns) {
    const SkyReport sky = clear_day(sun);
    days.push_back({sky, backdrop(quiet, sky)});
  }
  ReductionDrawings all;
  for (const auto& scene : scenes) {
    auto pictures = drawn_over(context, quiet, *scene, days);
    if (!pictures) return fail(pictures.error());
    for (std::size_t i = 0; i < days.size(); ++i) all.drawings.push_back({std::move((*pictures)[i]), days[i].backdrop});
  }
  return all;
}

ReductionLoss loss(const ReductionDrawings& original, const ReductionDrawings& coarser) {
  ReductionLoss found;
  double whole = 0.0, weight = 0.0;
  for (std::size_t d = 0; d < original.drawings.size(); ++d) {
    const auto& without = original.drawings[d].without.elements();
    const auto& one = original.drawings[d].picture.elements();
    const auto& other = coarser.drawings[d].picture.elements();
    double sum = 0.0;
    std::size_t pixels = 0;
    for (std::size_t i = 0; i < one.size(); ++i) {
      if (!changed(one[i], without[i]) && !changed(other[i], without[i])) continue;
      const glm::ivec3 by = apart(one[i], other[i]);
      const double off = (by.r + by.g + by.b) / 3.0;
      found.worst_pixel = std::max(found.worst_pixel, off);
      sum += off;
      ++pixels;
    }
    found.pixels = std::max(found.pixels, pixels);
    found.worst_mean = std::max(found.worst_mean, sum / static_cast<double>(std::max<std::size_t>(pixels, 1)));
    whole += sum;
    weight += static_cast<double>(pixels);
  }
  found.mean = whole / std::max(weight, 1.0);
  return found;
}

}  // namespace kasumi

#include "estimator/sky_fit/reading_patches.hpp"

#include <algorithm>
#include <cmath>

#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace kasumi {
namespace {

// Chosen: a model's errors are smooth over .6 rad, so more patches add time, not knowledge.
constexpr std::size_t kMostPatches = 80;
// 7.5 and 2 deg: narrow where light is steep, wide enough that few readings' noise averages out.
constexpr double kWidest_rad = 0.13, kNarrowest_rad = 0.035;

// How far a reading may lie from the patch's centre.
double reach_at(const Direction& direction, const SunDirection& sun, double widening) {
  const double from_sun = angle_between(direction, sun).value, height = std::asin(std::clamp(direction.z, 0.0, 1.0));
  return widening * std::clamp(std::min(0.3 * from_sun, 0.03 + 0.5 * height), kNarrowest_rad, kWidest_rad);
}

struct Gathering {
  std::vector<Direction> centres;
  std::vector<std::vector<std::size_t>> members;
};
Gathering gather(std::span<const SkyReading> readings, const SunDirection& sun, double widening) {
  Gathering patches;
  std::vector<double> least_cosine;
  for (const SkyReading& reading : readings) {
    const bool near_one = std::any_of(patches.centres.begin(), patches.centres.end(), [&](const Direction& centre) {
      return glm::dot(centre, reading.direction) >
             least_cosine[static_cast<std::size_t>(&centre - patches.centres.data())];
    });
    if (near_one) continue;
    patches.centres.push_back(reading.direction);
    least_cosine.push_back(std::cos(reach_at(reading.direction, sun, widening)));
  }
  return patches;
}

void gather_members(std::span<const SkyReading> readings, Gathering& patches) {
  patches.members.resize(patches.centres.size());
  for (std::size_t i = 0; i < readings.size(); ++i) {
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < patches.centres.size(); ++k)
      if (glm::dot(patches.centres[k], readings[i].direction) >
          glm::dot(patches.centres[nearest], readings[i].direction))
        nearest = k;
    patches.members[nearest].push_back(i);
  }
}

double middle_of(std::vector<double>& values) {
  const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), half, values.end());
  if (values.size() % 2 == 1) return *half;
  return 0.5 * (*half + *std::max_element(values.begin(), half));
}

}  // namespace

ReadingPatches::ReadingPatches(std::span<const SkyReading> readings, const SunDirection& sun) : sun_(sun) {
  Gathering patches;
  for (double widening = 1.0;;) {
    patches = gather(readings, sun, widening);
    const double too_many = static_cast<double>(patches.centres.size()) / static_cast<double>(kMostPatches);
    if (too_many <= 1.0) break;
    widening *= 1.05 * std::sqrt(too_many);
  }
  gather_members(readings, patches);
  members_ = std::move(patches.members);
  for (const auto& members : members_) {
    Direction sum{0.0};
    for (const std::size_t i : members) sum += readings[i].direction;
    centres_.push_back(glm::normalize(sum));
  }
}

std::vector<ReadingPatch> ReadingPatches::gathered(std::span<const SkyReading> readings,
                                                   const RadianceField& like) const {
  std::vector<ReadingPatch> patches;
  std::vector<double> values;
  for (std::size_t k = 0; k < centres_.size(); ++k) {
    ReadingPatch patch;
    patch.direction = centres_[k];
    patch.sun_distance = angle_between(centres_[k], sun_).value;
    const glm::dvec3 here = glm::log(glm::max(like(centres_[k]), glm::dvec3(1e-9)));
    std::vector<glm::dvec3> ratios;
    for (const std::size_t i : members_[k])
      ratios.push_back(glm::log(glm::max(readings[i].light, glm::dvec3(1e-12))) -
                       glm::log(glm::max(like(readings[i].direction), glm::dvec3(1e-9))));
    const auto n = static_cast<double>(members_[k].size());
    for (int c = 0; c < 3; ++c) {
      values.clear();
      for (const glm::dvec3& ratio : ratios) values.push_back(ratio[c]);
      patch.log_light[c] = here[c] + middle_of(values);
      for (const std::size_t i : members_[k])
        patch.variance[c] += readings[i].sigma[c] * readings[i].sigma[c] / (n * n);
    }
    for (const std::size_t i : members_[k]) patch.off_axis += readings[i].off_axis / n;
    patches.push_back(patch);
  }
  return patches;
}

}  // namespace kasumi

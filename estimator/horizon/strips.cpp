#include "estimator/horizon/strips.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <glm/common.hpp>

#include "base/geometry.hpp"
#include "base/saturation.hpp"
#include "base/statistics.hpp"

namespace kasumi {
namespace {

constexpr double kSearchShare = 0.15;   // of the picture's height above the segmentation's edge, where a faded hill may
constexpr double kSearchDegrees = 3.0;  // hide; and at least this far up: a telephoto view is filled by such hills
constexpr double kSoftestHill = 0.02;   // relative drop of light that counts as a hill's edge: 1.5 steps of 8 bits

// Lowest row in which the strip x0..x1 is mostly sky; -1 when there is none.
int sky_bottom(const HorizonPixels& scene, int x0, int x1) {
  for (int y = scene.picture.height() - 1; y >= 0; --y) {
    int count = 0;
    for (int x = x0; x < x1; ++x) count += scene.sky.at(x, y) != 0 ? 1 : 0;
    if (2 * count > x1 - x0) return y;
  }
  return -1;
}

// Median over the strip's sky pixels in a row. Also for red alone, because the air scatters it least: there a hill that
// has almost faded stays visible longest.
enum class RowChannel { brightness, red };
double row_light(const HorizonPixels& scene, int x0, int x1, int y, RowChannel channel) {
  std::vector<double> values;
  const int step = std::max(1, (x1 - x0) / 48);
  for (int x = x0; x < x1; x += step) {
    if (scene.sky.at(x, y) == 0) continue;
    const glm::dvec3 light = scene.light_at(x, y);
    values.push_back(channel == RowChannel::red ? light.x : (light.x + light.y + light.z) / 3.0);
  }
  return median(std::move(values));
}

// Last index above the first step down in a profile, searched from an index on, with means of `reach` values; -1 when
// there is none. At a silhouette the light changes little right above and right below the edge and does not soon
// return; at a cloud it does one or the other.
int first_step_down(const std::vector<double>& profile, int reach, double noise, int from = 0) {
  const auto mean = [&](int first) {
    double sum = 0.0;
    for (int i = 0; i < reach; ++i) sum += profile[static_cast<std::size_t>(first + i)];
    return sum / reach;
  };
  const int size = static_cast<int>(profile.size());
  for (int i = std::max(from, 2 * reach); i + 2 * reach <= size; ++i) {
    const double above = mean(i - reach), below = mean(i), drop = above - below;
    const double nearby = std::max(std::abs(mean(i - 2 * reach) - above), std::abs(below - mean(i + reach)));
    if (drop < kSoftestHill * above || drop < 4.0 * noise || drop < 2.5 * nearby) continue;
    const auto first_below = profile.begin() + i + reach / 2;
    const double brightest_below = *std::max_element(first_below, profile.begin() + std::min(size, i + 4 * reach));
    if (brightest_below < above - 0.5 * drop) return i - reach / 2 - 1;
  }
  return -1;
}

// The number of rows that span kSearchDegrees above a row.
int rows_of(const Camera& camera, int row) {
  const double x = 0.5 * (camera.width - 1);
  const auto here = camera.direction_at({x, row}), above = camera.direction_at({x, row - 8.0});
  if (!here || !above) return 0;
  const double degrees_per_row = to_degrees(angle_between(*here, *above)) / 8.0;
  return static_cast<int>(kSearchDegrees / std::max(degrees_per_row, 1e-6));
}

// Last index above the lowest rise of a profile, going down, to light at least as bright as what lies below the drop at
// `drop`; -1 when there is none. What shows below a hill's silhouette is darker than the silhouette, because there is
// less air in front of it; something that bright again is a cloud, seen from its upper edge on.
int lowest_rise(const std::vector<double>& profile, int reach, double noise, int drop) {
  const int size = static_cast<int>(profile.size());
  const auto mean = [&](int first) {
    const auto from = profile.begin() + std::clamp(first, 0, size - reach);
    return std::accumulate(from, from + reach, 0.0) / reach;
  };
  const double after_drop = mean(drop + reach / 2 + 1);
  const std::vector<double> upwards(profile.rbegin(), profile.rend());
  for (int from = 0;;) {
    const int step = first_step_down(upwards, reach, noise, from);
    const int rise = size - 2 - step;
    if (step < 0 || rise <= drop) return -1;
    if (mean(rise + 1 + reach / 2) >= after_drop) return rise;
    from = step + reach / 2 + 2;
  }
}

// Sets first_drop and certain. Everything above the silhouette of a hill that has faded into the sky is sky, and so is
// everything above a cloud.
void find_edges(const HorizonPixels& scene, HorizonStrip& strip) {
  const int height = scene.picture.height();
  strip.first_drop = strip.edge;
  int last_rise = strip.top;
  for (const RowChannel channel : {RowChannel::brightness, RowChannel::red}) {
    std::vector<double> profile;  // from the top down
    for (int y = strip.top; y <= strip.edge; ++y) profile.push_back(row_light(scene, strip.x0, strip.x1, y, channel));
    std::vector<double> changes;
    for (std::size_t i = 1; i < profile.size(); ++i) changes.push_back(profile[i] - profile[i - 1]);
    const double noise = robust_sigma(std::move(changes));
    // Sharp edges and, in fog, soft ones.
    for (const int reach : {std::max(3, height / 150), std::max(5, height / 75), std::max(8, height / 40)}) {
      const int drop = first_step_down(profile, reach, noise);
      if (drop < 0) continue;
      strip.first_drop = std::min(strip.first_drop, strip.top + drop);
      last_rise = std::max(last_rise, strip.top + lowest_rise(profile, reach, noise, drop));
    }
  }
  strip.certain = std::max(strip.first_drop, last_rise);
}

}  // namespace

HorizonPixels::HorizonPixels(const Camera& of_camera, const Image<Rgb8>& of_picture, const Image<std::uint8_t>& of_sky)
    : camera(of_camera), picture(of_picture), sky(of_sky) {
  for (std::size_t i = 0; i < light_of_level.size(); ++i)
    light_of_level[i] = camera.response.to_light(glm::dvec3{static_cast<double>(i)} / 255.0);
}

glm::dvec3 HorizonPixels::light_at(int x, int y) const {
  const Rgb8& encoded = picture.at(x, y);
  const glm::dvec3 light{light_of_level[encoded.r].r, light_of_level[encoded.g].g, light_of_level[encoded.b].b};
  return light / (camera.vignetting.at({x, y}) * camera.white_balance);
}

glm::dvec3 HorizonPixels::log_step_at(int x, int y) const {
  const glm::dvec3 encoded = glm::max(glm::dvec3(picture.at(x, y)), 1.0) / 255.0;
  return camera.response.slope(encoded) / glm::max(camera.response.to_light(encoded), 1e-9) / 255.0;
}

bool HorizonPixels::clipped_at(int x, int y) const {
  const Rgb8& encoded = picture.at(x, y);
  return encoded.x >= kSaturatedHorizon || encoded.y >= kSaturatedHorizon || encoded.z >= kSaturatedHorizon;
}

std::vector<HorizonStrip> sky_strips(const HorizonPixels& scene, int strips) {
  const int width = scene.picture.width(), height = scene.picture.height();
  std::vector<HorizonStrip> found;
  for (int i = 0; i < strips; ++i) {
    HorizonStrip strip{i * width / strips, (i + 1) * width / strips, 0, 0, 0, 0};
    strip.edge = sky_bottom(scene, strip.x0, strip.x1);
    if (strip.edge < 0) continue;
    const int rows = std::max(static_cast<int>(kSearchShare * height), rows_of(scene.camera, strip.edge));
    strip.top = std::max(0, strip.edge - rows);
    find_edges(scene, strip);
    found.push_back(strip);
  }
  return found;
}

}  // namespace kasumi

#include "pipeline/show/scene/ground_watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <fmt/format.h>

#include "estimator/air/attenuation.hpp"
#include "gles/light/airlight_grid.hpp"

namespace kasumi {
namespace {

constexpr int kMostColumns = 160;       // of the grid: no finer than the shadow's edges are soft
constexpr double kLeastStep_px = 2.0;   // no finer than the camera's own blur
constexpr std::uint8_t kOpen = 250;     // the mask's mean where nothing stands before the ground
constexpr double kWhite = 0.97;         // encoded: beyond, the camera may have clipped
constexpr double kAirSigma = 0.02;      // relative, of the air's light before the ground
constexpr double kSunlessSigma = 0.25;  // of the light under a sky without a sun: its clouds are known badly
constexpr double kUnsure = 0.25;        // share of the sun's light
constexpr float kVisible = 0.03f;       // the same
constexpr std::size_t kStray = 200;     // one point of so many may differ by more: noise, a passer-by

glm::dvec3 green_attenuation(const Haze& haze, double range_m, double rise_m) {
  const double low = haze.observer_altitude_m;
  const OpticalPath path = optical_path(low, low + rise_m, range_m);
  const HazeCoefficients coefficients{haze.weight, haze.rayleigh_per_m, haze.mie_per_m};
  glm::dvec3 left = attenuation(coefficients, path);
  if (haze.fog_per_m > 0.0) {
    const double from = (low - haze.fog_base_altitude_m) / haze.fog_scale_height_m,
                 climb = rise_m / haze.fog_scale_height_m;
    const double mean = std::abs(climb) < 1e-6 ? std::exp(-from) : std::exp(-from) * (1.0 - std::exp(-climb)) / climb;
    left *= std::exp(-haze.fog_per_m * range_m * mean);
  }
  return left;
}

// The sky's irradiance on slopes, of which few differ.
class SlopeIrradiance {
 public:
  explicit SlopeIrradiance(const LightAround& around) : around_(around) {}
  double on(const glm::dvec3& normal) {
    // Of a normal's component: the light on the ground changes little within one.
    constexpr double kSteps = 16.0;
    const auto key = std::pair(std::lround(kSteps * normal.x), std::lround(kSteps * normal.y));
    const auto known = known_.find(key);
    if (known != known_.end()) return known->second;
    const double x = static_cast<double>(key.first) / kSteps, y = static_cast<double>(key.second) / kSteps;
    const glm::dvec3 slope = glm::normalize(glm::dvec3(x, y, std::sqrt(std::max(1.0 - x * x - y * y, 1e-3))));
    return known_[key] = irradiance(around_, slope).g / kPi;
  }

 private:
  const LightAround& around_;
  std::map<std::pair<long, long>, double> known_;
};

// The pixels that see the ground.
PixelBox ground_box(const Camera& scene, const Model& model, const glm::dmat4& to_world) {
  glm::dvec2 lowest(1e9), highest(-1e9);
  for (const ModelPart& part : model.ground)
    for (const ModelVertex& vertex : part.vertices)
      if (const auto pixel = scene.pixel_of(glm::normalize(glm::dvec3(to_world * glm::dvec4(vertex.position, 1.0))))) {
        lowest = glm::min(lowest, *pixel);
        highest = glm::max(highest, *pixel);
      }
  const glm::dvec2 last(scene.width - 1.0, scene.height - 1.0);
  lowest = glm::max(lowest, glm::dvec2(0.0));
  highest = glm::min(highest, last);
  if (lowest.x > highest.x || lowest.y > highest.y) return {};
  return {static_cast<int>(lowest.x), static_cast<int>(lowest.y), static_cast<int>(highest.x) + 1,
          static_cast<int>(highest.y) + 1};
}

// Points of the grid that see no ground take the mean of their neighbours, again and again.
void spread(Image<float>& shares, Image<std::uint8_t> known) {
  for (bool more = true; more;) {
    more = false;
    const Image<std::uint8_t> before = known;
    for (int y = 0; y < shares.height(); ++y)
      for (int x = 0; x < shares.width(); ++x) {
        if (before.at(x, y) != 0) continue;
        float sum = 0.0f;
        int count = 0;
        for (int j = y - 1; j <= y + 1; ++j)
          for (int i = x - 1; i <= x + 1; ++i)
            if (before.contains(i, j) && before.at(i, j) != 0) {
              sum += shares.at(i, j);
              ++count;
            }
        if (count == 0) continue;
        shares.at(x, y) = sum / static_cast<float>(count);
        known.at(x, y) = 1;
        more = true;
      }
  }
}

}  // namespace

void light_ground(ObjectAppearance& appearance, const GroundLook& ground) {
  appearance.ground_sunlight = ground.sunlight;
  if (ground.sky) appearance.foot_shade = std::make_shared<const FootShade>(ground.sky->under(appearance.light.around));
}

bool look_alike(const GroundLook& now, const GroundLook& drawn) {
  if (now.sky != drawn.sky) return false;
  if (now.sunlight == drawn.sunlight) return true;
  if (!now.sunlight || !drawn.sunlight) return false;
  const auto &a = now.sunlight->share.elements(), &b = drawn.sunlight->share.elements();
  std::size_t others = 0;
  for (std::size_t i = 0; i < a.size(); ++i) others += std::abs(a[i] - b[i]) > kVisible ? 1 : 0;
  return others <= a.size() / kStray;
}

GroundWatch::GroundWatch(const Camera& scene, const Model& model, const Placement& placement) {
  const glm::dmat4 to_world = model_to_world(placement);
  for (std::size_t value = 0; value < green_.size(); ++value)
    green_[value] = scene.response.to_light(glm::dvec3{static_cast<double>(value) / 255.0}).g;
  if (!model.ground.empty()) find_places(scene, model, to_world);
  if (!places_.empty()) work_.emplace(model, to_world);
  ground_ = name_ground();
}

// The places themselves, in millimetres and hundredths of a pixel, by Fowler, Noll and Vo's hash (1a, 64 bits).
std::string GroundWatch::name_ground() const {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](double value) {
    const auto rounded = static_cast<std::uint64_t>(std::llround(value));
    for (int i = 0; i < 8; ++i) hash = (hash ^ (rounded >> (8 * i) & 0xff)) * 0x100000001b3;
  };
  for (std::size_t i = 0; i < places_.size(); ++i) {
    add(100.0 * places_[i].pixel.x);
    add(100.0 * places_[i].pixel.y);
    add(1000.0 * places_[i].range_m);
    for (int c = 0; c < 3; ++c) add(1000.0 * base_colours_[i][c]);
  }
  return fmt::format("{}-{:016x}", places_.size(), hash);
}

LearntGround GroundWatch::learnt() const {
  return {ground_, memory_->learnt()};
}

Result<> GroundWatch::resume(const LearntGround& learnt, double since_s) {
  if (memory_) return fail(FaultKind::bad_input, "it looks at the ground already");
  if (learnt.ground != ground_) return fail(FaultKind::bad_input, "of another ground or view");
  // Checks its size with a memory of as many places; the reflectance does not matter.
  GroundMemory trial(std::vector<float>(places_.size(), 0.1f));
  if (!trial.resume(learnt.shares, since_s)) return fail(FaultKind::bad_input, "damaged");
  resumed_ = Resumed{learnt.shares, since_s};
  return {};
}

void GroundWatch::find_places(const Camera& scene, const Model& model, const glm::dmat4& to_world) {
  const PixelBox box = ground_box(scene, model, to_world);
  if (box.empty()) return;
  grid_.step_px = std::max(kLeastStep_px, std::ceil(static_cast<double>(box.right - box.left) / kMostColumns));
  grid_.first_px = glm::dvec2(box.left, box.top) + 0.5 * (grid_.step_px - 1.0);
  const auto points = [&](int pixels) { return std::max(1, static_cast<int>(std::ceil(pixels / grid_.step_px))); };
  grid_.share = Image<float>(points(box.right - box.left), points(box.bottom - box.top), 1.0f);
  Image<int> nearest(grid_.share.width(), grid_.share.height(), -1);
  const glm::dmat3 turn(to_world);
  for (const ModelPart& part : model.ground) {
    const glm::dvec3 colour(model.materials[static_cast<std::size_t>(part.material)].base_colour);
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      std::array<glm::dvec3, 3> corners, normals;
      glm::dvec2 lowest(1e9), highest(-1e9);
      bool seen = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const ModelVertex& vertex = part.vertices[part.indices[i + k]];
        corners[k] = glm::dvec3(to_world * glm::dvec4(vertex.position, 1.0));
        normals[k] = glm::normalize(turn * glm::dvec3(vertex.normal));
        const auto pixel = scene.pixel_of(glm::normalize(corners[k]));
        seen = seen && pixel;
        if (!pixel) continue;
        lowest = glm::min(lowest, (*pixel - grid_.first_px) / grid_.step_px);
        highest = glm::max(highest, (*pixel - grid_.first_px) / grid_.step_px);
      }
      if (!seen) continue;
      const glm::dvec3 across = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
      const double area = glm::length(across);
      if (area <= 0.0) continue;
      const glm::dvec3 plane = across / area;
      const int left = std::max(0, static_cast<int>(std::floor(lowest.x))),
                right = std::min(grid_.share.width() - 1, static_cast<int>(std::ceil(highest.x)));
      const int top = std::max(0, static_cast<int>(std::floor(lowest.y))),
                bottom = std::min(grid_.share.height() - 1, static_cast<int>(std::ceil(highest.y)));
      for (int row = top; row <= bottom; ++row)
        for (int column = left; column <= right; ++column) {
          const glm::dvec2 pixel = grid_.first_px + grid_.step_px * glm::dvec2(column, row);
          const auto direction = scene.direction_at(pixel);
          if (!direction) continue;
          const glm::dvec3 ray(*direction);
          const double range = glm::dot(plane, corners[0]) / glm::dot(plane, ray);
          if (!(range > 0.0)) continue;
          const glm::dvec3 at = range * ray;
          const double of_1 = glm::dot(glm::cross(at - corners[0], corners[2] - corners[0]), plane) / area;
          const double of_2 = glm::dot(glm::cross(corners[1] - corners[0], at - corners[0]), plane) / area;
          if (of_1 < 0.0 || of_2 < 0.0 || of_1 + of_2 > 1.0) continue;
          Place place{column, row, pixel, ray, {}, range, 0, 0, 0, 0};
          place.normal = glm::normalize((1.0 - of_1 - of_2) * normals[0] + of_1 * normals[1] + of_2 * normals[2]);
          if (glm::dot(place.normal, ray) > 0.0) place.normal = -place.normal;
          place.left = box.left + static_cast<int>(grid_.step_px) * column;
          place.top = box.top + static_cast<int>(grid_.step_px) * row;
          place.right = std::min(place.left + static_cast<int>(grid_.step_px), scene.width);
          place.bottom = std::min(place.top + static_cast<int>(grid_.step_px), scene.height);
          int& known = nearest.at(column, row);
          if (known >= 0 && places_[static_cast<std::size_t>(known)].range_m <= range) continue;
          if (known < 0) {
            known = static_cast<int>(places_.size());
            places_.push_back(place);
            base_colours_.push_back(colour);
          }
          places_[static_cast<std::size_t>(known)] = place;
          base_colours_[static_cast<std::size_t>(known)] = colour;
        }
    }
  }
  if (scene.mask.empty()) return;
  std::vector<Place> open;
  std::vector<glm::dvec3> colours;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place& place = places_[i];
    int sum = 0, count = 0;
    for (int y = place.top; y < place.bottom; ++y)
      for (int x = place.left; x < place.right; ++x, ++count) sum += scene.mask.at(x, y);
    if (sum < kOpen * count) continue;
    open.push_back(place);
    colours.push_back(base_colours_[i]);
  }
  places_ = std::move(open);
  base_colours_ = std::move(colours);
}

std::vector<float> GroundWatch::supposed_reflectance(const glm::dmat3& albedo_to_channels) const {
  std::vector<float> reflectance(places_.size());
  std::ranges::transform(base_colours_, reflectance.begin(), [&](const glm::dvec3& colour) {
    return static_cast<float>(std::clamp((albedo_to_channels * colour).g, 0.0, 1.0));
  });
  return reflectance;
}

std::optional<double> GroundWatch::light_of(const Place& place, const PictureView& picture) const {
  double sum = 0.0;
  int count = 0;
  for (int y = place.top; y < place.bottom; ++y)
    for (int x = place.left; x < place.right; ++x, ++count) {
      const auto green = rgb_at(picture, x, y).g;
      if (green > kWhite * 255.0) return std::nullopt;
      sum += green_[green];
    }
  if (count == 0) return std::nullopt;
  return sum / count;
}

void GroundWatch::see(const PictureView& picture, const FrameMetadata& metadata, const ObjectAppearance& appearance,
                      const AirlightGrid& measured) {
  const ObjectLight& light = appearance.light;
  if (!memory_) {
    memory_.emplace(supposed_reflectance(light.albedo_to_channels));
    if (resumed_) memory_->resume(resumed_->shares, resumed_->since_s);
    resumed_.reset();
  }
  SlopeIrradiance slopes(light.around);
  const bool sunless = light.sun_irradiance.g <= 0.0;
  std::vector<GroundSight> sights(places_.size());
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place& place = places_[i];
    const auto seen = light_of(place, picture);
    if (!seen) continue;
    const double infinity = airlight_at(measured, place.pixel).g;
    const double gain = infinity / airlight_at(appearance.horizon, place.pixel).g;
    const double left = green_attenuation(appearance.haze, place.range_m, place.range_m * place.direction.z).g;
    const double air = appearance.aerial_perspective ? (1.0 - left) * infinity : 0.0;
    const double own = *seen - air, unit = gain * (appearance.aerial_perspective ? left : 1.0);
    if (!(own > 0.0) || !(unit > 0.0)) continue;
    const double sun = light.sun_irradiance.g * std::max(glm::dot(place.normal, light.sun_direction), 0.0) / kPi;
    const double sigma = std::hypot(kAirSigma * air / own, sunless ? kSunlessSigma : 0.01);
    sights[i] = {static_cast<float>(own / unit), static_cast<float>(sun), static_cast<float>(slopes.on(place.normal)),
                 static_cast<float>(sigma)};
  }
  memory_->see(sights, to_seconds(metadata.captured_at.time_since_epoch()));
  if (sunless) return;  // unknown, and not needed

  auto sunlight = std::make_shared<GroundSunlight>(grid_);
  Image<std::uint8_t> known(grid_.share.width(), grid_.share.height(), 0);
  std::size_t sure = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const GroundGuess& guess = memory_->guesses()[i];
    sunlight->share.at(places_[i].column, places_[i].row) = guess.sunlit;
    known.at(places_[i].column, places_[i].row) = 1;
    sure += static_cast<double>(guess.sigma) <= kUnsure ? 1 : 0;
  }
  spread(sunlight->share, std::move(known));
  look_.sunlight = std::move(sunlight);
  look_.known = static_cast<double>(sure) / static_cast<double>(places_.size());
}

void GroundWatch::shade_foot(bool whole) {
  if (!work_) return;
  bool done = work_->step();
  while (!done && whole) done = work_->step();
  if (!done) return;
  look_.sky = work_->take();
  work_.reset();
}

}  // namespace kasumi

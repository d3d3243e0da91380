#include "pipeline/lab/prove/proof.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>

#include "base/statistics.hpp"
#include "estimator/air/attenuation.hpp"
#include "estimator/photograph/lens_drops.hpp"
#include "estimator/sky/sun.hpp"

namespace kasumi {
namespace {

constexpr double kNight_deg = 3.0, kLowSun_deg = 8.0;
constexpr double kGreen_nm = 550.0;
constexpr double kClearShare = 0.3;  // of the pictures measure the facade, those with the least air before it ...
constexpr double kClearDepth = 0.7;  // ... and where its own light is at least half of what is seen
constexpr int kFewestClear = 3;
constexpr std::size_t kFewestAlike = 5;
constexpr double kAlikeShare = 0.25;  // of the clear pictures in the shade
using Day = std::chrono::sys_days;

// Where no time is known each picture is a day of its own.
Day day_of(const ProofInputs& scene, std::size_t view) {
  const auto& utc = scene.views[view].utc;
  return utc ? std::chrono::floor<std::chrono::days>(*utc) : Day{} - std::chrono::days(1 + static_cast<int>(view));
}

glm::dvec3 encoded_255(const ProofInputs& scene, const glm::dvec3& light) {
  const auto& box = scene.part.surface;
  const glm::dvec2 middle{box.x + 0.5 * box.width, box.y + 0.5 * box.height};
  const auto seen = light * scene.camera.white_balance * scene.camera.vignetting.at(middle);
  return 255.0 * glm::clamp(scene.camera.response.to_encoded(seen), 0.0, 1.0);
}

std::string class_of(const ProofView& view, const ProofEntry& picture) {
  if (!view.label.empty()) return view.label;
  if (picture.sun_elevation_deg && *picture.sun_elevation_deg < kLowSun_deg) return "low sun";
  if (!picture.air.unknown.empty()) return "unknown";
  const double molecules = rayleigh_per_m(ScatteringModel::aerosol, kGreen_nm);
  return std::string(name_of(weather_class(std::max(0.0, picture.air.per_m.g - molecules))));
}

void place_sun(const ProofInputs& scene, const ProveRequest& request, const ProofView& view, ProofEntry& picture) {
  if (!scene.site || !view.utc) return;
  const auto sun = sun_position(*view.utc, *scene.site);
  const double elevation = 90.0 - to_degrees(sun.zenith), azimuth = to_degrees(sun.azimuth);
  picture.sun_elevation_deg = elevation;
  picture.sun_azimuth_deg = azimuth;
  if (!request.faces_deg || elevation < 0.0) return;
  const double incidence =
      std::cos(from_degrees(elevation).value) * std::cos(from_degrees(azimuth - *request.faces_deg).value);
  picture.sunlit = std::max(0.0, incidence);
}

std::string why_left_out(const ProofView& view, const ProofEntry& picture) {
  if (picture.sun_elevation_deg && *picture.sun_elevation_deg < kNight_deg)
    return fmt::format("night: the sun stands {:.1f} deg high", *picture.sun_elevation_deg);
  if (!view.unusable.empty()) return view.unusable;
  if (view.blurred_share >= kDropsOnLens)
    return fmt::format("drops on the lens: {:.0f} % of the picture is blurred", 100.0 * view.blurred_share);
  if (view.sky_clipped) return "the sky beside it is brighter than full scale";
  if (std::min({view.sky.light.r, view.sky.light.g, view.sky.light.b}) <= 0.0)
    return "no light from infinity beside it";
  if (!picture.air.unknown.empty()) return "the other landmarks yield no air: " + picture.air.unknown;
  return {};
}

// The pictures with the least air before the facade.
void choose_clear(const ProofInputs& scene, std::vector<ProofEntry>& pictures) {
  std::vector<double> depths;
  const auto may_measure = [](const ProofEntry& picture) {
    return picture.left_out.empty() && picture.sun_elevation_deg.value_or(90.0) >= kLowSun_deg;
  };
  for (const auto& picture : pictures)
    if (may_measure(picture)) depths.push_back(picture.air.per_m.g * scene.part.distance_m);
  const double most = std::min(kClearDepth, quantile(depths, kClearShare));
  for (auto& picture : pictures)
    picture.clear = may_measure(picture) && picture.air.per_m.g * scene.part.distance_m <= most;
}

// Between the suns of two pictures, degrees; 0 where no place is known.
double apart(const ProofEntry& one, const ProofEntry& other) {
  if (!one.sun_elevation_deg || !other.sun_elevation_deg) return 0.0;
  const auto towards = [](const ProofEntry& picture) {
    return direction_from(from_degrees(90.0 - *picture.sun_elevation_deg), from_degrees(*picture.sun_azimuth_deg));
  };
  return to_degrees(angle_between(towards(one), towards(other)));
}

class Painter {
 public:
  Painter(const ProofInputs& scene, const std::vector<ProofEntry>& pictures) : scene_(scene) {
    for (const auto& picture : pictures) {
      const auto& view = scene.views[picture.view];
      FacadeView one;
      one.light = scene.light_of_part(scene.part_of(view));
      one.sky = view.sky;
      one.depth = picture.air.per_m * scene.part.distance_m;
      one.depth_sigma = picture.air.sigma_per_m * scene.part.distance_m;
      one.sunlit = picture.sunlit;
      views_.push_back(std::move(one));
    }
    for (const auto& picture : pictures) facades_.push_back(measured_for(pictures, &picture));
    whole_ = measured_for(pictures, nullptr);
  }
  const std::optional<Facade>& whole() const { return whole_; }
  const std::optional<Facade>& facade_of(std::size_t i) const { return facades_[i]; }
  const FacadeView& view(std::size_t i) const { return views_[i]; }

  glm::dvec3 mean_255(std::size_t i, const glm::dvec3& depth) const {
    return encoded_255(scene_, mean_of(put_back(*facades_[i], views_[i].sky, depth, views_[i].sunlit)));
  }

 private:
  // By the clear pictures of other days; in the shade by those whose sun stood most like the picture's, since where the
  // sun stands the horizon is brighter, and glass shows another part of the sky. Null: by all.
  std::optional<Facade> measured_for(const std::vector<ProofEntry>& pictures, const ProofEntry* one) const {
    std::vector<const FacadeView*> lit;
    std::vector<std::pair<double, const FacadeView*>> shaded;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const auto& other = pictures[i];
      if (!other.clear || (one && day_of(scene_, other.view) == day_of(scene_, one->view))) continue;
      if (other.sunlit > 0.0)
        lit.push_back(&views_[i]);
      else
        shaded.emplace_back(one ? apart(*one, other) : 0.0, &views_[i]);
    }
    std::ranges::stable_sort(shaded, {}, [](const auto& view) { return view.first; });
    const auto enough =
        std::max(kFewestAlike, static_cast<std::size_t>(kAlikeShare * static_cast<double>(shaded.size())));
    if (one && shaded.size() > enough) shaded.resize(enough);
    for (const auto& view : shaded) lit.push_back(view.second);
    return measure_facade(lit);
  }

  const ProofInputs& scene_;
  std::vector<FacadeView> views_;
  std::vector<std::optional<Facade>> facades_;
  std::optional<Facade> whole_;
};

glm::dvec3 fixed_depth(const ProofInputs& scene) {
  const auto nodes = attenuation_nodes(spectral_measure(scene.camera));
  return scene.part.distance_m * model_extinction_per_m(nodes, ScatteringModel::morales2017,
                                                        Turbidity{kPapersTurbidity}, scene.altitude_m,
                                                        scene.part.distance_m);
}

// The depth, by channel, under which the median of the judged pictures' differences is least.
glm::dvec3 constant_depth(const Painter& painter, const std::vector<ProofEntry>& pictures) {
  constexpr int kSteps = 80;
  constexpr double kLeast = 0.005, kMost = 5.0;
  glm::dvec3 best{0.0}, least{1e9};
  for (int k = 0; k < kSteps; ++k) {
    const double depth = kLeast * std::pow(kMost / kLeast, k / (kSteps - 1.0));
    std::array<std::vector<double>, 3> off;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      if (!pictures[i].judged()) continue;
      const auto difference = glm::abs(painter.mean_255(i, glm::dvec3(depth)) - pictures[i].seen_255);
      for (std::size_t c = 0; c < 3; ++c) off[c].push_back(difference[static_cast<int>(c)]);
    }
    for (int c = 0; c < 3; ++c) {
      const double middle = median(std::move(off[static_cast<std::size_t>(c)]));
      if (middle < least[c]) {
        least[c] = middle;
        best[c] = depth;
      }
    }
  }
  return best;
}

void judge(const ProofInputs& scene, const Painter& painter, std::size_t i, ProofEntry& picture) {
  const auto& facade = painter.facade_of(i);
  const auto& view = painter.view(i);
  if (!facade && picture.left_out.empty()) picture.left_out = "too few clear pictures of other days";
  if (!facade || !picture.air.unknown.empty()) return;
  if (picture.sunlit > 0.0 && facade->lit.empty() && picture.left_out.empty())
    picture.left_out = fmt::format("the sun is on it ({:.0f} deg), and too few clear pictures show it lit",
                                   picture.sun_azimuth_deg.value_or(0.0));
  picture.drawn = true;
  const auto mean = mean_of(view.light);
  picture.seen_255 = encoded_255(scene, mean);
  const auto drawn = put_back(*facade, view.sky, view.depth, view.sunlit);
  picture.drawn_255[0] = encoded_255(scene, mean_of(drawn));
  const auto slope = 255.0 / glm::max(scene.camera.response.slope(picture.drawn_255[0] / 255.0), 1e-6);
  const auto sigma = slope * put_back_sigma(*facade, view);
  picture.sigma_255 = glm::sqrt(sigma * sigma + 0.25);  // and half a step of the camera's
  double sum = 0.0;
  const auto seen = scene.part_of(scene.views[picture.view]);
  picture.part = Image<Rgb8>(seen.width(), seen.height());
  for (std::size_t k = 0; k < drawn.elements().size(); ++k) {
    const auto pixel = encoded_255(scene, drawn.elements()[k]);
    picture.part.elements()[k] = Rgb8(glm::round(pixel));
    const auto off = pixel - 255.0 * glm::dvec3(seen.elements()[k]);
    sum += (std::abs(off.r) + std::abs(off.g) + std::abs(off.b)) / 3.0;
  }
  picture.pixel_error_255 = sum / static_cast<double>(drawn.elements().size());
}

}  // namespace

std::string_view name_of(ProofWay way) {
  switch (way) {
    case ProofWay::no_air: return "no_air";
    case ProofWay::fixed_t: return "fixed_t3";
    case ProofWay::constant: return "best_constant";
    case ProofWay::told: break;
  }
  return "told";
}

double ProofEntry::error_255(ProofWay way) const {
  const auto off = glm::abs(drawn_by(way) - seen_255);
  return (off.r + off.g + off.b) / 3.0;
}

Result<Proof> prove(const ProveRequest& request) {
  auto scene = read_proof_inputs(request);
  if (!scene) return fail(scene.error());
  Proof proof;
  proof.scene = std::move(*scene);
  std::vector<AirByOthers> airs;
  if (request.air.empty()) {
    airs = air_by_landmarks(proof.scene);
  } else {
    auto table = air_by_table(proof.scene, request.air);
    if (!table) return fail(table.error());
    airs = std::move(*table);
  }
  for (std::size_t i = 0; i < airs.size(); ++i) {
    ProofEntry picture;
    picture.view = i;
    picture.air = std::move(airs[i]);
    const auto& view = proof.scene.views[i];
    place_sun(proof.scene, request, view, picture);
    picture.air_class = class_of(view, picture);
    picture.left_out = why_left_out(view, picture);
    proof.pictures.push_back(std::move(picture));
  }
  choose_clear(proof.scene, proof.pictures);
  const Painter painter(proof.scene, proof.pictures);
  if (!painter.whole())
    return fail(FaultKind::bad_input,
                "{}: fewer than {} clear pictures with {} in the shade: expected a month of hourly pictures, or "
                "--faces-deg as it is",
                request.scenes.front(), kFewestClear, request.part);
  const auto& whole = *painter.whole();
  proof.shade = whole.mean_shade();
  proof.shade_sigma = whole.shade_sigma;
  if (!whole.lit.empty()) proof.lit = mean_of(whole.lit);
  proof.shaded_views = whole.shaded_views;
  proof.lit_views = whole.lit_views;
  for (std::size_t i = 0; i < proof.pictures.size(); ++i) judge(proof.scene, painter, i, proof.pictures[i]);
  proof.fixed_depth = fixed_depth(proof.scene);
  const auto constant = constant_depth(painter, proof.pictures);
  proof.constant_per_m = constant / proof.scene.part.distance_m;
  for (std::size_t i = 0; i < proof.pictures.size(); ++i) {
    if (!proof.pictures[i].drawn) continue;
    proof.pictures[i].drawn_255[1] = painter.mean_255(i, glm::dvec3(0.0));
    proof.pictures[i].drawn_255[2] = painter.mean_255(i, proof.fixed_depth);
    proof.pictures[i].drawn_255[3] = painter.mean_255(i, constant);
  }
  return proof;
}

}  // namespace kasumi

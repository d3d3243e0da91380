#include "tests/estimator/sky_camera/sun_pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/aerosol.hpp"
#include "base/units.hpp"
#include "calib/colour/colorimetry.hpp"
#include "fixtures/light/clouds.hpp"
#include "fixtures/light/sky.hpp"
#include "fixtures/noise/noise.hpp"
#include "fixtures/noise/random.hpp"
#include "tests/opencv_pictures.hpp"
#include "tests/places.hpp"

namespace kasumi::test {
namespace {

using fixtures::Random;

double between(Random& random, double low, double high) {
  return low + (high - low) * random.uniform();
}
bool once_in(Random& random, double times) {
  return random.uniform() * times < 1.0;
}

// Preetham's sky in units in which the sun's beam is about 1 on a clear day.
CloudlessSky papers_sky(double turbidity, const Direction& sun) {
  const fixtures::ClearSky clear(turbidity, sun);
  CloudlessSky sky;
  sky.sun = sun;
  sky.light = [clear](const Direction& d) {
    const auto colour = clear.colour(d);
    const double y = std::max(0.0, colour.luminance), cx = colour.chromaticity.x, cy = colour.chromaticity.y;
    return xyz_to_linear_srgb() * glm::dvec3{y * cx / cy, y, y * (1.0 - cx - cy) / cy};
  };
  const double way = 1.0 / (sun.z + 0.06);
  sky.sun_irradiance = 128000.0 * glm::exp(-way * (glm::dvec3{0.05, 0.1, 0.22} + 0.05 * (turbidity - 1.5)));
  return sky;
}

// The same sky with its sun at another azimuth.
CloudlessSky turned(const CloudlessSky& sky, double azimuth) {
  const double turn = azimuth - azimuth_angle(sky.sun).value;
  CloudlessSky other = sky;
  other.sun = direction_from(zenith_angle(sky.sun), {azimuth});
  other.light = [sky, turn](const Direction& d) {
    return sky.light(direction_from(zenith_angle(d), {azimuth_angle(d).value - turn}));
  };
  return other;
}

double mean_of(const glm::dvec3& v) {
  return (v.x + v.y + v.z) / 3.0;
}

// How a lens spreads the light of a point, and what it mirrors elsewhere.
struct Glare {
  double share, radius_px, slope;  // skirts: (1 + (r / radius)^2)^(-slope / 2)
  double veil;
  int rays;
  double ray_angle, ray_height, ray_width_px;
  struct Ghost {
    double place, radius_px, level;
    glm::dvec3 colour;
    bool ring;
  };
  std::vector<Ghost> ghosts;
  double smear;
  double stretch;  // along the radius, off the axis
  double lean;     // coma: more of it on one side

  static Glare draw(Random& random, SunSet set, double circle_px) {
    const bool held_out = set == SunSet::held_out;
    Glare g{};
    g.share = std::exp(between(random, std::log(0.01), std::log(0.25)));
    g.radius_px = between(random, 0.7, 3.5);
    g.slope = held_out ? between(random, 2.1, 3.4) : between(random, 2.2, 3.0);
    g.veil = std::exp(between(random, std::log(0.002), std::log(0.06)));
    g.rays = once_in(random, 2.0) ? 0 : 2 * static_cast<int>(between(random, 2.0, 9.0));
    g.ray_angle = between(random, 0.0, kPi);
    g.ray_height = std::exp(between(random, std::log(0.5), std::log(10.0)));
    g.ray_width_px = between(random, 0.6, 2.5);
    const int ghosts = static_cast<int>(between(random, 0.0, held_out ? 6.0 : 5.0));
    for (int i = 0; i < ghosts; ++i)
      g.ghosts.push_back({between(random, -1.2, 0.7),
                          circle_px * between(random, 0.01, 0.1),
                          std::exp(between(random, std::log(0.05), std::log(3.0))),
                          {between(random, 0.2, 1.0), between(random, 0.2, 1.0), between(random, 0.2, 1.0)},
                          once_in(random, 3.0)});
    g.smear = once_in(random, 10.0) ? between(random, 0.1, 1.0) : 0.0;
    g.stretch = between(random, -0.25, 0.4);
    g.lean = std::clamp(0.25 * random.normal(), -0.6, 0.6);
    return g;
  }

  // Share of the point's light per pixel.
  double spread(const glm::dvec2& offset, const glm::dvec2& outwards, double off_axis) const {
    const double along = glm::dot(offset, outwards);
    const glm::dvec2 squeezed = offset + outwards * along * (1.0 / (1.0 + stretch * off_axis * off_axis) - 1.0);
    const double r = glm::length(squeezed);
    constexpr double kFar_px = 400.0;
    const double total =
        2.0 * kPi * radius_px * radius_px / (slope - 2.0) * (1.0 - std::pow(kFar_px / radius_px, 2.0 - slope));
    double skirt = std::pow(1.0 + r * r / (radius_px * radius_px), -0.5 * slope) / total;
    skirt *= 1.0 + lean * off_axis * along / (r + 3.0 * radius_px);
    if (rays > 0) {
      const double step = 2.0 * kPi / rays;
      const double from_ray = std::remainder(std::atan2(offset.y, offset.x) - ray_angle, step);
      const double aside = std::abs(r * std::sin(from_ray)) / ray_width_px;
      skirt *= 1.0 + ray_height * std::exp(-aside * aside) / (1.0 + r / 60.0);
    }
    const double core = std::exp(-0.5 * r * r / (0.8 * 0.8)) / (2.0 * kPi * 0.8 * 0.8);
    return (1.0 - share) * core + share * skirt;
  }
};

// What a picture's numbers are of light 0..1.
double encoded_of(double light, int curve) {
  const double v = std::clamp(light, 0.0, 1.0);
  switch (curve) {
    case 0: return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
    case 1: return v;
    case 2: return std::pow(v, 1.0 / 2.2);
    case 3: {  // a film's: steep in the middle, soft at both ends
      const double g = std::pow(v, 1.0 / 2.2);
      return g * g * (3.0 - 2.0 * g) * 0.5 + 0.5 * g;
    }
    default: {  // a shoulder that never quite clips
      const double x = 3.0 * light;
      return std::pow(std::min(1.0, x * (1.0 + x / 16.0) / (1.0 + x)), 1.0 / 2.2);
    }
  }
}

struct Obstacles {
  double base_deg, rough_deg, hill_deg;
  std::uint64_t seed;
  double light;  // of white
  double top_deg(double azimuth) const {
    const glm::dvec2 at{3.0 * std::cos(azimuth), 3.0 * std::sin(azimuth)};
    const double trees = fixtures::fractal_noise(seed + 1, 12.0 * at, 5, 0.6);
    const double hills = std::max(0.0, fixtures::fractal_noise(seed, 0.5 * at, 3));
    return base_deg + rough_deg * trees + hill_deg * hills;
  }
};

// A veil of ice: streaks on a plane. Optical depth.
double veil_depth(const Direction& d, std::uint64_t seed, double depth) {
  const double z = std::max(d.z, 0.08);
  const glm::dvec2 at{d.x / z, d.y / z};
  const double streaks = fixtures::fractal_noise(seed, {0.7 * at.x + 0.2 * at.y, 2.5 * at.y}, 5, 0.6);
  return depth * std::clamp(0.6 + 1.2 * streaks, 0.0, 2.0);
}

double henyey_greenstein(double cosine, double g) {
  return (1.0 - g * g) / (4.0 * kPi * std::pow(1.0 + g * g - 2.0 * g * cosine, 1.5));
}

// Clouds of either kind before the sky.
class Clouds {
 public:
  Clouds(SunScene scene, SunSet set, const Direction& sun, Random& random) {
    if (scene == SunScene::thin_clouds) {
      veil_seed_ = 100 + static_cast<std::uint64_t>(1e6 * random.uniform());
      veil_ = between(random, 0.2, 1.6);
    }
    const double cover = scene == SunScene::broken_clouds || scene == SunScene::hidden ? between(random, 0.15, 0.75)
                         : scene == SunScene::thin_clouds && once_in(random, 2.0)      ? between(random, 0.05, 0.4)
                                                                                       : 0.0;
    if (cover <= 0.0) return;
    // Moved by the wind until the sun is where it is to be.
    const std::uint64_t seed =
        10 + static_cast<std::uint64_t>(1e6 * random.uniform()) + (set == SunSet::held_out ? 5000000u : 0u);
    const fixtures::CloudLayer first(seed, cover, 0.0, sun);
    for (int minute = 0; minute < 400; ++minute) {
      layer_.emplace(seed, scene == SunScene::hidden ? std::max(cover, 0.6) : cover, 53.0 * minute, sun);
      const double open = layer_->at(sun, 0.006).opacity;
      if (scene == SunScene::hidden ? layer_->at(sun, 0.006).thickness > 0.6 : open < 0.25) break;
      if (minute > 12) break;
    }
  }
  // Of light that comes from d.
  double beam(const Direction& d) const {
    double depth = veil_ > 0.0 ? veil_depth(d, veil_seed_, veil_) : 0.0;
    if (layer_) {
      const auto cloud = layer_->at(d, 0.006);
      depth += cloud.opacity * (0.8 + 14.0 * cloud.thickness);
    }
    return std::exp(-depth);
  }
  glm::dvec3 before(const glm::dvec3& sky, const Direction& d, double gamma, const glm::dvec3& white,
                    const glm::dvec3& beam_light) const {
    glm::dvec3 light = sky;
    if (veil_ > 0.0) {
      const double depth = veil_depth(d, veil_seed_, veil_), through = std::exp(-depth);
      light = light * through + (1.0 - through) * 0.35 * white +
              beam_light * depth * std::exp(-veil_) * 0.5 * henyey_greenstein(std::cos(gamma), 0.93);
    }
    if (layer_) {
      const auto cloud = layer_->at(d, 0.006);
      const double silver = 1.0 + 1.6 * std::exp(-gamma / 0.16) * (1.0 - cloud.thickness);
      const glm::dvec3 own = std::lerp(0.95, 0.42, cloud.thickness) * (1.0 + 0.28 * cloud.relief) * silver * white;
      const double thin = cloud.opacity * std::exp(-3.0 * cloud.thickness);
      light = glm::mix(light, own, cloud.opacity) + beam_light * 0.25 * thin * henyey_greenstein(std::cos(gamma), 0.85);
    }
    return light;
  }

 private:
  std::uint64_t veil_seed_ = 0;
  double veil_ = 0.0;
  std::optional<fixtures::CloudLayer> layer_;
};

LensPtr lens_of(int projection, const glm::dvec2& centre, double circle_px, double edge) {
  if (projection == 0) return equidistant_lens(centre, circle_px / edge, {edge});
  return equisolid_lens(centre, circle_px / (2.0 * std::sin(0.5 * edge)), {edge});
}

Image<Rgb8> as_jpeg(const Image<glm::dvec3>& encoded, int quality) {
  cv::Mat3b bgr(encoded.height(), encoded.width());
  for (int y = 0; y < bgr.rows; ++y)
    for (int x = 0; x < bgr.cols; ++x) {
      const glm::dvec3 v = glm::round(255.0 * glm::clamp(encoded.at(x, y), 0.0, 1.0));
      bgr(y, x) = {static_cast<std::uint8_t>(v.b), static_cast<std::uint8_t>(v.g), static_cast<std::uint8_t>(v.r)};
    }
  return rgb_of(quality > 0 ? through_jpeg(bgr, quality) : bgr);
}

}  // namespace

const char* name_of(SunScene scene) {
  switch (scene) {
    case SunScene::clear: return "clear";
    case SunScene::thin_clouds: return "thin clouds before it";
    case SunScene::broken_clouds: return "between clouds";
    case SunScene::hidden: return "behind clouds";
    case SunScene::overcast: return "overcast";
    case SunScene::dusk: return "after sunset";
  }
  return "";
}

SunWorld::SunWorld(SunSet set) : set_(set) {
  const bool held_out = set == SunSet::held_out;
  struct Case {
    AerosolKind kind;
    double aod, sun_deg;
  };
  const std::vector<Case> cases =
      held_out ? std::vector<Case>{{AerosolKind::maritime, 0.2, 23.0}, {AerosolKind::smoke, 0.5, 47.0}}
               : std::vector<Case>{{AerosolKind::continental, 0.1, 35.0}, {AerosolKind::dust, 0.6, 16.0}};
  for (const Case& c : cases) {
    reference::Air air;
    air.aerosol = {c.aod, natural_exponent(c.kind), c.kind};
    const reference::ReferenceSky sky(air, 40.0, reference::suns_around_deg(90.0 - c.sun_deg));
    tabulated_.push_back(simulated_sky(sky, 300.0, direction_from(from_degrees(90.0 - c.sun_deg), {0.0})));
  }
  const auto measured = measured_skies((shared_data_folder() / "sky" / "cornell").string());
  for (std::size_t i = held_out ? 1 : 0; i < measured.size(); i += 2) tabulated_.push_back(measured[i]);
}

CloudlessSky SunWorld::sky_for(double elevation_deg, std::uint64_t seed) const {
  Random random(seed * 77 + 5);
  const double azimuth = between(random, 0.0, 2.0 * kPi);
  if (once_in(random, 2.0)) {
    const auto& sky = tabulated_[static_cast<std::size_t>(random.uniform() * static_cast<double>(tabulated_.size()))];
    return turned(sky, azimuth);
  }
  const double turbidity = set_ == SunSet::held_out ? between(random, 2.2, 9.0) : between(random, 2.0, 7.0);
  return papers_sky(turbidity, direction_from(from_degrees(90.0 - elevation_deg), {azimuth}));
}

SunPicture SunWorld::draw(SunScene scene, std::uint64_t seed) const {
  const bool held_out = set_ == SunSet::held_out;
  Random random(seed + (held_out ? 900000 : 0));
  SunPicture picture;

  // The camera, and what it is taken for.
  const int side = static_cast<int>(between(random, 220.0, held_out ? 520.0 : 480.0));
  const double circle_px = between(random, 0.44, 0.49) * side, edge = from_degrees(between(random, 85.0, 94.0)).value;
  const glm::dvec2 centre = glm::dvec2{0.5 * (side - 1)} + 0.01 * side * glm::dvec2{random.normal(), random.normal()};
  Camera truth;
  truth.name = "sky";
  truth.width = truth.height = side;
  const int projection = once_in(random, 2.0) ? 0 : 1;
  truth.lens = lens_of(projection, centre, circle_px, edge);
  const double tilt_deg = between(random, 0.0, 4.0), heading = between(random, 0.0, 6.28);
  truth.to_world = camera_to_world({heading}, from_degrees(90.0 - tilt_deg), {0.0});
  picture.camera = truth;
  const bool mistaken = once_in(random, 4.0);
  if (mistaken) picture.camera.lens = lens_of(1 - projection, centre, circle_px, edge);

  // The sky.
  const double elevation_deg = std::exp(between(random, std::log(scene == SunScene::dusk ? 2.0 : 5.0), std::log(75.0)));
  CloudlessSky sky = sky_for(scene == SunScene::dusk ? 0.5 : elevation_deg, seed + (held_out ? 900000 : 0));
  if (scene == SunScene::dusk) {
    sky = papers_sky(between(random, 2.0, 5.0), direction_from(from_degrees(89.5), azimuth_angle(sky.sun)));
  }
  const Direction sun = sky.sun;
  const Clouds clouds(scene, set_, sun, random);
  const double white_level =
      (mean_of(sky.light({0.0, 0.0, 1.0})) * kPi + std::max(0.0, sun.z) * mean_of(sky.sun_irradiance)) / kPi;
  const glm::dvec3 white = white_level * glm::dvec3{1.0, 1.0, 0.97};
  Obstacles obstacles{between(random, -6.0, 6.0), between(random, 0.0, 6.0), between(random, 0.0, 30.0), seed * 3 + 1,
                      once_in(random, 8.0) ? between(random, 0.2, 0.8) : between(random, 0.01, 0.1)};
  const double sun_elevation_deg = 90.0 - to_degrees(zenith_angle(sun));
  const bool wants_sun = scene != SunScene::hidden && scene != SunScene::overcast && scene != SunScene::dusk;
  if (wants_sun)  // it stands above the trees
    obstacles.base_deg += std::min(0.0, sun_elevation_deg - 1.5 - obstacles.top_deg(azimuth_angle(sun).value));
  double beam = scene == SunScene::overcast || scene == SunScene::dusk ? 0.0 : clouds.beam(sun);
  if (obstacles.top_deg(azimuth_angle(sun).value) > sun_elevation_deg) beam = 0.0;

  const bool occulted = wants_sun && once_in(random, 25.0);
  const double disc_rad = from_degrees(between(random, 1.5, 3.5)).value, arm = between(random, 0.0, 6.28);
  if (occulted) picture.remark += " occulting disc";
  const auto sun_px = *truth.pixel_of(sun);
  picture.sun_px = sun_px;
  picture.visible = beam > 0.1;
  if (const auto seen = picture.camera.direction_at(sun_px)) picture.sun = *seen;

  // Light.
  const Glare glare = Glare::draw(random, set_, circle_px);
  const double pixel_sr = std::pow(edge / circle_px, 2.0);
  const double through = occulted ? 0.0 : beam;
  const glm::dvec2 from_centre = sun_px - centre;
  const double off_axis = glm::length(from_centre) / circle_px;
  const glm::dvec2 outwards = off_axis > 1e-3 ? from_centre / glm::length(from_centre) : glm::dvec2{1.0, 0.0};
  const glm::dvec3 balance{between(random, 0.8, 1.25), 1.0, between(random, 0.8, 1.25)};
  Image<glm::dvec3> light(side, side, glm::dvec3(0.0));
  std::vector<double> levels;
  const double overcast_relief = between(random, 0.05, 0.6);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const auto d = truth.direction_at({x, y});
      if (!d) continue;
      glm::dvec3 rgb;
      const double up_deg = 90.0 - to_degrees(zenith_angle(*d));
      const double gamma = angle_between(*d, sun).value;
      if (up_deg < std::max(0.0, obstacles.top_deg(azimuth_angle(*d).value))) {
        rgb = obstacles.light * white * glm::dvec3{0.9, 1.0, 0.7} *
              (1.0 + 0.5 * fixtures::fractal_noise(seed + 9, 40.0 * glm::dvec2(*d), 4));
      } else if (scene == SunScene::overcast) {
        const glm::dvec2 at = glm::dvec2(*d) / (d->z + 0.15);
        const double relief = fixtures::fractal_noise(seed + 3, 1.3 * at, 5, 0.55);
        rgb = 0.3 * white * (1.0 + 2.0 * d->z) / 3.0 * std::max(0.1, 1.0 + overcast_relief * relief) *
              (1.0 + 0.5 * std::exp(-gamma * gamma / 0.3));
      } else {
        rgb = clouds.before(sky.light(*d), *d, gamma, white, sky.sun_irradiance);
      }
      if (occulted) {
        const glm::dvec2 offset = glm::dvec2{x, y} - sun_px;
        const glm::dvec2 along{std::cos(arm), std::sin(arm)};
        const bool on_arm = glm::dot(offset, along) > 0.0 &&
                            std::abs(offset.x * along.y - offset.y * along.x) < 0.4 * disc_rad * circle_px / edge;
        if (gamma < disc_rad || on_arm) rgb = 0.02 * white;
      }
      light.at(x, y) = rgb * balance;
      levels.push_back(mean_of(rgb));
    }
  const double mean_level = [&] {
    double sum = 0.0;
    for (const double level : levels) sum += level;
    return sum / static_cast<double>(levels.size());
  }();
  // What the lens makes of the beam.
  const glm::dvec3 beam_light = through * sky.sun_irradiance * balance;
  if (through > 0.0)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const glm::dvec2 offset = glm::dvec2{x, y} - sun_px;
        glm::dvec3 extra = beam_light * glare.spread(offset, outwards, off_axis) / pixel_sr;
        if (truth.direction_at({x, y})) extra += beam_light * glare.veil / (2.0 * kPi);
        if (glare.smear > 0.0 && std::abs(offset.x) < 1.0) extra += glare.smear * glm::dvec3(mean_level);
        for (const auto& ghost : glare.ghosts) {
          const glm::dvec2 place = centre + ghost.place * from_centre;
          const double r = glm::distance(glm::dvec2{x, y}, place) / ghost.radius_px;
          const double shape = ghost.ring ? std::exp(-std::pow((r - 0.8) / 0.15, 2.0)) : 1.0 / (1.0 + std::pow(r, 8.0));
          extra += through * ghost.level * mean_level * shape * ghost.colour;
        }
        light.at(x, y) += extra;
      }

  // The sensor.
  std::ranges::nth_element(levels, levels.begin() + static_cast<std::ptrdiff_t>(levels.size() * 9 / 10));
  const double stops = between(random, -2.0, 2.0);
  const double gain = 0.6 * std::exp2(stops) / levels[levels.size() * 9 / 10];
  const int curve = held_out ? std::array{0, 0, 2, 3, 4, 4}[static_cast<std::size_t>(random.uniform() * 6)]
                             : std::array{0, 0, 0, 1, 2, 3}[static_cast<std::size_t>(random.uniform() * 6)];
  const double noise = std::exp(between(random, std::log(0.002), std::log(0.02)));
  const bool black_sun = once_in(random, 12.0);
  if (black_sun) picture.remark += " black sun";
  Image<glm::dvec3> encoded(side, side);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      glm::dvec3 value = gain * light.at(x, y);
      const bool inverted = black_sun && value.g > 400.0;
      for (int c = 0; c < 3; ++c) {
        const double v =
            inverted ? 0.1 : value[c] + noise * random.normal() * std::sqrt(std::clamp(value[c], 0.0, 1.0) + 0.003);
        encoded.at(x, y)[c] = encoded_of(v, curve);
      }
    }
  const int quality = once_in(random, 6.0) ? 0 : static_cast<int>(between(random, held_out ? 55.0 : 60.0, 93.0));
  picture.pixels = as_jpeg(encoded, quality);
  picture.remark +=
      fmt::format(" el {:.0f} exp {:+.1f} curve {} q {}{}{}{}", sun_elevation_deg, stops, curve, quality,
                  mistaken ? " other lens" : "", glare.smear > 0.0 ? " smear" : "", glare.rays > 0 ? " rays" : "");
  return picture;
}

}  // namespace kasumi::test

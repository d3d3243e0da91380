#include "tests/calib/mask/rim_pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "base/units.hpp"
#include "fixtures/noise/noise.hpp"
#include "fixtures/noise/random.hpp"
#include "tests/opencv_pictures.hpp"

namespace kasumi::test {
namespace {

using fixtures::fractal_noise;
using fixtures::Random;

double between(Random& random, double low, double high) {
  return low + (high - low) * random.uniform();
}
bool once_in(Random& random, double times) {
  return random.uniform() * times < 1.0;
}
std::uint64_t seed_of(RimSet set, std::uint64_t seed) {
  return fixtures::mix(seed + (set == RimSet::held_out ? 700000u : 0u));
}

using Light = Image<glm::dvec3>;

// What a sensor and JPEG make of light, 1 white.
Image<Rgb8> taken(const Light& light, Random& random, RimSet set) {
  const double noise = std::exp(between(random, std::log(0.001), std::log(0.03)));
  const double gamma = std::array{1.0, 1.8, 2.2, 2.2, 2.2}[static_cast<std::size_t>(random.uniform() * 5)];
  const double blur = between(random, 0.3, 1.6);
  cv::Mat3d linear(light.height(), light.width());
  for (int y = 0; y < linear.rows; ++y)
    for (int x = 0; x < linear.cols; ++x) {
      const glm::dvec3 v = glm::min(light.at(x, y), glm::dvec3{8.0});
      linear(y, x) = {v.b, v.g, v.r};
    }
  cv::GaussianBlur(linear, linear, {}, blur);
  cv::Mat3b bgr(linear.rows, linear.cols);
  for (int y = 0; y < linear.rows; ++y)
    for (int x = 0; x < linear.cols; ++x)
      for (int c = 0; c < 3; ++c) {
        const double v = linear(y, x)[c];
        const double noisy = v + noise * random.normal() * std::sqrt(std::clamp(v, 0.0, 1.0) + 0.02);
        bgr(y, x)[c] =
            static_cast<std::uint8_t>(std::lround(255.0 * std::pow(std::clamp(noisy, 0.0, 1.0), 1.0 / gamma)));
      }
  if (once_in(random, 4.0)) return rgb_of(bgr);
  return rgb_of(through_jpeg(bgr, static_cast<int>(between(random, set == RimSet::held_out ? 50.0 : 60.0, 95.0))));
}

void stamp(Image<Rgb8>& pixels, Random& random) {  // time and place, or a maker's name
  cv::Mat3b text(pixels.height(), pixels.width(), cv::Vec3b{0, 0, 0});
  const double size = pixels.width() / 900.0;
  const int margin = static_cast<int>(0.02 * pixels.width());
  const bool below = once_in(random, 2.0), right = once_in(random, 2.0);
  const cv::Point at{right ? pixels.width() * 6 / 10 : margin,
                     below ? pixels.height() - margin : margin + static_cast<int>(25 * size)};
  cv::putText(text, "2024-05-17 10:32:07", at, cv::FONT_HERSHEY_SIMPLEX, size, {255, 255, 255},
              std::max(1, static_cast<int>(2 * size)));
  const auto level = static_cast<std::uint8_t>(between(random, 120.0, 255.0));
  for (int y = 0; y < text.rows; ++y)
    for (int x = 0; x < text.cols; ++x)
      if (text(y, x)[0] > 128) pixels.at(x, y) = {level, level, level};
}

struct Glow {
  glm::dvec2 place;
  double radius_px, level;
  glm::dvec3 colour;
};

}  // namespace

RimPicture draw_rim(RimSet set, std::uint64_t seed) {
  Random random(seed_of(set, seed));
  const bool held_out = set == RimSet::held_out;
  RimPicture picture;

  // The frame and the circle in it.
  const double size = between(random, 240.0, held_out ? 900.0 : 800.0);
  const double aspect =
      std::array{1.0, 1.0, 4.0 / 3.0, 3.0 / 2.0, 16.0 / 9.0}[static_cast<std::size_t>(random.uniform() * 5)];
  const int width = static_cast<int>(size * std::sqrt(aspect)), height = static_cast<int>(size / std::sqrt(aspect));
  const glm::dvec2 middle{0.5 * (width - 1), 0.5 * (height - 1)};
  const double shorter = std::min(width, height), longer = std::max(width, height);
  glm::dvec2 centre = middle + 0.02 * shorter * glm::dvec2{random.normal(), random.normal()};
  double radius = between(random, 0.36, 0.49) * shorter;
  const int cut = static_cast<int>(random.uniform() * 4.0);
  if (cut == 1) {  // one side
    const bool across = once_in(random, 2.0);
    (across ? centre.x : centre.y) += (once_in(random, 2.0) ? -1.0 : 1.0) * between(random, 0.05, 0.3) * shorter;
  } else if (cut == 2) {  // above and below
    radius = between(random, 0.51, std::max(0.52, 0.48 * std::min(longer / shorter, 1.5))) * shorter;
  } else if (cut == 3) {  // all four: only corners are dark
    radius = 0.5 * std::sqrt(shorter * shorter + longer * longer) * between(random, 0.8, 0.93);
  }
  const double squeeze = once_in(random, 4.0) ? between(random, 0.994, 1.006) : 1.0;  // pixels not quite square

  // What is seen.
  const double level = std::exp(between(random, std::log(held_out ? 0.02 : 0.03), std::log(1.5)));
  const double vignetting = between(random, 0.0, 0.85), steep = between(random, 2.0, 10.0);
  const double softness = radius * between(random, 0.001, 0.012);
  const double surround = once_in(random, 2.0) ? 0.0 : std::exp(between(random, std::log(0.0005), std::log(0.02)));
  const bool lit_surround = once_in(random, 8.0);  // not black at all, but even
  const double veil = lit_surround ? between(random, 0.02, 0.08) : 0.0;
  const glm::dvec3 veil_colour{between(random, 0.5, 1.0), between(random, 0.5, 1.0), between(random, 0.5, 1.0)};
  const double fringe = once_in(random, 3.0) ? between(random, 0.05, 0.5) : 0.0;
  const double trees_deg = between(random, -5.0, 20.0), rough_deg = between(random, 0.0, 12.0);
  const double tree_light = std::exp(between(random, std::log(0.005), std::log(0.2)));
  const double dark_from = between(random, 0.0, 6.28),
               dark_over = once_in(random, 3.0) ? between(random, 0.5, 3.0) : 0.0;
  const double dark_deep = between(random, 10.0, 60.0);
  const double sun_distance = between(random, 0.0, 0.95), sun_azimuth = between(random, 0.0, 6.28);
  const bool sun = !once_in(random, 3.0);
  const glm::dvec2 sun_at = centre + radius * sun_distance * glm::dvec2{std::cos(sun_azimuth), std::sin(sun_azimuth)};
  const double sun_glow = sun ? std::exp(between(random, std::log(0.02), std::log(0.6))) : 0.0;
  const double clouds = between(random, 0.0, 0.8);
  std::vector<Glow> glows;  // flare, also outside the circle
  if (once_in(random, 2.5))
    for (int i = 0; i < 4; ++i)
      glows.push_back({glm::dvec2{between(random, 0.0, width), between(random, 0.0, height)},
                       radius * between(random, 0.02, 0.2),
                       std::exp(between(random, std::log(0.005), std::log(0.5))),
                       {between(random, 0.2, 1.0), between(random, 0.2, 1.0), between(random, 0.2, 1.0)}});
  const std::uint64_t texture = seed * 13 + (held_out ? 77777 : 0);

  Light light(width, height, glm::dvec3(0.0));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      glm::dvec2 offset = glm::dvec2{x, y} - centre;
      offset.x *= squeeze;
      const double r = glm::length(offset), rho = r / radius, azimuth = std::atan2(offset.y, offset.x);
      glm::dvec3 rgb = (surround + veil) * veil_colour;
      const auto inside = [&](double at) { return 0.5 * std::erfc((r - at) / (softness * 1.4142)); };
      if (r < radius + 5.0 * softness + 2.0) {
        glm::dvec3 sky = level * glm::mix(glm::dvec3{0.45, 0.65, 1.0}, glm::dvec3{0.8, 0.85, 0.9}, rho * rho);
        const double cloud =
            std::clamp(2.5 * (fractal_noise(texture, 3.0 * offset / radius, 5) + clouds - 0.4), 0.0, 1.0);
        sky = glm::mix(sky, level * glm::dvec3{1.0}, cloud);
        const double above_deg = 90.0 * (1.0 - rho);
        const glm::dvec2 round{2.0 * std::cos(azimuth), 2.0 * std::sin(azimuth)};
        double top_deg = trees_deg + rough_deg * fractal_noise(texture + 1, 4.0 * round, 5, 0.6);
        if (dark_over > 0.0 && std::abs(std::remainder(azimuth - dark_from, 2.0 * kPi)) < 0.5 * dark_over)
          top_deg = std::max(top_deg, dark_deep);
        if (above_deg < top_deg)
          sky = tree_light * level * glm::dvec3{0.8, 1.0, 0.6} *
                (1.0 + 0.6 * fractal_noise(texture + 2, 30.0 * offset / radius, 3));
        sky *= 1.0 - vignetting * std::pow(std::min(rho, 1.0), steep);
        const glm::dvec3 edge{inside(radius * (1.0 - 0.002 * (fringe > 0.0))),
                              inside(radius * (1.0 - 0.004 * (fringe > 0.0))), inside(radius)};
        rgb += sky * edge;
        if (fringe > 0.0)
          rgb += fringe * level * glm::dvec3{0.5, 0.05, 1.0} *
                 std::exp(-std::pow((r - radius) / (0.006 * radius), 2.0)) * inside(radius);
      }
      if (sun) {
        const double d = glm::distance(glm::dvec2{x, y}, sun_at) / radius;
        rgb += (r < radius ? 1.0 : 0.15) * sun_glow * level / (1.0 + std::pow(d / 0.08, 2.0)) *
               glm::dvec3{1.0, 0.95, 0.85};
      }
      for (const Glow& glow : glows) {
        const double d = glm::distance(glm::dvec2{x, y}, glow.place) / glow.radius_px;
        rgb += glow.level * level * glow.colour / (1.0 + std::pow(d, 6.0));
      }
      light.at(x, y) = rgb;
    }
  picture.pixels = taken(light, random, set);
  const bool stamped = once_in(random, 4.0);
  if (stamped) stamp(picture.pixels, random);
  picture.circle = ImageCircle{centre, 0.5 * radius * (1.0 + 1.0 / squeeze)};
  int shown = 0;
  for (int i = 0; i < 720; ++i) {
    const double turn = 2.0 * kPi * i / 720;
    const glm::dvec2 at = centre + radius * glm::dvec2{std::cos(turn), std::sin(turn)};
    shown += at.x > 1.0 && at.y > 1.0 && at.x < width - 2.0 && at.y < height - 2.0;
  }
  picture.shown = shown / 720.0;
  picture.remark = fmt::format(
      "{}x{} cut {} level {:.2f} vign {:.2f} surround {:.4f} trees {:.0f}/{:.3f} dark {:.1f} glow {:.2f}{}{}{}", width,
      height, cut, level, vignetting, surround + veil, trees_deg, tree_light, dark_over, sun_glow,
      glows.empty() ? "" : " flare", stamped ? " stamp" : "", squeeze != 1.0 ? " squeezed" : "");
  return picture;
}

RimPicture draw_without_rim(RimSet set, std::uint64_t seed) {
  Random random(seed_of(set, seed + 50000));
  const bool held_out = set == RimSet::held_out;
  RimPicture picture;
  const int width = static_cast<int>(between(random, 240.0, 800.0)),
            height = static_cast<int>(width * between(random, 0.6, 1.0));
  const int kind = static_cast<int>(random.uniform() * 7.0);
  const double level = std::exp(between(random, std::log(0.05), std::log(1.2)));
  const std::uint64_t texture = seed * 17 + (held_out ? 99999 : 0);
  const glm::dvec2 middle{0.5 * width, 0.5 * height};
  const double a = between(random, 0.1, 0.4), b = between(random, 0.1, 0.4), c = between(random, 0.3, 0.7),
               d = between(random, 0.0, 6.28);
  const double fall = between(random, 0.3, 1.0), power = between(random, 2.0, 4.0);
  Light light(width, height, glm::dvec3(0.0));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const glm::dvec2 at = glm::dvec2{x, y} / static_cast<double>(width),
                       from = (glm::dvec2{x, y} - middle) / glm::length(middle);
      const double relief = fractal_noise(texture, 5.0 * at, 6);
      glm::dvec3 rgb{0.0};
      switch (kind) {
        case 0:  // a landscape with dark ground
          rgb = glm::dvec2{x, y}.y / height < c + 0.1 * fractal_noise(texture, {3.0 * at.x, 0.0}, 5)
                    ? level * glm::dvec3{0.6, 0.75, 1.0}
                    : 0.05 * level * glm::dvec3{1.0} * (1.0 + relief);
          break;
        case 1:  // darker towards its corners, never black
          rgb = level * glm::dvec3{0.8, 0.9, 1.0} * (1.0 + 0.4 * relief) *
                (1.0 - 0.9 * fall * std::pow(glm::length(from), power));
          break;
        case 2:  // a window
          rgb = at.x > a && at.x < 1.0 - b && at.y > a * 0.7 && at.y < height / static_cast<double>(width) - b * 0.7
                    ? level * glm::dvec3{1.0, 0.95, 0.9} * (1.0 + 0.3 * relief)
                    : glm::dvec3{0.005};
          break;
        case 3:  // a lamp at night: bright, without an edge
          rgb = level * glm::dvec3{1.0, 0.9, 0.7} * std::exp(-std::pow(glm::length(at - glm::dvec2{c, 0.3}) / a, 2.0));
          break;
        case 4:  // trees all around a patch of sky
          rgb = fractal_noise(texture, 3.0 * at, 6, 0.65) > 0.1 * std::cos(d) ? level * glm::dvec3{0.7, 0.8, 1.0}
                                                                              : 0.02 * level * glm::dvec3{1.0};
          break;
        case 5:  // dark slanting bars
          rgb = std::sin(20.0 * a * (std::cos(d) * at.x + std::sin(d) * at.y) * 6.0) > 0.0 ? level * glm::dvec3{1.0}
                                                                                           : glm::dvec3{0.01};
          break;
        default:  // hardly anything
          rgb = glm::dvec3{0.002} + 0.002 * relief;
          break;
      }
      light.at(x, y) = glm::max(rgb, glm::dvec3{0.0});
    }
  picture.pixels = taken(light, random, set);
  if (once_in(random, 3.0)) stamp(picture.pixels, random);
  picture.remark = fmt::format("kind {}", kind);
  return picture;
}

}  // namespace kasumi::test

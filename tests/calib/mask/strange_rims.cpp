#include "tests/calib/mask/strange_rims.hpp"

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

// Draws of one picture, in the order in which they are asked for.
struct Dice {
  Random random;
  double between(double low, double high) { return low + (high - low) * random.uniform(); }
  double log_between(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
  bool chance(double share) { return random.uniform() < share; }
  double turn() { return between(-kPi, kPi); }
  template <std::size_t n>
  double one_of(const std::array<double, n>& values) {
    return values[static_cast<std::size_t>(random.uniform() * static_cast<double>(n))];
  }
  glm::dvec3 colour(double low) { return {between(low, 1.0), between(low, 1.0), between(low, 1.0)}; }
};

struct Frame {
  int width = 0, height = 0;
  glm::dvec2 centre{};
  double radius = 0.0;
  int cut = 0;  // sides
};

Frame frame_of(Dice& dice) {
  Frame frame;
  const double size = dice.between(220.0, 640.0),
               aspect = dice.one_of(std::array{1.0, 1.0, 4.0 / 3.0, 1.5, 16.0 / 9.0});
  frame.width = static_cast<int>(size * std::sqrt(aspect));
  frame.height = static_cast<int>(size / std::sqrt(aspect));
  const double shorter = std::min(frame.width, frame.height), longer = std::max(frame.width, frame.height);
  frame.centre = 0.5 * glm::dvec2{frame.width - 1, frame.height - 1} +
                 0.02 * shorter * glm::dvec2{dice.random.normal(), dice.random.normal()};
  const double kind = dice.random.uniform();
  frame.radius = dice.between(0.40, 0.49) * shorter;
  if (kind < 0.1) {
    frame.radius = dice.between(0.2, 0.4) * shorter;  // a small circle
  } else if (kind < 0.25) {
    frame.radius = 0.5 * shorter;  // a tight crop
    frame.centre = 0.5 * glm::dvec2{frame.width - 1, frame.height - 1};
  } else if (kind < 0.4) {
    frame.cut = 1;
    (dice.chance(0.5) ? frame.centre.x : frame.centre.y) +=
        (dice.chance(0.5) ? -1.0 : 1.0) * dice.between(0.03, 0.25) * shorter;
  } else if (kind < 0.6) {
    frame.cut = 2;
    frame.radius = dice.between(0.51, std::max(0.53, 0.49 * std::min(longer / shorter, 1.6))) * shorter;
  } else if (kind < 0.7) {
    frame.cut = 4;
    frame.radius = 0.5 * std::hypot(shorter, longer) * dice.between(0.78, 0.92);
  }
  return frame;
}

// What lies outside of the circle beside an even surround.
struct Ring {
  double radius, wide, level, from, over;
  glm::dvec3 colour;
};

void write_text(cv::Mat3f& light, Dice& dice, double level) {
  const double size = light.cols / dice.between(600.0, 1500.0);
  const int thick = std::max(1, static_cast<int>(2 * size));
  const cv::Scalar colour(level * dice.between(0.3, 1.0), level * dice.between(0.5, 1.0), level);
  const int lines = 1 + static_cast<int>(dice.random.uniform() * 4);
  const int x = dice.chance(0.6) ? 6 : light.cols * 6 / 10;
  int y =
      dice.chance(0.5) ? static_cast<int>(28 * size) + 4 : light.rows - 6 - static_cast<int>(28 * size) * (lines - 1);
  for (int i = 0; i < lines; ++i, y += static_cast<int>(28 * size) + 1)
    cv::putText(light, i == 0 ? "2024-05-17 10:32:07 UTC" : "Exposure 1/2000 s  gain 0", {x, y},
                cv::FONT_HERSHEY_SIMPLEX, size, colour, thick);
}

void draw_logo(cv::Mat3f& light, Dice& dice, double level) {
  const int side = static_cast<int>(dice.between(0.06, 0.16) * std::min(light.cols, light.rows));
  const cv::Point at(dice.chance(0.5) ? 3 : light.cols - 4 - side, dice.chance(0.5) ? 3 : light.rows - 4 - side);
  cv::rectangle(light, cv::Rect(at.x, at.y, side, side / 2), cv::Scalar::all(level), cv::FILLED);
  cv::circle(light, {at.x + side / 2, at.y + side / 2}, side / 3, cv::Scalar(level * 0.2, level * 0.4, level * 0.8),
             cv::FILLED, cv::LINE_AA);
}

Image<Rgb8> taken(cv::Mat3f light, Dice& dice, double noise, bool grey, double squeeze) {
  if (squeeze != 1.0) cv::resize(light, light, {}, 1.0 / squeeze, 1.0, cv::INTER_AREA);
  cv::GaussianBlur(light, light, {}, dice.between(0.4, 1.4));
  const double gamma = dice.one_of(std::array{1.0, 1.8, 2.2, 2.2, 2.4});
  cv::Mat3b bgr(light.rows, light.cols);
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x)
      for (int c = 0; c < 3; ++c) {
        const auto v = static_cast<double>(light(y, x)[2 - c]);
        const double noisy = v + noise * dice.random.normal() * std::sqrt(std::clamp(v, 0.0, 1.0) + 0.01);
        bgr(y, x)[c] =
            static_cast<std::uint8_t>(std::lround(255.0 * std::pow(std::clamp(noisy, 0.0, 1.0), 1.0 / gamma)));
      }
  if (grey) {
    cv::Mat1b one;
    cv::cvtColor(bgr, one, cv::COLOR_BGR2GRAY);
    cv::cvtColor(one, bgr, cv::COLOR_GRAY2BGR);
  }
  return rgb_of(through_jpeg(bgr, static_cast<int>(dice.between(45.0, 97.0))));
}

}  // namespace

StrangeRim draw_strange_rim(RimSet set, std::uint64_t seed) {
  Dice dice{Random(fixtures::mix(seed + (set == RimSet::held_out ? 9100000u : 9000000u)))};
  StrangeRim strange;
  const Frame frame = frame_of(dice);
  const double radius = frame.radius,
               level = dice.chance(0.15) ? dice.log_between(0.01, 0.06) : dice.log_between(0.06, 2.5);
  const double dark = dice.chance(0.4) ? 0.0 : dice.log_between(0.0003, 0.02);
  const int kind = static_cast<int>(dice.one_of(std::array{0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0}));
  glm::dvec3 surround(dark);
  if (kind == 1) surround = glm::dvec3(dice.between(0.9, 1.0));       // white
  if (kind == 2) surround = glm::dvec3(dice.log_between(0.03, 0.6));  // grey
  if (kind == 3) surround = dice.log_between(0.05, 0.8) * dice.colour(0.05);
  const double softness = radius * dice.log_between(0.001, dice.chance(0.2) ? 0.03 : 0.008);
  const double vignetting = dice.chance(0.3) ? dice.between(0.5, 0.9) : dice.between(0.0, 0.5),
               steep = dice.between(2.0, 8.0);
  // A ring of land between horizon and edge, not quite concentric.
  const bool land_ring = dice.chance(0.25);
  const double horizon_radius = radius * dice.between(0.86, 0.965), land = dice.log_between(0.02, 0.3);
  const double tilt = dice.turn();
  const glm::dvec2 horizon =
      frame.centre + 0.3 * (radius - horizon_radius) * glm::dvec2{std::cos(tilt), std::sin(tilt)};
  const double trees_deg = dice.chance(0.5) ? -5.0 : dice.between(-5.0, 18.0), rough_deg = dice.between(0.0, 12.0);
  const double tree_light = dice.log_between(0.01, 0.3);
  const double wall_at = dice.turn(), wall_over = dice.chance(0.3) ? dice.between(0.3, 1.4) : 0.0;
  const double wall_deg = dice.between(10.0, 55.0), wall_light = dice.log_between(0.05, 0.9);
  const double band_at = dice.turn(), band_over = dice.chance(0.07) ? dice.between(0.1, 0.25) : 0.0;
  const bool sun = dice.chance(0.65);
  const double sun_turn = dice.turn(), sun_far = dice.between(0.0, 1.0), glow = dice.log_between(0.02, 1.5);
  const glm::dvec2 sun_at = frame.centre + radius * sun_far * glm::dvec2{std::cos(sun_turn), std::sin(sun_turn)};
  const double clouds = dice.between(-0.3, 1.0);
  std::vector<Ring> rings;
  if (dice.chance(0.3)) {  // a faint ring or its arc, of light that is scattered in the lens
    const double over = dice.chance(0.5) ? 2.0 * kPi : dice.between(0.3, 3.0);
    rings.push_back({radius * dice.between(1.04, 1.6), radius * dice.log_between(0.003, 0.05),
                     level * dice.log_between(0.002, 0.06), dice.turn(), over, dice.colour(0.1)});
  }
  const double mirrored = dice.chance(0.12) ? dice.log_between(0.01, 0.15) : 0.0;  // the barrel's inside
  const double veil = dice.chance(0.3) ? level * dice.log_between(0.001, 0.02) : 0.0,
               veil_wide = dice.between(0.03, 0.4);
  const std::uint64_t texture = seed * 31 + (set == RimSet::held_out ? 5 : 0);

  const auto sky_at = [&](const glm::dvec2& offset) {
    const double rho = glm::length(offset) / radius, azimuth = std::atan2(offset.y, offset.x);
    glm::dvec3 sky = level * glm::mix(glm::dvec3{0.35, 0.55, 1.0}, glm::dvec3{0.75, 0.85, 1.0}, rho * rho);
    const double cloud = std::clamp(2.5 * (fractal_noise(texture, 3.0 * offset / radius, 4) + clouds - 0.4), 0.0, 1.0);
    sky = glm::mix(sky, level * glm::dvec3{1.0, 0.98, 0.95}, cloud);
    if (sun) sky += level * glow / (1.0 + std::pow(glm::distance(offset + frame.centre, sun_at) / radius / 0.1, 2.0));
    const double above_deg = 90.0 * (1.0 - rho);
    const double top_deg =
        trees_deg +
        rough_deg * fractal_noise(texture + 1, 2.0 * glm::dvec2{std::cos(azimuth), std::sin(azimuth)} * 2.0, 4, 0.6);
    const glm::dvec2 away = offset + frame.centre - horizon;
    if (above_deg < top_deg || (land_ring && glm::length(away) > horizon_radius))
      sky = (land_ring ? land : tree_light) * level * glm::dvec3{0.8, 1.0, 0.6} *
            (1.0 + 0.6 * fractal_noise(texture + 2, 30.0 * offset / radius, 3));
    const double along = std::remainder(azimuth - wall_at, 2.0 * kPi);
    if (std::abs(along) < 0.5 * wall_over && above_deg < wall_deg * std::cos(along))
      sky = wall_light * level * glm::dvec3{1.0, 0.95, 0.85} *
            (std::sin(60.0 * along) * std::sin(90.0 * rho) > 0.3 ? 0.4 : 1.0);
    if (std::abs(std::remainder(azimuth - band_at, 2.0 * kPi)) * rho < band_over) sky *= 0.02;
    return sky * (1.0 - vignetting * std::pow(std::min(rho, 1.0), steep));
  };
  cv::Mat3f light(frame.height, frame.width);
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      const glm::dvec2 offset = glm::dvec2{x, y} - frame.centre;
      const double r = glm::length(offset), rho = r / radius, azimuth = std::atan2(offset.y, offset.x);
      const double inside = 0.5 * std::erfc((r - radius) / (softness * 1.4142));
      glm::dvec3 outside = surround;
      if (kind == 0) {
        if (veil > 0.0 && rho > 1.0) outside += veil * std::exp(-(rho - 1.0) / veil_wide);
        if (mirrored > 0.0 && rho > 1.0 && rho < 1.12)
          outside += mirrored * (1.12 - rho) / 0.12 * sky_at(offset * (2.0 / rho - 1.0));
        for (const Ring& ring : rings)
          if (std::abs(std::remainder(azimuth - ring.from, 2.0 * kPi)) < 0.5 * ring.over)
            outside += ring.level * ring.colour * std::exp(-std::pow((r - ring.radius) / ring.wide, 2.0));
      }
      const glm::dvec3 rgb = inside > 1e-4 ? glm::mix(outside, sky_at(offset) + dark, inside) : outside;
      light(y, x) = {static_cast<float>(rgb.r), static_cast<float>(rgb.g), static_cast<float>(rgb.b)};
    }
  const bool grey = dice.chance(0.1), text = dice.chance(0.3), logo = dice.chance(0.15);
  const double ink = kind == 0 ? dice.between(0.3, 1.0) : dice.between(0.0, 1.0);
  if (text) write_text(light, dice, ink);
  if (logo) draw_logo(light, dice, ink);
  if (!grey && dice.chance(0.05))  // a channel gone
    for (auto& pixel : light) pixel[static_cast<int>(seed % 3)] = 0.0f;
  const double squeeze = dice.chance(0.12) ? dice.one_of(std::array{0.9, 0.9375, 1.0667, 1.0935}) : 1.0;
  const double noise = dice.log_between(0.001, 0.03);
  strange.picture.pixels = taken(light, dice, noise, grey, squeeze);
  strange.pixel_aspect = squeeze;
  strange.picture.circle = ImageCircle{frame.centre, radius, 0.0};
  if (land_ring)
    strange.horizon = ImageCircle{horizon, horizon_radius, 0.0};
  else if (trees_deg > 1.0 && rough_deg < 3.0)  // an even skyline is a circle too
    strange.horizon = ImageCircle{frame.centre, radius * (1.0 - trees_deg / 90.0), 0.0};
  int shown = 0;
  for (int i = 0; i < 720; ++i) {
    const glm::dvec2 at = frame.centre + radius * glm::dvec2{std::cos(i * kPi / 360), std::sin(i * kPi / 360)};
    shown += at.x > 1.0 && at.y > 1.0 && at.x < frame.width - 2.0 && at.y < frame.height - 2.0;
  }
  strange.picture.shown = shown / 720.0;
  strange.picture.remark = fmt::format(
      "kind {} cut {} level {:.2f} vign {:.2f} soft {:.3f}{}{}{}{}{}{}", kind, frame.cut, level, vignetting,
      softness / radius, land_ring ? " land" : "", rings.empty() ? "" : " ring", mirrored > 0.0 ? " mirror" : "",
      text ? " text" : "", wall_over > 0.0 ? " wall" : "", squeeze != 1.0 ? " squeezed" : "");
  return strange;
}

}  // namespace kasumi::test

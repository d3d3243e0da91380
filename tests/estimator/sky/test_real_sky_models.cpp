// Which model's sky is closer to a real one: prints the table of docs/sky.md ("Two turbidities"). Not a test of the
// code, so it only runs on request: --gtest_also_run_disabled_tests.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/dome.hpp"
#include "estimator/sky/preetham.hpp"
#include "fixtures/atmosphere/reference_sky.hpp"
#include "tests/alpnach.hpp"
#include "tests/places.hpp"

namespace kasumi::test {
namespace {

constexpr int kSide = 300;
constexpr double kAltitude_m = 470.0;
const glm::dvec2 kCentre{149.6, 140.7}, kSun{83.3, 80.9};
// Of the exposures 6 to 11: median ratios between neighbours where both are well exposed.
constexpr int kFirst = 6;
constexpr std::array kExposures{.0754, .1539, .3933, 1.0, 4.0965, 8.9625};

struct Pixel {
  Direction view;
  double radius2 = 0.0;      // of the picture, over the image circle's, squared
  double solid_angle = 0.0;  // in any unit
  double from_sun_deg = 0.0;
  std::array<double, 4> light{};  // linear R, G, B; Y
};
const std::array<const char*, 4> kNames{"R", "G", "B", "Y"};

std::array<double, 4> channels_of(const glm::dvec3& xyz) {
  const glm::dvec3 rgb = xyz_to_linear_srgb() * xyz;
  return {rgb.r, rgb.g, rgb.b, xyz.y};
}

using Lens = std::function<double(double radius_px)>;  // distance from the axis [rad]
Direction view_of_pixel(const Lens& lens, const glm::dvec2& pixel) {
  const glm::dvec2 d = pixel - kCentre;
  const double r = std::max(1e-9, glm::length(d)), theta = lens(r);
  return {std::sin(theta) * d.x / r, -std::sin(theta) * d.y / r, std::cos(theta)};
}

std::vector<Pixel> merged(const Lens& lens) {
  std::vector<cv::Mat> exposures;
  for (std::size_t i = 0; i < kExposures.size(); ++i)
    exposures.push_back(cv::imread(alpnach::file(static_cast<int>(kFirst + i)).string()));
  const Direction sun = view_of_pixel(lens, kSun);
  std::vector<Pixel> pixels;
  for (int y = 5; y < kSide - 10; y += 2)
    for (int x = 5; x < kSide - 10; x += 2) {
      const Direction view = view_of_pixel(lens, {x, y});
      const double from_sun = to_degrees(angle_between(view, sun));
      if (to_degrees(zenith_angle(view)) > 70.0 || from_sun < 10.0) continue;
      glm::dvec3 sum{0.0};
      double exposure = 0.0;
      for (std::size_t i = 0; i < exposures.size(); ++i) {
        const auto bgr = exposures[i].at<cv::Vec3b>(y, x);
        if (std::max({bgr[0], bgr[1], bgr[2]}) > 240 || std::min({bgr[0], bgr[1], bgr[2]}) < 6) continue;
        sum += glm::dvec3(bgr[2], bgr[1], bgr[0]);
        exposure += kExposures[i];
      }
      if (exposure == 0.0) continue;
      const glm::dvec3 rgb = sum / exposure, across = view_of_pixel(lens, {x + 1, y}) - view,
                       down = view_of_pixel(lens, {x, y + 1}) - view;
      pixels.push_back({view, glm::dot(glm::dvec2(x, y) - kCentre, glm::dvec2(x, y) - kCentre) / (133.0 * 133.0),
                        glm::length(glm::cross(across, down)), from_sun,
                        channels_of(glm::inverse(xyz_to_linear_srgb()) * rgb)});
    }
  return pixels;
}

struct Part {
  std::size_t channel = 3;
  double nearest_deg = 10.0, farthest_deg = 180.0;  // from the sun
  bool vignetting = false;                          // 1 + a radius^2
};
struct Fit {
  double turbidity = 0.0, residual = 1e9, a = 0.0;
};

// Least squares of measured = k (1 + a radius^2) model in relative terms, repeated without outliers.
Fit fit(const std::vector<Pixel>& pixels, const std::vector<double>& model, const Part& part) {
  std::vector<bool> used(pixels.size(), true);
  Fit found;
  for (int round = 0; round < 8; ++round) {
    double s00 = 0, s01 = 0, s11 = 0, t0 = 0, t1 = 0;
    const auto inside = [&](std::size_t i) {
      return pixels[i].from_sun_deg >= part.nearest_deg && pixels[i].from_sun_deg < part.farthest_deg;
    };
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (!inside(i) || !used[i]) continue;
      const double w = pixels[i].solid_angle, f = model[i] / pixels[i].light[part.channel], g = f * pixels[i].radius2;
      s00 += w * f * f, s01 += w * f * g, s11 += w * g * g, t0 += w * f, t1 += w * g;
    }
    double k = t0 / s00, ka = 0.0;
    if (part.vignetting) {
      const double determinant = s00 * s11 - s01 * s01;
      k = (t0 * s11 - t1 * s01) / determinant;
      ka = (t1 * s00 - t0 * s01) / determinant;
    }
    std::vector<double> errors;
    double squares = 0.0, weight = 0.0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (!inside(i)) continue;
      const double predicted = (k + ka * pixels[i].radius2) * model[i] / pixels[i].light[part.channel];
      errors.push_back(std::abs(std::log(std::max(1e-6, predicted))));
      squares += pixels[i].solid_angle * std::pow(std::min(errors.back(), 0.5), 2);
      weight += pixels[i].solid_angle;
    }
    auto sorted = errors;
    std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2));
    const double limit = 4.0 * 1.4826 * sorted[sorted.size() / 2];
    for (std::size_t i = 0, j = 0; i < pixels.size(); ++i)
      if (inside(i)) used[i] = errors[j++] < limit;
    found.residual = std::sqrt(squares / weight);
    found.a = ka / k;
  }
  return found;
}

TEST(RealSky, DISABLED_WhoseSkyIsNearer) {
  if (!alpnach::is_there()) GTEST_SKIP() << "no shared data: " << alpnach::file(0);
  const double sun_px = glm::length(kSun - kCentre);
  const auto equidistant = [&](double sun_deg) -> Lens {
    return [f = sun_px / from_degrees(sun_deg).value](double r) { return r / f; };
  };
  const auto stereographic = [&](double sun_deg) -> Lens {
    return [f = sun_px / (2.0 * std::tan(0.5 * from_degrees(sun_deg).value))](double r) {
      return 2.0 * std::atan(r / (2.0 * f));
    };
  };
  std::vector<std::pair<double, reference::ReferenceSky>> atmospheres;
  for (const double t : {1.1, 1.2, 1.35, 1.5, 1.7, 2.3, 3.2, 4.6, 6.8})
    atmospheres.emplace_back(t, reference::ReferenceSky(reference::Air{.aerosol = aerosol_of(t)}, 40.0));

  for (const auto& [name, lens] : {std::pair{"equidistant", equidistant(62.1)},
                                   {"equidistant", equidistant(65.1)},
                                   {"stereographic", stereographic(67.7)}}) {
    const auto pixels = merged(lens);
    const Direction sun = view_of_pixel(lens, kSun);
    fmt::print("{}, sun at {:.1f} deg, {} pixels\n", name, to_degrees(zenith_angle(sun)), pixels.size());
    using Models = std::vector<std::pair<double, std::vector<std::array<double, 4>>>>;  // T, light of each pixel
    const auto over = [&](const auto& light_of) {
      std::vector<std::array<double, 4>> light;
      for (const Pixel& pixel : pixels) light.push_back(channels_of(light_of(pixel.view)));
      return light;
    };
    Models preetham, domes, spectral;
    for (double t = 1.7; t < 10.01; t *= std::pow(10.0 / 1.7, 1.0 / 30)) {
      const PreethamSky model(Turbidity{t}, sun);
      preetham.emplace_back(t, over([&](const Direction& view) { return model.relative_xyz(view); }));
      const DomeFunction sky = dome(kAltitude_m, Turbidity{t}, sun);
      domes.emplace_back(t, over([&](const Direction& view) { return dome_light(sky, view); }));
    }
    for (const auto& [t, sky] : atmospheres)
      spectral.emplace_back(t, over([&, &s = sky](const Direction& view) { return s.xyz({kAltitude_m, view, sun}); }));

    for (const Part& part :
         {Part{}, Part{3, 10, 40}, Part{3, 40, 180}, Part{0}, Part{1}, Part{2}, Part{3, 10, 180, true},
          Part{0, 10, 180, true}, Part{1, 10, 180, true}, Part{2, 10, 180, true}}) {
      fmt::print("  {} {:3.0f} to {:3.0f} deg{}:", kNames[part.channel], part.nearest_deg, part.farthest_deg,
                 part.vignetting ? ", vignetting" : "            ");
      for (const auto& [whose, models] :
           {std::pair{"Preetham's", &preetham}, {"dome's", &domes}, {"spectral", &spectral}}) {
        Fit best, hazy;
        for (const auto& [t, light] : *models) {
          std::vector<double> model;
          for (const auto& channels : light) model.push_back(channels[part.channel]);
          Fit here = fit(pixels, model, part);
          here.turbidity = t;
          if (here.residual < best.residual) best = here;
          if (t == 4.6) hazy = here;
        }
        fmt::print("  {} {:.2f}, {:.1f} % ({:+.2f})", whose, best.turbidity, 100 * best.residual, best.a);
        if (models == &spectral) fmt::print("; at 4.6 {:.1f} %", 100 * hazy.residual);
      }
      fmt::print("\n");
    }
  }
}

}  // namespace
}  // namespace kasumi::test

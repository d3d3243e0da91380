#include "tests/estimator/turbidity/sky_photographs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <opencv2/core.hpp>

#include "base/aerosol.hpp"
#include "base/units.hpp"
#include "calib/colour/colorimetry.hpp"
#include "fixtures/light/sensor.hpp"
#include "fixtures/spectrum/spectrum.hpp"
#include "fixtures/spectrum/sunlight.hpp"

namespace kasumi::test {
namespace {

constexpr std::array kZeniths_deg{0.0,  5.0,  10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0,
                                  64.0, 68.0, 72.0, 75.0, 78.0, 80.5, 83.0, 85.0, 86.5, 88.0, 89.0, 89.5};
constexpr int kAzimuths = 19;  // 0 .. 180 deg from the sun's

// Cubic through unevenly spaced nodes (Hermite's, slopes from the neighbours), as weights of four of them.
struct Taps {
  std::array<std::size_t, 4> node{};
  std::array<double, 4> weight{};
};
template <std::size_t N>
Taps taps_at(const std::array<double, N>& x, double at) {
  std::size_t i = 0;
  while (i + 2 < N && at > x[i + 1]) ++i;
  const double h = x[i + 1] - x[i], t = std::clamp((at - x[i]) / h, 0.0, 1.0), t2 = t * t, t3 = t2 * t;
  Taps taps;
  taps.node = {i > 0 ? i - 1 : i, i, i + 1, std::min(i + 2, N - 1)};
  const auto& n = taps.node;
  const double low = (t3 - 2 * t2 + t) * h / (x[n[2]] - x[n[0]]), high = (t3 - t2) * h / (x[n[3]] - x[n[1]]);
  taps.weight = {-low, 2 * t3 - 3 * t2 + 1 - high, 3 * t2 - 2 * t3 + low, high};
  return taps;
}

// ln of light over the scattering by air and aerosol along the way.
struct Table {
  std::array<std::array<std::array<double, kAzimuths>, kZeniths_deg.size()>, 3> log_ratio{};
  std::array<double, 3> molecules{}, aerosol{};  // scattering of the column, per channel
  std::array<reference::PhaseCurve, 3> aerosol_phase;
  double phase(std::size_t channel, double cos_gamma) const {
    return molecules[channel] * reference::rayleigh_phase(cos_gamma) +
           aerosol[channel] * aerosol_phase[channel].value(cos_gamma);
  }
};

// The lens spreads a little of the sun's light around it.
double lens_glare(double gamma) {
  constexpr double kShare = 0.02, kRadius = 0.012, kSlope = 3.0;
  const double r = gamma / kRadius;
  return kShare * (kSlope - 1.0) / (kPi * kRadius * kRadius) * std::pow(1.0 + r * r, -kSlope);
}

}  // namespace

CloudlessSky simulated_sky(const reference::ReferenceSky& air, double altitude_m, const Direction& sun) {
  const auto table = std::make_shared<Table>();
  const auto& optics = air.optics();
  for (std::size_t c = 0; c < 3; ++c) {  // near the channel's middle
    const double nm = std::array{600.0, 550.0, 450.0}[c];
    std::size_t w = 0;
    while (w + 1 < optics.size() && optics.wavelength_nm[w] < nm) ++w;
    table->molecules[c] = optics.extinction[reference::kMolecules][w] * 8434.5;
    table->aerosol[c] = optics.aerosol_scattering[w] * kAerosolHeight_m;
    table->aerosol_phase[c] = optics.aerosol_phase[w];
  }
  const double sun_zenith = zenith_angle(sun).value, sun_azimuth = azimuth_angle(sun).value;
  const glm::dvec3 sun_ahead = direction_from({sun_zenith}, {0.0});
  for (std::size_t z = 0; z < kZeniths_deg.size(); ++z)
    for (int a = 0; a < kAzimuths; ++a) {
      const Direction view = direction_from(from_degrees(kZeniths_deg[z]), from_degrees(10.0 * a));
      const glm::dvec3 rgb = xyz_to_linear_srgb() * air.xyz({altitude_m, view, sun_ahead});
      for (std::size_t c = 0; c < 3; ++c)
        table->log_ratio[c][z][static_cast<std::size_t>(a)] =
            std::log(std::max(rgb[static_cast<int>(c)], 1e-3 * rgb.y) / table->phase(c, glm::dot(view, sun_ahead)));
    }
  CloudlessSky sky;
  sky.sun = sun;
  sky.light = [table, sun, sun_azimuth](const Direction& view) {
    const double zenith = std::min(to_degrees(zenith_angle(view)), kZeniths_deg.back());
    const double azimuth =
        std::abs(std::remainder(to_degrees(azimuth_angle(view)) - to_degrees(Radians{sun_azimuth}), 360.0));
    const double cosine = std::clamp(glm::dot(view, sun), -1.0, 1.0);
    static const auto azimuths = [] {
      std::array<double, kAzimuths> nodes{};
      for (int a = 0; a < kAzimuths; ++a) nodes[static_cast<std::size_t>(a)] = 10.0 * a;
      return nodes;
    }();
    const Taps down = taps_at(kZeniths_deg, zenith), round = taps_at(azimuths, azimuth);
    glm::dvec3 light;
    for (std::size_t c = 0; c < 3; ++c) {
      double sum = 0.0;
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
          sum += down.weight[i] * round.weight[j] * table->log_ratio[c][down.node[i]][round.node[j]];
      light[static_cast<int>(c)] = std::exp(sum) * table->phase(c, cosine);
    }
    return light;
  };
  sky.sun_irradiance = xyz_to_linear_srgb() * air.xyz_of(air.sun_transmission(altitude_m, sun.z));
  return sky;
}

namespace {

struct Scan {
  std::vector<Direction> directions;
  std::vector<glm::dvec3> rgb;
};
Scan read_scan(const std::string& path) {
  Scan scan;
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  const auto& cie = fixtures::cie_1931();
  for (bool first = true; std::getline(file, line); first = false) {
    std::vector<double> values;
    std::stringstream text(line);
    for (std::string field; std::getline(text, field, ',');) values.push_back(std::stod(field));
    if (first) continue;  // often wrong
    const fixtures::Spectrum spectrum = fixtures::resample(std::span<const double>(values).subspan(2), 380.0, 10.0);
    glm::dvec3 xyz{0.0};
    for (std::size_t i = 0; i < spectrum.size(); ++i)
      xyz += fixtures::kLumensPerWatt * spectrum[i] * glm::dvec3(cie.x[i], cie.y[i], cie.z[i]);
    scan.directions.push_back(direction_from(from_degrees(90.0 - values[1]), from_degrees(values[0])));
    scan.rgb.push_back(xyz_to_linear_srgb() * xyz);
  }
  return scan;
}

constexpr double kLowest = 0.21;  // sine of the lowest measured elevation, 12 deg; the sky is held below

// What ln L is fitted with: no term has structure finer than clear air's.
std::array<double, 10> smooth_terms(const Direction& d, const Direction& sun) {
  const double gamma = angle_between(d, sun).value, cosine = std::cos(gamma);
  const double up = std::max(d.z, kLowest), low = 1.0 / (up + 0.15);
  return {
      1.0,         std::exp(-3.0 * gamma), std::exp(-9.0 * gamma), cosine, cosine * cosine, low, low * low, up, up * up,
      low * cosine};
}

class SmoothScan {
 public:
  SmoothScan(const Scan& scan, const Direction& sun) : sun_(sun), directions_(scan.directions) {
    const int n = static_cast<int>(scan.directions.size()), m = 10;
    cv::Mat1d a(n + m, m, 0.0), b(n + m, 3, 0.0), x;
    for (int i = 0; i < n; ++i) {
      const auto t = smooth_terms(scan.directions[static_cast<std::size_t>(i)], sun);
      for (int k = 0; k < m; ++k) a(i, k) = t[static_cast<std::size_t>(k)];
      for (int c = 0; c < 3; ++c) b(i, c) = std::log(scan.rgb[static_cast<std::size_t>(i)][c]);
    }
    for (int k = 1; k < m; ++k) a(n + k, k) = 0.03;
    cv::solve(a, b, x, cv::DECOMP_SVD);
    for (int k = 0; k < m; ++k)
      for (int c = 0; c < 3; ++c) terms_[static_cast<std::size_t>(k)][c] = x(k, c);
    for (int i = 0; i < n; ++i) {
      glm::dvec3 left;
      for (int c = 0; c < 3; ++c) left[c] = b(i, c);
      left_.push_back(left - smooth_at(scan.directions[static_cast<std::size_t>(i)]));
    }
  }
  glm::dvec3 at(const Direction& d) const {
    glm::dvec3 sum{0.0};
    double weights = 1.0;  // far from all directions nothing is added
    for (std::size_t i = 0; i < directions_.size(); ++i) {
      constexpr double kWidth = 0.26;
      const double apart = angle_between(d, directions_[i]).value / kWidth;
      const double weight = std::exp(-0.5 * apart * apart);
      sum += weight * left_[i];
      weights += weight;
    }
    return glm::exp(smooth_at(d) + sum / weights);
  }

 private:
  glm::dvec3 smooth_at(const Direction& d) const {
    const auto t = smooth_terms(d, sun_);
    glm::dvec3 sum{0.0};
    for (std::size_t k = 0; k < t.size(); ++k) sum += t[k] * terms_[k];
    return sum;
  }
  Direction sun_;
  std::vector<Direction> directions_;
  std::array<glm::dvec3, 10> terms_{};
  std::vector<glm::dvec3> left_;
};

}  // namespace

std::vector<CloudlessSky> measured_skies(const std::string& folder) {
  std::vector<CloudlessSky> skies;
  std::ifstream index(folder + "/index.csv");
  std::string line;
  std::getline(index, line);
  while (std::getline(index, line)) {
    std::stringstream text(line);
    std::vector<std::string> fields;
    for (std::string field; std::getline(text, field, ',');) fields.push_back(field);
    CloudlessSky sky;
    sky.name = fields.at(0);
    sky.sun = direction_from(from_degrees(std::stod(fields.at(2))), from_degrees(std::stod(fields.at(4))));
    const Scan scan = read_scan(folder + "/" + fields.at(0));
    const auto smooth = std::make_shared<SmoothScan>(scan, sky.sun);
    sky.light = [smooth](const Direction& d) { return smooth->at(d); };
    sky.sun_irradiance = glm::dvec3{70000.0};  // some clear day's
    skies.push_back(std::move(sky));
  }
  return skies;
}

namespace {

// A white diffuser on level ground, as radiance.
glm::dvec3 white_under(const CloudlessSky& sky) {
  glm::dvec3 falls = std::max(0.0, sky.sun.z) * sky.sun_irradiance;
  constexpr int kRings = 12, kSectors = 24;
  for (int i = 0; i < kRings; ++i)  // equal steps of cos^2 weigh equally on the ground
    for (int j = 0; j < kSectors; ++j)
      falls +=
          kPi / (kRings * kSectors) *
          sky.light(direction_from({std::acos(std::sqrt((i + 0.5) / kRings))}, {(j + 0.5) * 2.0 * kPi / kSectors}));
  return falls / kPi;
}

// As the generator lights its clouds, but without the air before them.
glm::dvec3 cloud_light(const fixtures::CloudSample& cloud, double gamma, const glm::dvec3& white) {
  const double silver_lining = 1.0 + 1.6 * std::exp(-gamma / 0.16) * (1.0 - cloud.thickness);
  return std::lerp(0.95, 0.42, cloud.thickness) * (1.0 + 0.28 * cloud.relief) * silver_lining * white;
}

}  // namespace

Image<Rgb8> photograph(const CloudlessSky& sky, const Camera& camera, const Shot& shot) {
  Image<glm::dvec3> light(camera.width, camera.height, glm::dvec3(0.0));
  const glm::dmat3 to_camera = glm::inverse(camera.light_to_xyz()) * glm::inverse(xyz_to_linear_srgb());
  const glm::dvec3 white = shot.clouds ? white_under(sky) : glm::dvec3{0.0};
  const double shine = !shot.sun_disc ? 0.0 : shot.clouds ? shot.clouds->sunlight_at({0.0, 0.0, 0.0}) : 1.0;
  const double disc_sr = kPi * std::pow(std::sin(fixtures::kSunRadius.value), 2);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const auto direction = camera.direction_at({x, y});
      if (!direction || direction->z <= 0.0) continue;
      glm::dvec3 rgb = sky.light(*direction);
      if (shot.clouds) {
        const fixtures::CloudSample cloud = shot.clouds->at(*direction, 0.006);
        rgb = glm::mix(rgb, cloud_light(cloud, angle_between(*direction, sky.sun).value, white), cloud.opacity);
      }
      if (shine > 0.0) {
        rgb += shine * lens_glare(angle_between(*direction, sky.sun).value) * sky.sun_irradiance;
        constexpr int kRays = 5;  // a side of the pixel
        int hits = 0;
        for (int j = 0; j < kRays * kRays; ++j) {
          const glm::dvec2 ray{(j % kRays + 0.5) / kRays - 0.5, (j / kRays + 0.5) / kRays - 0.5};
          const auto d = camera.direction_at(glm::dvec2{x, y} + ray);
          if (d && angle_between(*d, sky.sun) < fixtures::kSunRadius) ++hits;
        }
        rgb += shine * hits / (kRays * kRays * disc_sr) * sky.sun_irradiance;
      }
      light.at(x, y) = glm::max(to_camera * rgb, 1e-4 * glm::dvec3{rgb.y}) / fixtures::kLumensPerWatt;
    }
  fixtures::Exposure exposure = fixtures::automatic_exposure(light, 0.98, shot.brightest);
  exposure.noise = shot.noise;
  exposure.seed = shot.seed;
  return fixtures::expose(light, camera, exposure);
}

}  // namespace kasumi::test

#include "estimator/sky/dome.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "base/earth.hpp"
#include "base/sky/dome_terms.hpp"
#include "base/sky/sun_disc.hpp"
#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/dome_table.hpp"

namespace kasumi {
namespace {

// Lagrange's four points around a value of an axis.
struct FourPoints {
  std::size_t first = 0;
  std::array<double, 4> weight{1, 1, 1, 1};
};
template <class Along>
FourPoints four_points(std::span<const double> axis, double value, Along along) {
  std::size_t i = 0;
  while (i + 2 < axis.size() && value >= axis[i + 1]) ++i;
  FourPoints four;
  four.first = std::min(i > 0 ? i - 1 : 0, axis.size() - 4);
  const double x = along(value);
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t other = 0; other < 4; ++other)
      if (other != k)
        four.weight[k] *=
            (x - along(axis[four.first + other])) / (along(axis[four.first + k]) - along(axis[four.first + other]));
  return four;
}

// Two parabolas through three points each, the one before and the one after the value, blended: a slope without kinks,
// since estimates follow it.
template <class Along>
FourPoints two_parabolas(std::span<const double> axis, double value, Along along) {
  FourPoints four = four_points(axis, value, along);
  std::array<double, 4> x{};
  for (std::size_t k = 0; k < 4; ++k) x[k] = along(axis[four.first + k]);
  const double at = along(value), share = std::clamp((at - x[1]) / (x[2] - x[1]), 0.0, 1.0);
  four.weight.fill(0.0);
  for (std::size_t begin = 0; begin < 2; ++begin)
    for (std::size_t k = begin; k < begin + 3; ++k) {
      double weight = begin == 0 ? 1.0 - share : share;
      for (std::size_t other = begin; other < begin + 3; ++other)
        if (other != k) weight *= (at - x[other]) / (x[k] - x[other]);
      four.weight[k] += weight;
    }
  return four;
}

// Added to an optical depth before its logarithm is taken: with as much the haze's light equals the molecules', roughly.
constexpr double kMolecules_aod = 0.05;

struct Place {
  double altitude_m, sun_zenith_deg;
};
Place clamped(double altitude_m, const SunDirection& sun) {
  return {std::clamp(altitude_m, 0.0, kHighestDomeAltitude_m),
          std::clamp(to_degrees(zenith_angle(sun)), 0.0, to_degrees(kLowestDomeSun))};
}

// A row of the table, interpolated between its nodes.
struct Row {
  glm::dvec3 log_mean{0}, log_sun{0};
  std::array<glm::dvec3, kDomeTerms> chebyshev{};
};
// Of the kind at its natural exponent.
Row row_at(const Place& place, AerosolKind kind, double aod_550) {
  const DomeTable& table = dome_table();
  // Light decreases nearly as the air thins: its logarithm is closer to linear over this than over height.
  const FourPoints a =
      four_points(table.altitudes_m, place.altitude_m, [](double h) { return std::log1p(h / 4000.0); });
  const FourPoints t = two_parabolas(table.aods_550, std::clamp(aod_550, 0.0, table.aods_550.back()),
                                     [](double aod) { return std::log(aod + kMolecules_aod); });
  const FourPoints s = four_points(table.sun_zeniths_deg, place.sun_zenith_deg, [](double deg) { return deg; });
  const std::size_t altitudes = table.altitudes_m.size(), aods = table.aods_550.size(),
                    suns = table.sun_zeniths_deg.size(), of_kind = static_cast<std::size_t>(kind) * altitudes;
  Row row;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t k = 0; k < 4; ++k) {
        const double weight = a.weight[i] * t.weight[j] * s.weight[k];
        if (weight == 0.0) continue;
        const std::size_t node = ((of_kind + a.first + i) * aods + t.first + j) * suns + s.first + k;
        const std::int16_t* numbers = &table.rows[node * kDomeRow];
        for (int c = 0; c < 3; ++c, numbers += kDomeRowHead + kDomeTerms) {
          row.log_mean[c] += weight * numbers[0] / kDomeMeanSteps;
          row.log_sun[c] += weight * numbers[1] / kDomeLogSteps;
          const double unit = weight * std::exp(numbers[2] / kDomeLogSteps) / kDomeCoefficientSteps;
          for (int term = 0; term < kDomeTerms; ++term) row.chebyshev[term][c] += unit * numbers[kDomeRowHead + term];
        }
      }
  return row;
}

bool is_natural(const Aerosol& aerosol) {
  return aerosol.aod_550 <= 0.0 ||
         (aerosol.other_share <= 0.0 && std::abs(aerosol.angstrom_exponent - natural_exponent(aerosol.kind)) < 1e-4);
}

// Takes R, G, B (linear sRGB) from skies 0, 1, 2; XYZ.
glm::dvec3 channel_by_channel(const std::array<glm::dvec3, 3>& xyz) {
  static const glm::dmat3 to_srgb = xyz_to_linear_srgb(), to_xyz = srgb_to_xyz();
  glm::dvec3 srgb{0};
  for (int c = 0; c < 3; ++c) srgb[c] = (to_srgb * xyz[c])[c];
  return to_xyz * srgb;
}

// Coefficients of the powers of u for Chebyshev polynomials of w = stretch u + shift.
using Powers = std::array<std::array<double, kDomePowers>, kDomePowers>;  // [degree][power]
Powers chebyshev_in_powers(double stretch, double shift) {
  Powers powers{};
  powers[0][0] = 1.0;
  powers[1][0] = shift;
  powers[1][1] = stretch;
  for (int k = 2; k < kDomePowers; ++k)
    for (int p = 0; p < kDomePowers; ++p)
      powers[k][p] =
          2.0 * (shift * powers[k - 1][p] + (p > 0 ? stretch * powers[k - 1][p - 1] : 0.0)) - powers[k - 2][p];
  return powers;
}

// Share of the disc's area above the horizon; height: of its centre, in its radii.
double disc_above(double height) {
  const double h = std::clamp(height, -1.0, 1.0);
  return 0.5 + (h * std::sqrt(1.0 - h * h) + std::asin(h)) / kPi;
}

}  // namespace

double horizon_sine(double altitude_m) {
  const double q = kEarthRadius_m / (kEarthRadius_m + std::max(altitude_m, 0.0));
  return -std::sqrt(1.0 - q * q);
}

std::array<KindInChannel, 2> kinds_in_channel(const Aerosol& aerosol, double wavelength_nm) {
  const double wavelength = wavelength_nm / 550.0, share = aerosol.other_share;
  const double one = std::pow(wavelength, -natural_exponent(aerosol.kind));
  if (share <= 0.0) {
    const double tilt = natural_exponent(aerosol.kind) - aerosol.angstrom_exponent;
    return {{{aerosol.kind, 1.0, aerosol.aod_550 * std::pow(wavelength, tilt)}, {aerosol.kind, 0.0, 0.0}}};
  }
  const double other = std::pow(wavelength, -natural_exponent(aerosol.other));
  const double both = (1.0 - share) * one + share * other;
  const double tilt = natural_exponent(aerosol.kind, aerosol.other, share) - aerosol.angstrom_exponent;
  const double depth = aerosol.aod_550 * both * std::pow(wavelength, tilt);
  return {
      {{aerosol.kind, (1.0 - share) * one / both, depth / one}, {aerosol.other, share * other / both, depth / other}}};
}

DomeFunction dome(double altitude_m, const Aerosol& aerosol, const SunDirection& sun) {
  const DomeTable& table = dome_table();
  const Place place = clamped(altitude_m, sun);
  DomeFunction sky;
  sky.sun = glm::vec3(direction_from(from_degrees(place.sun_zenith_deg), azimuth_angle(sun)));
  sky.horizon_sine = static_cast<float>(horizon_sine(place.altitude_m));
  sky.steepness = static_cast<float>(table.ground_steepness * std::exp(place.altitude_m / table.steepness_scale_m));
  sky.lobes = glm::dvec3(table.lobes[0], table.lobes[1], table.lobes[2]);
  const double lowest = 1.0 / (1.0 + double{sky.steepness});  // u overhead
  const Powers powers = chebyshev_in_powers(2.0 / (1.0 - lowest), -(1.0 + lowest) / (1.0 - lowest));
  const auto coefficients_at = [&](AerosolKind kind, double aod_550) {
    const Row row = row_at(place, kind, aod_550);
    const glm::dvec3 mean = glm::exp(row.log_mean);
    std::array<glm::dvec3, kDomeTerms> coefficients{};
    for (int j = 0; j < kDomeAngles; ++j)
      for (int p = 0; p < kDomePowers; ++p) {
        glm::dvec3 sum{0};
        for (int k = 0; k < kDomePowers; ++k) sum += powers[k][p] * row.chebyshev[j * kDomePowers + k];
        coefficients[j * kDomePowers + p] = mean * sum;
      }
    return coefficients;
  };
  if (is_natural(aerosol)) {
    const auto coefficients = coefficients_at(aerosol.kind, aerosol.aod_550);
    std::copy(coefficients.begin(), coefficients.end(), sky.coefficients.begin());
    return sky;
  }
  std::array<std::array<glm::dvec3, kDomeTerms>, 3> skies{};
  for (std::size_t c = 0; c < 3; ++c)
    for (const KindInChannel& part : kinds_in_channel(aerosol, kDomeChannels_nm[static_cast<int>(c)])) {
      if (part.share <= 0.0) continue;
      const auto coefficients = coefficients_at(part.kind, part.aod_550);
      for (std::size_t k = 0; k < kDomeTerms; ++k) skies[c][k] += part.share * coefficients[k];
    }
  for (std::size_t k = 0; k < kDomeTerms; ++k)
    sky.coefficients[k] = glm::vec3(channel_by_channel({skies[0][k], skies[1][k], skies[2][k]}));
  return sky;
}

SunLight dome_sun(double altitude_m, const Aerosol& aerosol, const SunDirection& sun) {
  const Place place = clamped(altitude_m, sun);
  const double radius = kDomeSunRadius_rad;
  const double height = std::asin(std::clamp(sun.z, -1.0, 1.0)) - std::asin(horizon_sine(place.altitude_m));
  if (height <= -radius) return {};
  const auto sun_at = [&](AerosolKind kind, double aod_550) { return glm::exp(row_at(place, kind, aod_550).log_sun); };
  const auto sun_in = [&](int channel) {
    glm::dvec3 sum{0.0};
    for (const KindInChannel& part : kinds_in_channel(aerosol, kDomeChannels_nm[channel]))
      if (part.share > 0.0) sum += part.share * sun_at(part.kind, part.aod_550);
    return sum;
  };
  const glm::dvec3 whole = is_natural(aerosol) ? sun_at(aerosol.kind, aerosol.aod_550)
                                               : channel_by_channel({sun_in(0), sun_in(1), sun_in(2)});
  return {glm::vec3(whole * disc_above(height / radius)), glm::vec3(whole / (kPi * radius * radius))};
}

DomeFunction in_space(DomeFunction sky, const glm::dmat3& xyz_to_space) {
  for (glm::vec3& c : sky.coefficients) c = glm::vec3(xyz_to_space * glm::dvec3(c));
  return sky;
}

glm::dvec3 dome_light(const DomeFunction& sky, const Direction& view) {
  const auto terms = dome_terms(sky, view);
  glm::dvec3 light{0};
  for (int k = 0; k < kDomeTerms; ++k) light += terms[k] * glm::dvec3(sky.coefficients[k]);
  return glm::max(light, glm::dvec3(0.0));
}

}  // namespace kasumi

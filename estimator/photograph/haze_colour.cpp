#include "estimator/photograph/haze_colour.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "base/square.hpp"
#include "base/statistics.hpp"
#include "estimator/horizon/horizon.hpp"
#include "estimator/photograph/depth_from_haze.hpp"

namespace kasumi {
namespace {

constexpr double kLeastComponent = 0.1;  // of a line's direction: haze takes some of every channel
constexpr int kLeastPlaces = 24;         // six independent ones at four neighbours each
constexpr double kNeighbours = 4.0;      // places side by side show one material: so many count as one
constexpr double kNoSky = 3.0;           // the thickest haze is so much less sure to be infinity than the low sky
constexpr double kDisagreement = 3.0;    // channels that differ by more sigmas follow no law of the air
constexpr double kDark = 0.05;           // rho of dark things, give or take as much
constexpr double kDarkColour = 0.03;     // by which that of dark things may differ by channel, sigma
constexpr double kNoDepth = 1e-3;        // keeps the logarithm of no haze finite
constexpr double kLeastExponent = -0.5, kGreatestExponent = 2.5;  // that an aerosol may be given
constexpr double kMolecules = 4.08;  // Angstrom's exponent of molecules in visible light (Bodhaine 1999)

using Places = std::vector<glm::dvec3>;

// The mean of the darkest share.
glm::dvec3 darkest_of(std::vector<glm::vec3>& pixels, double share) {
  const auto count = std::max<std::ptrdiff_t>(1, std::lround(share * static_cast<double>(pixels.size())));
  std::ranges::nth_element(pixels, pixels.begin() + count - 1, {}, [](const auto& v) { return v.r + v.g + v.b; });
  const auto sum = std::accumulate(pixels.begin(), pixels.begin() + count, glm::vec3(0.0F));
  return glm::dvec3(sum) / static_cast<double>(count);
}

// L/Linf of the dark things of each place that shows no sky.
Places dark_things(const Image<glm::vec3>& relative, const Image<std::uint8_t>& sky, const HazeColourLimits& options) {
  const int longer = std::max(relative.width(), relative.height());
  const int side = std::max(4, static_cast<int>(std::lround(options.place * longer)));
  Places places;
  std::vector<glm::vec3> pixels;
  for (int top = 0; top + side <= relative.height(); top += side)
    for (int left = 0; left + side <= relative.width(); left += side) {
      pixels.clear();
      for (int y = top; y < top + side; ++y)
        for (int x = left; x < left + side; ++x)
          if (sky.empty() || sky.at(x, y) == 0) pixels.push_back(relative.at(x, y));
      if (pixels.size() < static_cast<std::size_t>(side) * static_cast<std::size_t>(side)) continue;
      places.push_back(darkest_of(pixels, options.darkest));
    }
  return places;
}

// ln(1 - L/Linf) where haze leaves enough contrast.
Places log_contrasts(const Places& places, const glm::dvec3& infinity, double faintest) {
  Places logs;
  for (const auto& place : places) {
    const auto left = 1.0 - place / infinity;
    if (std::min({left.r, left.g, left.b}) >= faintest) logs.push_back(glm::log(glm::min(left, glm::dvec3(1.0))));
  }
  return logs;
}

struct Line {
  glm::dvec3 middle{0.0};
  glm::dvec3 along{0.0};          // unit vector
  double spread = 0.0;            // standard deviation along it
  double range = 0.0;             // between the nearest and the farthest twentieth of the places
  double scatter = 0.0;           // standard deviation off it, in one direction
  double scatter_of_light = 0.0;  // the same in L/Linf
};

// The principal axis; places far off it count less, in a few rounds.
Line line_through(const Places& logs) {
  Line line;
  std::vector<double> weights(logs.size(), 1.0);
  std::vector<double> off(logs.size());
  auto& middle = line.middle;
  for (int round = 0; round < 12; ++round) {
    middle = glm::dvec3(0.0);
    double all = 0.0;
    for (std::size_t i = 0; i < logs.size(); ++i) {
      middle += weights[i] * logs[i];
      all += weights[i];
    }
    middle /= all;
    glm::dmat3 covariance{0.0};
    for (std::size_t i = 0; i < logs.size(); ++i)
      covariance += weights[i] / all * glm::outerProduct(logs[i] - middle, logs[i] - middle);
    line.along = glm::normalize(glm::dvec3(1.0));
    for (int i = 0; i < 50; ++i) {
      const auto next = covariance * line.along;
      if (glm::length(next) <= 0.0) return line;
      line.along = glm::normalize(next);
    }
    line.spread = std::sqrt(glm::dot(line.along, covariance * line.along));
    for (std::size_t i = 0; i < logs.size(); ++i) {
      const auto from_middle = logs[i] - middle;
      off[i] = glm::length(from_middle - glm::dot(from_middle, line.along) * line.along);
    }
    line.scatter = median(off) / kMedianLengthOverSigma;
    for (std::size_t i = 0; i < logs.size(); ++i)
      weights[i] = tukey_weight(off[i] / (kTukeyReach * std::max(line.scatter, 1e-6)));
  }
  std::vector<double> places;
  for (std::size_t i = 0; i < logs.size(); ++i) off[i] *= std::exp(logs[i].g);
  line.scatter_of_light = median(off) / kMedianLengthOverSigma;
  for (const auto& log : logs) places.push_back(glm::dot(log - middle, line.along));
  line.range = quantile(places, 0.95) - quantile(places, 0.05);
  return line;
}

// Angstrom's law through the three components of the line, and what they leave of it: the misfit in ln.
struct Law {
  double exponent = 0.0;
  glm::dvec3 left{0.0};
};
Law law_of(const glm::dvec3& along, const glm::dvec3& wavelength_nm) {
  const glm::dvec3 x = -glm::log(wavelength_nm), y = glm::log(along);
  const auto centred_x = x - (x.r + x.g + x.b) / 3.0, centred_y = y - (y.r + y.g + y.b) / 3.0;
  Law law;
  law.exponent = glm::dot(centred_x, centred_y) / glm::dot(centred_x, centred_x);
  law.left = centred_y - law.exponent * centred_x;
  return law;
}

// What was taken for infinity is seldom beyond all air: far land that fades into the sky passes for sky. That light lacks
// some of infinity's, by channel as the haze itself has it, and haze of any exponent then looks greyer than it is. How
// much it lacks is not known; of several shares each counts by how straight the places' line becomes.
struct Told {
  double exponent = 0.0;
  double apart = 0.0;  // standard deviation over those shares
};
struct Fit {
  Line line;
  glm::dvec3 left{0.0};   // what Angstrom's law leaves of the line's direction
  glm::dvec3 depth{0.0};  // optical depth of the places' middle, if what is dark there is as dark as dark things are
  Told by_slope, by_middle;
};
// Up to a quarter of the light from infinity: .9 per km in closed form had read 1.28.
constexpr double kLargestLack = 0.25, kLackStep = 0.025;

// Light from infinity that the measured lacks, by channel.
glm::dvec3 lacks_of(double lack, double exponent, const glm::dvec3& wavelength_nm) {
  if (lack <= 0.0) return glm::dvec3(0.0);
  return glm::pow(glm::dvec3(lack), glm::pow(wavelength_nm / wavelength_nm.g, glm::dvec3(-exponent)));
}

// Mean and spread of what several shares gave.
Told mean_of(const std::vector<double>& exponents, const std::vector<double>& weights) {
  double all = 0.0, mean = 0.0, square = 0.0;
  for (std::size_t i = 0; i < exponents.size(); ++i) {
    all += weights[i];
    mean += weights[i] * exponents[i];
    square += weights[i] * exponents[i] * exponents[i];
  }
  mean /= all;
  return {mean, std::sqrt(std::max(0.0, square / all - mean * mean))};
}

std::optional<Fit> fit_to(const Places& places, const glm::dvec3& wavelength_nm, const glm::dvec3& infinity,
                          const HazeColourLimits& options) {
  std::optional<Fit> best;
  double best_score = 0.0, exponent = 0.0, exponent_of_middle = 0.0;
  std::vector<double> by_slope, by_middle, scores;
  const auto shown = log_contrasts(places, infinity, options.faintest);
  const auto without_lack = [&](const glm::dvec3& log, double lack, double by_exponent) {
    const auto lacks = lacks_of(lack, by_exponent, wavelength_nm);
    return glm::log(glm::exp(log) * (1.0 - lacks) + lacks);
  };
  glm::dvec3 shown_middle{0.0};
  for (double lack = 0.0; lack <= kLargestLack; lack += kLackStep) {
    Fit fit;
    const auto fades = [&] {
      return std::min({fit.line.along.r, fit.line.along.g, fit.line.along.b}) > kLeastComponent;
    };
    for (int round = 0; round < 3; ++round) {
      Places logs;
      for (const auto& log : shown) logs.push_back(without_lack(log, lack, exponent));
      fit.line = line_through(logs);
      if (!fades()) break;
      const auto law = law_of(fit.line.along, wavelength_nm);
      exponent = law.exponent;
      fit.left = law.left;
      if (lack == 0.0) break;
    }
    if (!fades()) continue;
    if (lack == 0.0) shown_middle = fit.line.middle;
    for (int round = 0; round < 3; ++round) {
      const auto middle = without_lack(shown_middle, lack, exponent_of_middle);
      fit.depth = glm::max(std::log(1.0 - kDark) - middle, glm::dvec3(kNoDepth));
      exponent_of_middle = law_of(fit.depth, wavelength_nm).exponent;
    }
    // In light, not in its logarithm, which the lack stretches.
    const double score = -std::log(std::max(fit.line.scatter_of_light / (1.0 - lack), 1e-6));
    by_slope.push_back(exponent);
    by_middle.push_back(exponent_of_middle);
    scores.push_back(score);
    if (!best || score > best_score) {
      best = fit;
      best_score = score;
    }
  }
  if (!best) return std::nullopt;
  const double independent = static_cast<double>(shown.size()) / kNeighbours;
  for (double& score : scores) score = std::exp(independent * (score - best_score));
  best->by_slope = mean_of(by_slope, scores);
  best->by_middle = mean_of(by_middle, scores);
  return best;
}

}  // namespace

HazeColour haze_colour(const Image<glm::vec3>& relative, const Image<std::uint8_t>& sky,
                       const glm::dvec3& wavelength_nm, const HazeColourLimits& options) {
  HazeColour found;
  const auto places = dark_things(relative, sky, options);
  found.places = static_cast<int>(log_contrasts(places, glm::dvec3(1.0), options.faintest).size());
  if (found.places < kLeastPlaces) {
    found.reason =
        fmt::format("only {} places show land that haze has not hidden, expected {}", found.places, kLeastPlaces);
    return found;
  }
  const auto fit = fit_to(places, wavelength_nm, glm::dvec3(1.0), options);
  if (!fit) {
    found.reason = "from near to far its channels do not fade together, as they would in haze";
    return found;
  }
  const auto& line = fit->line;
  found.scatter = line.scatter;
  found.depth_range = line.range * line.along.g;
  found.depth = fit->depth.g;
  // A component's relative error: from noise, and from near and far things of different material.
  const double component = std::hypot(line.scatter / line.spread / std::sqrt(found.places / kNeighbours),
                                      std::max(options.material, line.scatter) / std::max(line.range, 1e-9)) /
                           std::min({line.along.r, line.along.g, line.along.b});
  const glm::dvec3 x = glm::log(wavelength_nm);
  const auto centred = x - (x.r + x.g + x.b) / 3.0;
  const double per_component = 1.0 / glm::dot(centred, centred);
  double slope_variance = component * component * per_component + std::pow(fit->by_slope.apart, 2);
  double left_variance = component * component;  // one direction of three is left
  const double dark = kDarkColour / std::min({fit->depth.r, fit->depth.g, fit->depth.b});
  double middle_variance = dark * dark * per_component + std::pow(fit->by_middle.apart, 2);
  for (int c = 0; c < 3; ++c) {
    glm::dvec3 infinity{1.0};
    infinity[c] += options.infinity;
    const auto moved = fit_to(places, wavelength_nm, infinity, options);
    if (!moved) continue;
    slope_variance += std::pow(moved->by_slope.exponent - fit->by_slope.exponent, 2);
    middle_variance += std::pow(moved->by_middle.exponent - fit->by_middle.exponent, 2);
    left_variance += glm::dot(moved->left - fit->left, moved->left - fit->left);
  }
  const double share = middle_variance / (slope_variance + middle_variance);  // of the slope
  found.exponent = share * fit->by_slope.exponent + (1.0 - share) * fit->by_middle.exponent;
  found.sigma = std::sqrt(share * slope_variance);
  const double misfit = glm::length(fit->left) / std::sqrt(left_variance);
  const double contradiction =
      std::abs(fit->by_slope.exponent - fit->by_middle.exponent) / std::sqrt(slope_variance + middle_variance);
  if (line.scatter > options.largest_scatter)
    found.reason = fmt::format("materials hide the haze: places scatter by {:.2f} about their line, expected {:.2f}",
                               line.scatter, options.largest_scatter);
  else if (found.sigma > options.largest_sigma)
    found.reason = fmt::format(
        "haze of an optical depth of {:.2f}, {:.2f} from near to far, is too thin: the exponent would be {:.1f} +- "
        "{:.1f}",
        found.depth, found.depth_range, found.exponent, found.sigma);
  else if (contradiction > kDisagreement)
    found.reason = fmt::format(
        "from near to far the exponent would be {:.1f}, by the colour of dark things {:.1f}: the land changes, too",
        fit->by_slope.exponent, fit->by_middle.exponent);
  else if (misfit > kDisagreement)
    found.reason = fmt::format(
        "its channels follow no one exponent ({:.1f} sigma off): from near to far the land changes, too", misfit);
  else if (found.exponent < kLeastExponent - found.sigma || found.exponent > kMolecules + found.sigma)
    found.reason = fmt::format("an exponent of {:.1f} +- {:.1f} is no air's", found.exponent, found.sigma);
  found.told = found.reason.empty();
  return found;
}

HazyPicture hazy_picture(const Camera& camera, const Photograph& photograph) {
  const int width = camera.width, height = camera.height;
  HazyPicture found;
  auto& light = found.relative;
  light = Image<glm::vec3>(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) light.at(x, y) = camera.light_at({x, y}, glm::dvec3(photograph.encoded.at(x, y)));
  const auto pixels = to_rgb8(photograph);
  auto parts = segment_sky(pixels);
  const auto horizon = parts.visible ? measure_horizon(camera, view_of(pixels)) : HorizonLight{};
  found.from_sky = horizon.usable();
  if (parts.visible) found.sky = std::move(parts.sky);
  const glm::dvec3 thickest = found.from_sky ? glm::dvec3(0.0) : light_of_thickest_haze(light);
  glm::dvec3 sum{0.0};
  for (int x = 0; x < width; ++x) {
    // Within a column of pixels azimuths hardly change.
    const auto direction = camera.direction_at({x, 0.5 * (height - 1)});
    const auto infinity = found.from_sky && direction ? column_at(horizon, azimuth_angle(*direction)).light : thickest;
    sum += infinity;
    for (int y = 0; y < height; ++y) light.at(x, y) /= glm::vec3(glm::max(infinity, glm::dvec3(1e-6)));
  }
  found.from_infinity = sum / static_cast<double>(width);
  return found;
}

HazeColour haze_colour_of(const Camera& camera, const HazyPicture& picture, HazeColourLimits options) {
  if (!picture.from_sky) options.infinity *= kNoSky;
  return haze_colour(picture.relative, picture.sky, channel_wavelengths_nm(camera), options);
}

std::optional<PartContrast> part_contrast(const HazyPicture& picture, const HazyPart& box) {
  constexpr double kBeside = 0.02, kBySky = 0.05, kByThickest = 0.15;  // relative: how alike the light from infinity is
  // Of the sky: a lens's flare; the share of pixels that counts as dark; relative variation of a sky that is even (hazy
  // land that passes for sky has texture).
  constexpr double kFlare = 0.005, kDarkest = 0.05, kSmooth = 0.03;
  constexpr int kSeam_px = 6, kFewestSky = 30;  // cameras that sharpen draw bright seams around what is dark
  const int width = picture.relative.width(), height = picture.relative.height();
  const auto end = [](int from, int length, int size) {
    return static_cast<int>(std::clamp<std::int64_t>(std::int64_t{from} + length, 0, size));
  };
  const int left = std::max(0, box.left), right = end(box.left, box.width, width);
  const int top = std::max(0, box.top), bottom = end(box.top, box.height, height);
  std::vector<glm::vec3> pixels;
  glm::dvec3 mean{0.0};
  for (int y = top; y < bottom; ++y)
    for (int x = left; x < right; ++x) {
      pixels.push_back(picture.relative.at(x, y));
      mean += glm::dvec3(pixels.back());
    }
  if (pixels.empty()) return std::nullopt;
  mean /= static_cast<double>(pixels.size());
  glm::dvec3 sky{0.0};
  double square_sum = 0.0;  // green
  int beside = 0;
  const int reach = std::max(2 * kSeam_px, right - left) + kSeam_px;
  if (!picture.sky.empty())
    for (int y = top; y < bottom; ++y)
      for (int x = std::max(0, left - reach); x < std::min(width, right + reach); ++x) {
        if ((x >= left - kSeam_px && x < right + kSeam_px) || picture.sky.at(x, y) != 255) continue;
        sky += glm::dvec3(picture.relative.at(x, y));
        square_sum += square(static_cast<double>(picture.relative.at(x, y).g));
        ++beside;
      }
  // What has texture is hazy land that was taken for sky.
  const double variance = beside > 0 ? square_sum / beside - square(sky.g / beside) : 0.0;
  const bool seen = beside >= kFewestSky && std::sqrt(std::max(0.0, variance)) < kSmooth * sky.g / beside;
  sky = seen ? sky / static_cast<double>(beside) : glm::dvec3(1.0);
  const glm::dvec3 dark = darkest_of(pixels, kDarkest);
  PartContrast found;
  // Land has many materials, of which only the dark ones fit the assumptions about landmarks.
  if (!seen) mean = dark;
  found.contrast = 1.0 - mean / sky;
  found.sigma = glm::dvec3(std::hypot(kFlare, kBeside * std::min(1.0, mean.g / sky.g)));
  found.infinity_sigma = seen ? kBeside : picture.from_sky ? kBySky : kByThickest;
  found.spread = std::max(0.0, (mean.g - dark.g) / sky.g);
  return found;
}

glm::dvec3 channel_wavelengths_nm(const Camera& camera) {
  const auto measure = spectral_measure(camera);
  glm::dvec3 sum{0.0};
  for (std::size_t i = 0; i < measure.weight.size(); ++i)
    sum += measure.weight[i] * std::log(measure.first_nm + static_cast<double>(i));
  return glm::exp(sum);
}

double aerosol_exponent(const HazeColour& colour, const AirState& air) {
  const double molecules = rayleigh_per_m(ScatteringModel::aerosol, 550.0);
  const double aerosol = mie_per_m(ScatteringModel::aerosol, 550.0, air);
  if (aerosol <= 0.0) return air.aerosol().angstrom_exponent;
  const double share = molecules / (molecules + aerosol);
  return std::clamp((colour.exponent - share * kMolecules) / (1.0 - share), kLeastExponent, kGreatestExponent);
}

}  // namespace kasumi

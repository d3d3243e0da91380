#include "estimator/sky_fit/tone_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "estimator/sky_fit/known_skies.hpp"

namespace kasumi {

namespace {

// At most so many of a picture, which bounds the time; fewer than 60 see too little contrast.
constexpr std::size_t kCurveReadings = 160, kFewestReadings = 60;
constexpr Radians kOneSky = from_degrees(3.0);   // suns nearer than that count as one sky, with one model error
constexpr double kLowest = 0.3, kHighest = 3.0;  // exponents
constexpr int kExponents = 93;                   // steps of 2.5 %
constexpr double kCoarse = 0.02;                 // of ln light: the known skies are that far apart
constexpr double kIndependentValues = 30.0;      // patches and colours of a sky, as in fit_sky()
constexpr double kModelsSigma = 0.05;            // the models' own contrasts differ from real skies' by about that
// Of the exponent, of ln light: beyond, the curve is not determined or the sky no clear one.
constexpr double kMostSigma = 0.15, kMostResidual = 0.12;

double exponent_at(int i) {
  return kLowest * std::pow(kHighest / kLowest, static_cast<double>(i) / (kExponents - 1));
}

// Sums of ln light as read and as a sky has it, each without its mean by colour.
struct Contrasts {
  double read_read = 0.0, read_sky = 0.0, sky_sky = 0.0;  // means per reading and colour
  double mean_square(double exponent) const {
    return std::max(0.0, read_read - 2.0 * exponent * read_sky + exponent * exponent * sky_sky);
  }
};
Contrasts contrasts(std::span<const SkyReading> readings, const KnownRadiance& sky) {
  const auto n = static_cast<double>(readings.size());
  glm::dvec3 r{0.0}, s{0.0}, rr{0.0}, rs{0.0}, ss{0.0};
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const glm::dvec3 read = glm::log(readings[i].light), light = sky.log_light[i];
    r += read, s += light, rr += read * read, rs += read * light, ss += light * light;
  }
  const auto mean = [n](const glm::dvec3& of_product, const glm::dvec3& a, const glm::dvec3& b) {
    const glm::dvec3 value = of_product / n - a * b / (n * n);
    return (value.x + value.y + value.z) / 3.0;
  };
  return {mean(rr, r, r), mean(rs, r, s), mean(ss, s, s)};
}

// For every exponent how likely it is by one sky, and what the best sky leaves.
struct ExponentLikelihood {
  std::array<double, kExponents> log_likelihood{}, mean_square{};
};
ExponentLikelihood judge(const std::vector<const ToneEvidence*>& pictures, double altitude_m) {
  ExponentLikelihood sky;
  sky.mean_square.fill(std::numeric_limits<double>::infinity());
  std::vector<std::array<double, kExponents>> left;  // by known sky: mean over the pictures
  for (const ToneEvidence* picture : pictures) {
    const std::vector<SkyReading> readings = thinned(picture->readings, kCurveReadings);
    const std::vector<KnownRadiance> skies = known_skies(readings, picture->sun, altitude_m);
    left.resize(skies.size());
    for (std::size_t k = 0; k < skies.size(); ++k) {
      const Contrasts sums = contrasts(readings, skies[k]);
      for (int i = 0; i < kExponents; ++i)
        left[k][static_cast<std::size_t>(i)] += sums.mean_square(exponent_at(i)) / static_cast<double>(pictures.size());
    }
  }
  for (std::size_t i = 0; i < kExponents; ++i) {
    double likelihood = 0.0;
    for (const auto& known : left) {
      likelihood += std::pow(known[i] + kCoarse * kCoarse, -0.5 * kIndependentValues);
      sky.mean_square[i] = std::min(sky.mean_square[i], known[i]);
    }
    sky.log_likelihood[i] = std::log(likelihood);
  }
  return sky;
}

struct Mean {
  double value = 0.0, sigma = 0.0;
};
Mean mean_exponent(const std::array<double, kExponents>& log_likelihood) {
  const double most = *std::ranges::max_element(log_likelihood);
  double sum = 0.0, first = 0.0, second = 0.0;
  for (int i = 0; i < kExponents; ++i) {
    const double weight = std::exp(log_likelihood[static_cast<std::size_t>(i)] - most), x = exponent_at(i);
    sum += weight, first += weight * x, second += weight * x * x;
  }
  return {first / sum, std::sqrt(std::max(0.0, second / sum - first * first / (sum * sum)))};
}

}  // namespace

Result<ToneCurve> find_tone_curve(std::span<const ToneEvidence> pictures, double altitude_m) {
  std::vector<std::vector<const ToneEvidence*>> by_sky;
  ToneCurve curve;
  for (const ToneEvidence& picture : pictures) {
    if (picture.readings.size() < kFewestReadings) continue;
    ++curve.pictures;
    const auto same = std::ranges::find_if(
        by_sky, [&](const auto& sky) { return angle_between(sky.front()->sun, picture.sun).value < kOneSky.value; });
    if (same == by_sky.end())
      by_sky.push_back({&picture});
    else
      same->push_back(&picture);
  }
  // Exposures of one sky repeat what it says of itself, and its contrasts may be the air's.
  if (by_sky.size() < 2)
    return fail(FaultKind::bad_input,
                "{} of {} pictures show enough cloudless sky, under {} sun{}; a tone curve is found from at least two "
                "pictures whose suns are {:.0f} deg apart",
                curve.pictures, pictures.size(), by_sky.size(), by_sky.size() == 1 ? "" : "s", to_degrees(kOneSky));

  std::array<double, kExponents> log_likelihood{}, mean_square{};
  std::vector<double> each;
  for (const auto& same : by_sky) {
    const ExponentLikelihood sky = judge(same, altitude_m);
    for (std::size_t i = 0; i < kExponents; ++i) {
      log_likelihood[i] += sky.log_likelihood[i];
      mean_square[i] += sky.mean_square[i] / static_cast<double>(by_sky.size());
    }
    each.push_back(mean_exponent(sky.log_likelihood).value);
  }
  const Mean mean = mean_exponent(log_likelihood);
  double scatter = 0.0;  // of the skies' own answers, which includes what is wrong with each
  for (const double one : each) scatter += std::pow(one - mean.value, 2);
  const auto skies = static_cast<double>(each.size());
  const double by_scatter = skies > 1.0 ? std::sqrt(scatter / (skies - 1.0) / skies) : 0.0;
  curve.exponent = mean.value;
  curve.sigma = std::hypot(std::max(mean.sigma, by_scatter), kModelsSigma);
  const auto likeliest = std::ranges::max_element(log_likelihood) - log_likelihood.begin();
  curve.log_residual = std::sqrt(mean_square[static_cast<std::size_t>(likeliest)]);

  if (curve.log_residual > kMostResidual)
    return fail(
        FaultKind::bad_input,
        "no tone curve makes clear skies of these {} pictures: with the exponent {:.2f} they are off by {:.0f} %",
        curve.pictures, curve.exponent, 100.0 * curve.log_residual);
  if (likeliest == 0 || likeliest + 1 == kExponents || curve.sigma > kMostSigma)
    return fail(FaultKind::bad_input,
                "these {} pictures do not determine a tone curve: the exponent {:.2f} is uncertain by {:.2f}; take "
                "pictures under suns of other heights",
                curve.pictures, curve.exponent, curve.sigma);
  return curve;
}

Response corrected(const Response& supposed, double exponent) {
  constexpr int kLast = 1023;  // 10 bits: finer than an 8-bit camera's steps
  std::array<std::vector<double>, 3> light;
  for (int i = 0; i <= kLast; ++i) {
    const glm::dvec3 as_read = supposed.to_light(glm::dvec3{static_cast<double>(i) / kLast});
    for (int c = 0; c < 3; ++c)
      light[static_cast<std::size_t>(c)].push_back(std::pow(std::clamp(as_read[c], 0.0, 1.0), 1.0 / exponent));
  }
  return Response::table(std::move(light));
}

}  // namespace kasumi

#include "estimator/cloud_cover/cloud_cover.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "estimator/cloud_cover/clear_blue.hpp"
#include "estimator/cloud_cover/pixel_features.hpp"
#include "estimator/cloud_cover/sky_part.hpp"
#include "estimator/cloud_cover/sun_glow.hpp"
#include "estimator/nth_smallest.hpp"

namespace kasumi {

namespace {

constexpr float kCloudy = 0.33f;                                 // whiteness from which an element is cloud
constexpr float kSurelyCloudy = 0.51f, kPossiblyCloudy = 0.18f;  // for sigma
constexpr std::array kBounds = {0.08, 0.30, 0.93};               // clear | few | broken | overcast
constexpr double kAbove = 0.5;                                   // weight of the sky above kClassZenith
constexpr float kClassZenith = 75.0f;  // degrees; below, haze and what stands on the horizon look like cloud

CloudCover no_fraction(CoverClass sky, std::string reason, double confidence = 0.0) {
  CloudCover cover;
  cover.sky = sky;
  cover.reason = std::move(reason);
  cover.confidence = confidence;
  return cover;
}

// Quantiles of the channels and of the colourfulness inside the circle.
struct Levels {
  double median = 0.0;   // of the light
  double bright = 0.0;   // 95 % of the brightest channel
  double weakest = 0.0;  // 95 % of the darkest channel
  double colour = 0.0;   // 99 % of the largest less the smallest channel
  double clipped = 0.0;  // share
};

Levels levels_of(const PixelFeatures& sky) {
  std::array<std::vector<float>, 5> values;
  for (int y = 0; y < sky.rgb.rows; y += 2)
    for (int x = 0; x < sky.rgb.cols; x += 2) {
      if (!sky.inside(y, x)) continue;
      const cv::Vec3f& v = sky.rgb(y, x);
      for (int c = 0; c < 3; ++c) values[static_cast<std::size_t>(c)].push_back(v[c]);
      values[3].push_back(sky.light(y, x));
      values[4].push_back(std::max({v[0], v[1], v[2]}) - std::min({v[0], v[1], v[2]}));
    }
  const auto quantile = [](const std::vector<float>& v, double share) -> double { return counted_quantile(v, share); };
  Levels levels;
  const std::array bright = {quantile(values[0], 0.95), quantile(values[1], 0.95), quantile(values[2], 0.95)};
  levels.bright = *std::max_element(bright.begin(), bright.end());
  levels.weakest = *std::min_element(bright.begin(), bright.end());
  levels.median = quantile(values[3], 0.5);
  levels.colour = quantile(values[4], 0.99);
  levels.clipped = static_cast<double>(cv::countNonZero(sky.clipped)) / std::max(1, sky.count);
  return levels;
}

// Findings from brightness and channels alone.
std::optional<CloudCover> without_colour(const PixelFeatures& sky, const Levels& levels) {
  if (sky.count < 2000) return no_fraction(CoverClass::unknown, "the picture shows almost no sky");
  if (levels.median < 0.025 && cv::countNonZero(sky.clipped) > 8)
    return no_fraction(CoverClass::unknown, "under-exposed beside the sun");
  if (levels.median < 0.025 || levels.bright < 0.06) return no_fraction(CoverClass::night, "dark", 0.8);
  if (levels.weakest < 0.2 * levels.bright)
    return no_fraction(CoverClass::unknown, fmt::format("a channel is missing: it reaches {:.0f} % of the others",
                                                        100.0 * levels.weakest / levels.bright));
  if (levels.colour < 0.012) return no_fraction(CoverClass::unknown, "the picture has no colour");
  if (levels.clipped > 0.7)
    return no_fraction(CoverClass::unknown, fmt::format("over-exposed: {:.0f} % white", 100.0 * levels.clipped));
  return std::nullopt;
}

double median_blueness(const PixelFeatures& sky, const cv::Mat1b& region) {
  std::vector<float> values;
  for (int y = 0; y < region.rows; y += 2)
    for (int x = 0; x < region.cols; x += 2)
      if (region(y, x)) values.push_back(sky.blueness(y, x));
  return counted_median(values);
}

double share_of(const cv::Mat1b& part, const cv::Mat1b& whole) {
  return static_cast<double>(cv::countNonZero(cv::Mat1b(part & whole))) / std::max(1, cv::countNonZero(whole));
}

// The class of a fraction `f` and the probability that it is right, given the fraction's error.
void classify(CloudCover& cover, double f) {
  std::size_t i = 0;
  while (i < kBounds.size() && f >= kBounds[i]) ++i;
  cover.sky = std::array{CoverClass::clear, CoverClass::few, CoverClass::broken, CoverClass::overcast}[i];
  const auto below = [&](double bound) { return 0.5 * std::erfc((f - bound) / (std::sqrt(2.0) * cover.sigma)); };
  const double from = i == 0 ? 0.0 : below(kBounds[i - 1]), to = i == kBounds.size() ? 1.0 : below(kBounds[i]);
  cover.confidence = std::max(0.0, to - from);
}

}  // namespace

std::string_view name_of(CoverClass sky) {
  switch (sky) {
    case CoverClass::unknown: return "unknown";
    case CoverClass::clear: return "clear";
    case CoverClass::few: return "few";
    case CoverClass::broken: return "broken";
    case CoverClass::overcast: return "overcast";
    case CoverClass::night: return "night";
  }
  return "unknown";
}

CloudCover cloud_cover(const SkyPicture& picture, const Camera& camera, const std::optional<SunDirection>& sun) {
  std::shared_ptr<const PixelDirections> kept;
  return cloud_cover(picture, camera, sun, kept);
}

CloudCover cloud_cover(const SkyPicture& picture, const Camera& camera, const std::optional<SunDirection>& sun,
                       std::shared_ptr<const PixelDirections>& kept, int samples) {
  if (!kept || !kept->fits(picture)) kept = std::make_shared<const PixelDirections>(pixel_directions(picture, camera));
  const PixelFeatures sky = pixel_features(picture, *kept);
  const Levels levels = levels_of(sky);
  if (const auto answer = without_colour(sky, levels)) return *answer;

  const cv::Mat1b before = not_sky(sky);
  const cv::Mat1b region(sky.inside & ~before);
  const double land = share_of(before, sky.inside);
  if (land > 0.9) return no_fraction(CoverClass::unknown, "the picture shows almost no sky");
  if (levels.bright < 0.45 && median_blueness(sky, region) < -0.12)
    return no_fraction(CoverClass::night, "dim and lit by lamps", 0.8);

  const auto sun_place = sun ? sun : brightest_patch(sky, region);
  const cv::Mat1f sun_deg = sun_place ? sun_distance(sky, *sun_place) : cv::Mat1f();
  const ClearBlue blue = fit_clear_blue(sky, region, sun_deg, {.samples = samples});
  if (!blue.found) return no_fraction(CoverClass::unknown, "too little of the sky is neither white nor black");
  const cv::Mat1f white = whiteness(sky, blue, sun_deg);
  cv::Mat1b cloud((white > kCloudy) & region);
  const cv::Mat1b known(region & ~sky.clipped);
  cv::Mat1b glowing(cv::Mat1b::zeros(known.size()));
  // Glow needs a clear sky to be the glow of.
  if (1.0 - share_of(cloud, known) > 0.08) {
    glowing = glow(sky, region, cloud, sun_deg);
    cloud &= ~glowing;
  }

  // A clipped element is cloud as far as its surroundings are.
  cv::Mat1f is_cloud;
  cloud.convertTo(is_cloud, CV_32F, 1.0 / 255.0);
  const cv::Mat1f around = InsideMeans(known, scaled_side(sky, 41)).of(is_cloud);
  around.copyTo(is_cloud, sky.clipped);
  CloudCover cover;
  cover.fraction = std::clamp(cv::mean(is_cloud, region)[0], 0.0, 1.0);

  const auto share_above = [&](float limit) { return share_of(cv::Mat1b((white > limit) & ~glowing), known); };
  const double span = share_above(kPossiblyCloudy) - share_above(kSurelyCloudy);
  const double clipped = share_of(sky.clipped, region), glow_share = share_of(glowing, known);
  // Little contrast: a hazy sky of two kinds, or an overcast one.
  const double doubt = 0.12 * std::exp(-std::pow((blue.contrast - 0.10) / 0.04, 2));
  cover.sigma =
      std::hypot(std::hypot(0.035, 0.6 * span, doubt), 0.3 * clipped, std::hypot(0.3 * glow_share, 0.2 * land));
  // People classify a sky mostly by its upper part.
  const cv::Mat1b upper(region & (sky.zenith_deg < kClassZenith));
  const bool enough = cv::countNonZero(upper) > 0.3 * cv::countNonZero(region);
  const double above = enough ? cv::mean(is_cloud, upper)[0] : *cover.fraction;
  classify(cover, kAbove * above + (1.0 - kAbove) * *cover.fraction);

  cover.elements = Image<CoverElement>(picture.encoded.width(), picture.encoded.height(), CoverElement::not_sky);
  for (int y = 0; y < region.rows; ++y)
    for (int x = 0; x < region.cols; ++x)
      if (region(y, x)) cover.elements.at(x, y) = is_cloud(y, x) > 0.5f ? CoverElement::cloud : CoverElement::clear;
  return cover;
}

Image<std::uint8_t> clear_air_of(const CloudCover& cover) {
  Image<std::uint8_t> clear(cover.elements.width(), cover.elements.height());
  for (std::size_t i = 0; i < clear.elements().size(); ++i)
    clear.elements()[i] = cover.elements.elements()[i] == CoverElement::clear ? 1 : 0;
  return clear;
}

}  // namespace kasumi

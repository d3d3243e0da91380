#include "estimator/turbidity/cloud_mask.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"
#include "estimator/given_air.hpp"
#include "estimator/nth_smallest.hpp"
#include "estimator/turbidity/element_maps.hpp"

namespace kasumi {

namespace {

// ln R/B and ln Y of the clear sky in this camera's channels; NaN where the model leaves the camera's gamut.
struct Expected {
  float colour = 0.0f, luminance = 0.0f;
};
Expected expected_at(const SiteSky& model, const glm::dmat3& xyz_to_light, const Direction& view) {
  const glm::dvec3 xyz = model.relative_xyz(view);
  const glm::dvec3 light = xyz_to_light * xyz;
  return {static_cast<float>(std::log(light.r / light.b)), static_cast<float>(std::log(xyz.y))};
}

float colour_of(const glm::vec3& light) {
  return std::log(light.r / light.b);
}

// The turbidity and white balance for which most of the sky agrees in colour and luminance at once. That part is clear
// sky, since clouds agree in neither.
struct ColourConsensus {
  Turbidity turbidity;
  float white_balance = 0.0f;  // measured minus expected ln R/B
  double score = -std::numeric_limits<double>::infinity();
};

using ColourSample = CloudMasks::ColourSample;

// The fullest cell of a coarse plane of (colour, luminance) residuals; cells overlap by half.
ColourConsensus fullest_cell(const std::vector<ColourSample>& samples, Turbidity turbidity, const SiteSky& model,
                             const glm::dmat3& xyz_to_light) {
  constexpr int kSide = 64;       // cells: a plane of 3.2 by 3.2 in ln R/B and ln Y
  constexpr float kStep = 0.05f;  // two of them make a cell
  std::vector<glm::vec2> residuals;
  residuals.reserve(samples.size());
  for (const ColourSample& sample : samples) {
    const Expected expected = expected_at(model, xyz_to_light, sample.view);
    const glm::vec2 residual{sample.colour - expected.colour, sample.luminance - expected.luminance};
    if (std::isfinite(residual.x) && std::isfinite(residual.y)) residuals.push_back(residual);
  }
  ColourConsensus best{turbidity};
  if (residuals.size() < 8) return best;
  const auto middle = [&residuals](int c) {
    std::vector<float> values;
    values.reserve(residuals.size());
    for (const glm::vec2& r : residuals) values.push_back(r[c]);
    return median_in_place(values);
  };
  const glm::vec2 origin = glm::vec2{middle(0), middle(1)} - 0.5f * kSide * kStep;
  // Summed-area table, so that a cell of any width costs four look-ups.
  constexpr int kSums = kSide + 1;
  std::array<int, kSums * kSums> sums{};
  const auto sum_to = [&sums](int x, int y) -> int& {
    return sums[static_cast<std::size_t>(y) * kSums + static_cast<std::size_t>(x)];
  };
  for (const glm::vec2& r : residuals) {
    const glm::vec2 cell = (r - origin) / kStep;
    if (cell.x >= 0.0f && cell.y >= 0.0f && cell.x < kSide && cell.y < kSide)
      ++sum_to(static_cast<int>(cell.x) + 1, static_cast<int>(cell.y) + 1);
  }
  for (int y = 1; y <= kSide; ++y)
    for (int x = 1; x <= kSide; ++x) sum_to(x, y) += sum_to(x - 1, y) + sum_to(x, y - 1) - sum_to(x - 1, y - 1);
  const auto all = static_cast<double>(residuals.size());
  for (const int width : {2, 4, 8}) {
    int most = 0, at = 0;
    for (int y = 0; y + width <= kSide; ++y)
      for (int x = 0; x + width <= kSide; ++x) {
        const int sum = sum_to(x + width, y + width) - sum_to(x, y + width) - sum_to(x + width, y) + sum_to(x, y);
        if (sum > most) most = sum, at = x;
      }
    // Log likelihood of this many in so small a cell, with the rest anywhere.
    constexpr double kBackground = 6.0;
    const double inside = most, outside = all - inside, area = std::pow(width * static_cast<double>(kStep), 2);
    const double score = inside * std::log(std::max(1.0, inside) / (all * area)) +
                         (outside > 0.0 ? outside * std::log(outside / (all * kBackground)) : 0.0);
    if (score > best.score)
      best = {turbidity, origin.x + (static_cast<float>(at) + 0.5f * static_cast<float>(width)) * kStep, score};
  }
  return best;
}

std::vector<ColourSample> colour_samples(const ElementLight& sky, const ElementGeometry& geometry) {
  constexpr int kColourSamples = 500;  // the fullest cell's share within some 2 %
  std::mt19937_64 random(2017);
  std::vector<ColourSample> samples;
  for (const glm::ivec2& e : draw_elements(sky, geometry, kColourSamples, random))
    samples.push_back({Direction(geometry.direction.at(e.x, e.y)), colour_of(sky.light.at(e.x, e.y)),
                       sky.log_luminance.at(e.x, e.y)});
  return samples;
}

template <class ModelAt>
ColourConsensus agree_on_colour(const std::vector<ColourSample>& samples, const ModelAt& model_at,
                                const glm::dmat3& xyz_to_light) {
  // Even in what the sky's colour changes by, dense where it changes fast.
  constexpr std::array kTurbidities{1.8, 2.0, 2.3, 2.7, 3.3, 4.2, 5.5, 7.5, 10.0, 14.0};
  ColourConsensus best;
  for (const double t : kTurbidities) {
    const ColourConsensus here = fullest_cell(samples, Turbidity{t}, model_at(Turbidity{t}), xyz_to_light);
    if (here.score > best.score) best = here;
  }
  return best;
}

// A smooth quantity of the sky that is expensive to compute, evaluated on a coarse lattice and interpolated.
template <class Quantity>
class Interpolated {
 public:
  Interpolated(const ElementGeometry& geometry, Quantity quantity)
      : geometry_(geometry), quantity_(std::move(quantity)) {
    const int width = geometry.direction.width(), height = geometry.direction.height();
    nodes_ = Image<float>((width + kStep - 1) / kStep + 1, (height + kStep - 1) / kStep + 1,
                          std::numeric_limits<float>::quiet_NaN());
    for (int j = 0; j < nodes_.height(); ++j)
      for (int i = 0; i < nodes_.width(); ++i) {
        const int x = i * kStep, y = j * kStep;
        if (geometry.direction.contains(x, y) && geometry.direction.at(x, y).z > 0.1f) nodes_.at(i, j) = direct(x, y);
      }
  }
  float at(int x, int y) const {
    const int i = x / kStep, j = y / kStep;
    const float u = static_cast<float>(x % kStep) / kStep, v = static_cast<float>(y % kStep) / kStep;
    const float between = (1.0f - v) * ((1.0f - u) * nodes_.at(i, j) + u * nodes_.at(i + 1, j)) +
                          v * ((1.0f - u) * nodes_.at(i, j + 1) + u * nodes_.at(i + 1, j + 1));
    return std::isfinite(between) ? between : direct(x, y);
  }

 private:
  static constexpr int kStep = 6;  // elements between nodes of a smooth model
  float direct(int x, int y) const { return quantity_(Direction(geometry_.direction.at(x, y))); }
  const ElementGeometry& geometry_;
  Quantity quantity_;
  Image<float> nodes_;
};

// ln R/B of the clear sky that most of the picture agrees with, as this camera would have it.
class ExpectedColour {
 public:
  ExpectedColour(const std::vector<ColourSample>& samples, const ElementGeometry& geometry, const SunDirection& sun,
                 const ModelToFit& fitted)
      : xyz_to_light_(glm::inverse(geometry.light_to_xyz)),
        consensus_(agree_on_colour(
            samples, [&](Turbidity t) { return model_at(t, sun, fitted); }, xyz_to_light_)),
        model_(model_at(consensus_.turbidity, sun, fitted)),
        expected_(geometry, [this](const Direction& view) { return expected_at(model_, xyz_to_light_, view).colour; }) {
  }
  ExpectedColour(const ExpectedColour&) = delete;  // expected_ refers to it
  ExpectedColour& operator=(const ExpectedColour&) = delete;
  float at(int x, int y) const { return expected_.at(x, y) + consensus_.white_balance; }
  Turbidity turbidity() const { return consensus_.turbidity; }

 private:
  static SiteSky model_at(Turbidity t, const SunDirection& sun, const ModelToFit& fitted) {
    return SiteSky(fitted.model, air_of(t, fitted.aerosol), sun, fitted.altitude_m);
  }
  glm::dmat3 xyz_to_light_;
  ColourConsensus consensus_;
  SiteSky model_;
  Interpolated<std::function<float(const Direction&)>> expected_;
};

// Classifies marked elements and their margin as cloud. Returns the share of the clear solid angle that was not marked;
// the margin counts as clear.
double mark_clouds(Image<PixelUse>& use, const ElementGeometry& geometry, cv::Mat1b& marked) {
  const cv::Mat1b grown = grown_over_soft_edges(marked);
  double clear = 0.0, all = 0.0;
  for (int y = 0; y < marked.rows; ++y)
    for (int x = 0; x < marked.cols; ++x) {
      if (use.at(x, y) != PixelUse::clear) continue;
      const auto angle = static_cast<double>(geometry.solid_angle.at(x, y));
      all += angle;
      if (marked(y, x) == 0) clear += angle;
      if (grown(y, x) != 0) use.at(x, y) = PixelUse::cloud;
    }
  return all > 0.0 ? clear / all : 0.0;
}

// From the texture of the clear sky's smoother half.
float texture_limit(const cv::Mat1f& texture, const cv::Mat1f& counts, const CloudMaskLimits& options) {
  std::vector<float> unevenness;
  for (int y = 0; y < counts.rows; ++y)
    for (int x = 0; x < counts.cols; ++x)
      if (counts(y, x) != 0.0f) unevenness.push_back(texture(y, x));
  return static_cast<float>(std::max(
      options.least_texture, options.texture_scatter * static_cast<double>(counted_quantile(unevenness, 0.25))));
}

// Marks what is more textured, or whiter than the clear sky's own scatter: the width of the bluer half of its colours.
double mark_by(Image<PixelUse>& use, const ElementGeometry& geometry, const cv::Mat1f& counts, const cv::Mat1f& colour,
               const cv::Mat1f& texture, float most_texture, const CloudMaskLimits& options) {
  std::vector<float> bluer;
  for (int y = 0; y < counts.rows; ++y)
    for (int x = 0; x < counts.cols; ++x)
      if (counts(y, x) != 0.0f && colour(y, x) < 0.0f) bluer.push_back(-colour(y, x));
  const auto colour_limit =
      static_cast<float>(std::max(options.least_colour, options.colour_scatter * kSigmaOverMedianSize *
                                                            static_cast<double>(counted_quantile(bluer, 0.5))));
  cv::Mat1b cloud(counts.size(), std::uint8_t{0});
  for (int y = 0; y < counts.rows; ++y)
    for (int x = 0; x < counts.cols; ++x)
      if (counts(y, x) != 0.0f && (colour(y, x) > colour_limit || texture(y, x) > most_texture)) cloud(y, x) = 1;
  return mark_clouds(use, geometry, cloud);
}

}  // namespace

CloudMaskResult mask_clouds(ElementLight& sky, const ElementGeometry& geometry, const SunDirection& sun,
                            const CloudMaskLimits& options, const ModelToFit& fitted) {
  const ExpectedColour expected(colour_samples(sky, geometry), geometry, sun, fitted);
  // Compares every element with the clear sky expected there.
  const cv::Mat1f none(sky.use.height(), sky.use.width(), 0.0f);
  cv::Mat1f counts = none.clone(), colour = none.clone(), luminance = none.clone();
  for (int y = 0; y < none.rows; ++y)
    for (int x = 0; x < none.cols; ++x) {
      if (sky.use.at(x, y) != PixelUse::clear) continue;
      const float whiter = colour_of(sky.light.at(x, y)) - expected.at(x, y);
      if (!std::isfinite(whiter)) continue;
      counts(y, x) = 1.0f;
      colour(y, x) = whiter;
      luminance(y, x) = sky.log_luminance.at(x, y);
    }
  const cv::Mat1f texture = texture_of(luminance, counts);
  const double clear = mark_by(sky.use, geometry, counts, mean_over(colour, counts, 3), texture,
                               texture_limit(texture, counts, options), options);
  return {clear, expected.turbidity()};
}

CloudMasks::CloudMasks(const ElementLight& sky, const ElementLooks& looks, const ElementGeometry& geometry,
                       const SunDirection& sun, const CloudMaskLimits& options)
    : unmarked_(sky.use),
      looks_(looks),
      geometry_(geometry),
      sun_(sun),
      options_(options),
      samples_(colour_samples(sky, geometry)),
      texture_limit_(texture_limit(looks.texture, looks.known, options)) {}

Image<PixelUse> CloudMasks::by(const ModelToFit& fitted) const {
  const ExpectedColour expected(samples_, geometry_, sun_, fitted);
  cv::Mat1f counts = looks_.known.clone(), colour(looks_.known.size(), 0.0f);
  for (int y = 0; y < counts.rows; ++y)
    for (int x = 0; x < counts.cols; ++x) {
      if (counts(y, x) == 0.0f) continue;
      const float by_model = expected.at(x, y);
      if (std::isfinite(by_model))
        colour(y, x) = by_model;
      else
        counts(y, x) = 0.0f;
    }
  cv::subtract(looks_.colour, mean_over(colour, counts, 3), colour);
  Image<PixelUse> use = unmarked_;
  mark_by(use, geometry_, counts, colour, looks_.texture, texture_limit_, options_);
  return use;
}

double mask_outliers(ElementLight& sky, const ElementGeometry& geometry, const SunDirection& sun, Turbidity turbidity,
                     double log_gain, double limit, const FittedSky& fitted) {
  const int width = sky.use.width(), height = sky.use.height();
  const Interpolated expected(geometry, [&](const Direction& view) {
    return static_cast<float>(fitted.log_luminance(turbidity, view.z, angle_between(view, sun).value));
  });
  cv::Mat1f counts(height, width, 0.0f), residual(height, width, 0.0f);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (sky.use.at(x, y) != PixelUse::clear) continue;
      counts(y, x) = 1.0f;
      residual(y, x) = sky.log_luminance.at(x, y) - expected.at(x, y) - static_cast<float>(log_gain);
    }
  const cv::Mat1f smooth = mean_over(residual, counts, 3);
  cv::Mat1b outlier(height, width, std::uint8_t{0});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (counts(y, x) != 0.0f && std::abs(smooth(y, x)) > static_cast<float>(limit)) outlier(y, x) = 1;
  return mark_clouds(sky.use, geometry, outlier);
}

}  // namespace kasumi

#include "estimator/photograph/depth_from_haze.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <glm/common.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"
#include "calib/mask/guided_filter.hpp"

namespace kasumi {
namespace {

Image<float> smallest_around(Image<float> values, int side) {
  const cv::Mat view(values.height(), values.width(), CV_32F, values.elements().data());
  Image<float> smallest(values.width(), values.height());
  cv::Mat result(values.height(), values.width(), CV_32F, smallest.elements().data());
  cv::erode(view, result, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
  return smallest;
}

Image<float> darkest_around(const Image<glm::vec3>& picture, const DepthParameters& options) {
  const int longer = std::max(picture.width(), picture.height());
  Image<float> least(picture.width(), picture.height());
  std::ranges::transform(picture.elements(), least.elements().begin(), [](const glm::vec3& v) {
    return std::clamp(std::min({v.r, v.g, v.b}), 0.0F, 1.0F);
  });
  return smallest_around(std::move(least), std::max(3, static_cast<int>(std::lround(options.patch * longer)) | 1));
}

// Deviation of the green channel around each pixel.
Image<float> texture_of(const Image<glm::vec3>& encoded, int side) {
  cv::Mat green(encoded.height(), encoded.width(), CV_32F), mean, squares;
  for (int y = 0; y < encoded.height(); ++y)
    for (int x = 0; x < encoded.width(); ++x) green.at<float>(y, x) = encoded.at(x, y).g;
  cv::boxFilter(green, mean, CV_32F, {side, side});
  cv::sqrBoxFilter(green, squares, CV_32F, {side, side});
  Image<float> texture(encoded.width(), encoded.height());
  for (int y = 0; y < encoded.height(); ++y)
    for (int x = 0; x < encoded.width(); ++x) {
      const float here = mean.at<float>(y, x);
      texture.at(x, y) = std::sqrt(std::max(0.0F, squares.at<float>(y, x) - here * here));
    }
  return texture;
}
constexpr float kSkyTexture = 0.012F;  // three levels of 255: assumed sky with more texture is land in haze
constexpr float kDarkestSky = 0.75F;   // of the light of the thickest haze
constexpr float kElsewhere = 0.01F;    // weight of that light outside the sky

// Level path with this optical depth in the green channel, by Newton's method: its attenuation is a sum of
// exponentials.
double distance_of(const HazeCoefficients& haze, double optical_depth) {
  double distance_m = optical_depth / (haze.rayleigh_per_m[0].g + haze.mie_per_m[0].g);
  for (int i = 0; i < 8; ++i) {
    const double step = 1e-3 * distance_m + 1.0;
    const double here = -std::log(attenuation(haze, {distance_m, distance_m}).g);
    const double there = -std::log(attenuation(haze, {distance_m + step, distance_m + step}).g);
    distance_m = std::max(0.1, distance_m - (here - optical_depth) * step / (there - here));
  }
  return distance_m;
}

}  // namespace

Image<float> depth_from_haze(const Image<glm::vec3>& relative, const Image<glm::vec3>& encoded,
                             const AttenuationNodes& nodes, ScatteringModel model, const AirState& air,
                             const DepthParameters& options) {
  const int width = relative.width(), height = relative.height(), longer = std::max(width, height);
  const int radius = std::max(2, static_cast<int>(std::lround(options.window * longer)));
  const auto haze = guided_filter(encoded, darkest_around(relative, options), radius, 1e-3);
  // Pixels with the same optical depth have the same path: a table avoids Newton's method for each.
  const auto coefficients = haze_coefficients(nodes, model, air);
  constexpr int kSteps = 256;  // steps of 1/256 of the deepest, less than 8 bits show
  std::vector<double> metres(kSteps + 1);
  for (int i = 0; i <= kSteps; ++i)
    metres[static_cast<std::size_t>(i)] = i == 0 ? 0.0 : distance_of(coefficients, options.deepest * i / kSteps);
  Image<float> distance_m(width, height);
  for (std::size_t i = 0; i < distance_m.elements().size(); ++i) {
    // There is no more haze than light in the pixel's darkest channel: no object is darker than black.
    const auto& pixel = relative.elements()[i];
    const auto most = static_cast<double>(std::min({haze.elements()[i], pixel.r, pixel.g, pixel.b}));
    const double clear = std::clamp(1.0 - options.kept_haze * std::max(0.0, most), 1e-6, 1.0);
    const double depth = std::clamp(-std::log(std::max(clear, 1e-9)), 1e-4, options.deepest);
    const double place = kSteps * depth / options.deepest;
    const auto step = std::min<std::size_t>(static_cast<std::size_t>(place), kSteps - 1);
    distance_m.elements()[i] =
        static_cast<float>(std::lerp(metres[step], metres[step + 1], place - static_cast<double>(step)));
  }
  return distance_m;
}

glm::dvec3 light_of_thickest_haze(const Image<glm::vec3>& light, const DepthParameters& options) {
  const auto dark = darkest_around(light, options);
  std::vector<std::size_t> order(dark.elements().size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto count = std::max<std::size_t>(1, order.size() / 200);
  std::ranges::nth_element(order, order.begin() + static_cast<std::ptrdiff_t>(count) - 1, [&](auto a, auto b) {
    return dark.elements()[a] > dark.elements()[b] || (!(dark.elements()[a] < dark.elements()[b]) && a < b);
  });
  glm::dvec3 middle{0.0};
  std::vector<float> values(count);
  for (int c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < count; ++i) values[i] = light.elements()[order[i]][c];
    middle[c] = static_cast<double>(median_in_place(values));
  }
  return glm::max(middle, glm::dvec3{1e-6});
}

Image<glm::vec3> light_of_haze(const Image<glm::vec3>& light, const Image<glm::vec3>& encoded,
                               const Image<std::uint8_t>& sky, const DepthParameters& options) {
  const int width = light.width(), height = light.height(), longer = std::max(width, height);
  const glm::vec3 thickest(light_of_thickest_haze(light, options));
  const auto texture = texture_of(encoded, std::max(3, longer / 60 | 1));
  cv::Mat sum(height, width, CV_32FC4);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto share = light.at(x, y) / thickest;
      const bool is_sky = !sky.empty() && sky.at(x, y) != 0 && texture.at(x, y) < kSkyTexture &&
                          std::min({share.r, share.g, share.b}) > kDarkestSky;
      const float weight = is_sky ? 1.0F : kElsewhere;
      const auto value = weight * (is_sky ? light.at(x, y) : thickest);
      sum.at<cv::Vec4f>(y, x) = {value.r, value.g, value.b, weight};
    }
  cv::Mat around;
  cv::GaussianBlur(sum, around, {}, options.window * longer, 0.0, cv::BORDER_REFLECT);
  Image<glm::vec3> found(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto& here = around.at<cv::Vec4f>(y, x);
      found.at(x, y) = glm::vec3(here[0], here[1], here[2]) / here[3];
    }
  return found;
}

AttenuationNodes grey_attenuation_nodes() {
  AttenuationNodes nodes;
  nodes.weight[0] = glm::dvec3{1.0};
  nodes.wavelength_nm.fill(glm::dvec3{550.0});
  return nodes;
}

}  // namespace kasumi

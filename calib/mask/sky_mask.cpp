#include "calib/mask/sky_mask.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

constexpr Radians kZenithCap = from_degrees(40.0);
constexpr double kLeastLight = 0.01;  // linear, of the median around the zenith: pictures at night are useless

// ln of light over the smooth sky: darker pixels are never sky, brighter ones certainly may be.
const double kDark = std::log(0.30), kSky = std::log(0.80);

struct View {
  Image<glm::dvec3> direction;  // zero outside the lens's view
  Image<glm::vec3> gain;        // of light, vignetting undone
};

View view_of(const Camera& camera) {
  View view{Image<glm::dvec3>(camera.width, camera.height, glm::dvec3(0.0)),
            Image<glm::vec3>(camera.width, camera.height, glm::vec3(0.0F))};
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      if (const auto direction = camera.direction_at({x, y})) {
        view.direction.at(x, y) = *direction;
        view.gain.at(x, y) = glm::vec3(glm::dvec3(1.0 / camera.vignetting.at({x, y})));
      }
  return view;
}

bool up(const glm::dvec3& direction) {
  return direction.z > 0.0;
}

std::array<std::array<float, 256>, 3> light_table(const Response& response) {
  std::array<std::array<float, 256>, 3> table{};
  for (std::size_t i = 0; i < 256; ++i) {
    // Half a step keeps the logarithm of black finite.
    const auto light = response.to_light(glm::dvec3(std::max(0.25, static_cast<double>(i)) / 255.0));
    for (int c = 0; c < 3; ++c) table[static_cast<std::size_t>(c)][i] = static_cast<float>(light[c]);
  }
  return table;
}

// Median light of each pixel; 1 around the zenith.
struct Typical {
  Image<glm::vec3> light;
  int pictures = 0;
};

Typical typical_of(std::span<const Image<Rgb8>> pictures, const Camera& camera, const View& view) {
  const auto table = light_table(camera.response);
  const double cap = std::cos(kZenithCap.value);
  std::vector<std::size_t> lit;
  std::vector<float> scale;
  for (std::size_t p = 0; p < pictures.size(); ++p) {
    std::vector<double> zenith;
    for (int y = 0; y < camera.height; y += 2)
      for (int x = 0; x < camera.width; x += 2)
        if (view.direction.at(x, y).z > cap)
          zenith.push_back(static_cast<double>(table[1][pictures[p].at(x, y).g] * view.gain.at(x, y).g));
    if (zenith.empty()) continue;
    const double level = median_in_place(zenith);
    if (level < kLeastLight) continue;
    lit.push_back(p);
    scale.push_back(static_cast<float>(1.0 / level));
  }
  Typical typical{Image<glm::vec3>(camera.width, camera.height, glm::vec3(0.0F)), static_cast<int>(lit.size())};
  std::vector<float> values(lit.size());
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      if (view.gain.at(x, y).g <= 0.0F || lit.empty()) continue;
      for (int c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < lit.size(); ++i)
          values[i] = table[static_cast<std::size_t>(c)][pictures[lit[i]].at(x, y)[c]] * scale[i];
        typical.light.at(x, y)[c] = median_in_place(values) * view.gain.at(x, y)[c];
      }
    }
  return typical;
}

// A smooth sky: ln light as a polynomial of the direction's horizontal part, with terms for the brighter horizon.
constexpr int kTerms = 11;
using Terms = Eigen::Matrix<double, kTerms, 1>;

Terms terms_of(const glm::dvec3& d) {
  const double x = d.x, y = d.y, low = 1.0 / (d.z + 0.15), r = x * x + y * y;
  Terms terms;
  terms << 1.0, x, y, x * x, x * y, y * y, x * r, y * r, low, x * low, y * low;
  return terms;
}

// ln of light over that sky, in green and blue together (leaves and roofs have little blue).
Image<float> against_sky(const Typical& typical, const View& view) {
  const int width = view.direction.width(), height = view.direction.height();
  Image<float> log_light(width, height, 0.0F);
  for (std::size_t i = 0; i < log_light.elements().size(); ++i) {
    const auto& light = typical.light.elements()[i];
    log_light.elements()[i] = 0.5F * (std::log(std::max(light.g, 1e-5F)) + std::log(std::max(light.b, 1e-5F)));
  }
  Terms sky = Terms::Zero();
  Image<float> against(width, height, 0.0F);
  double scatter = 0.5;
  constexpr int kRounds = 12;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, kTerms, kTerms> matrix = Eigen::Matrix<double, kTerms, kTerms>::Identity() * 1e-3;
    Terms pull = Terms::Zero();
    std::vector<double> off;
    // From the zenith outwards, so that obstructions at the horizon do not pass for sky in the first rounds.
    const double lowest = std::cos(from_degrees(std::min(85.0, 40.0 + 8.0 * round)).value);
    for (int y = 0; y < height; y += 3)
      for (int x = 0; x < width; x += 3) {
        const auto& d = view.direction.at(x, y);
        if (d.z < lowest) continue;
        const auto terms = terms_of(d);
        const double left = static_cast<double>(log_light.at(x, y)) - (round == 0 ? 0.0 : sky.dot(terms));
        if (round > 0) off.push_back(left);
        // Obstructions are darker than the sky; clouds and the sun's surroundings are brighter.
        const double u = round == 0 ? 0.0 : left / (kTukeyReach * scatter * (left < 0.0 ? 0.7 : 1.3));
        if (std::abs(u) >= 1.0) continue;
        const double weight = tukey_weight(u) * std::max(d.z, 0.1);
        matrix += weight * terms * terms.transpose();
        pull += weight * terms * static_cast<double>(log_light.at(x, y));
      }
    sky = matrix.ldlt().solve(pull);
    if (round > 0) scatter = std::clamp(robust_sigma(std::move(off)), 0.03, 0.3);
  }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (up(view.direction.at(x, y)))
        against.at(x, y) = log_light.at(x, y) - static_cast<float>(sky.dot(terms_of(view.direction.at(x, y))));
  return against;
}

// The typical picture for people and for GrabCut: encoded, with the brightness over the smooth sky kept in range.
Image<Rgb8> shown(const Typical& typical) {
  Image<Rgb8> picture(typical.light.width(), typical.light.height());
  const auto response = Response::srgb();
  for (std::size_t i = 0; i < picture.elements().size(); ++i) {
    const auto encoded = response.to_encoded(glm::clamp(glm::dvec3(typical.light.elements()[i]) * 0.3, 0.0, 1.0));
    picture.elements()[i] = Rgb8(glm::round(encoded * 255.0));
  }
  return picture;
}

cv::Mat mat_of(Image<std::uint8_t>& image) {
  return {image.height(), image.width(), CV_8UC1, image.elements().data()};
}

// Pieces of sky are at least as large as the moon, obstructions at least a few pixels.
void drop_specks(Image<std::uint8_t>& mask) {
  const int least_sky = std::max(30, mask.width() * mask.height() / 4000), least_hidden = 6;
  for (const bool sky : {true, false}) {
    cv::Mat labels, statistics, centres;
    const cv::Mat of = mat_of(mask) == (sky ? 255 : 0);
    const int count = cv::connectedComponentsWithStats(of, labels, statistics, centres, sky ? 4 : 8, CV_32S);
    for (int y = 0; y < mask.height(); ++y)
      for (int x = 0; x < mask.width(); ++x) {
        const int label = labels.at<int>(y, x);
        if (label > 0 && label < count &&
            statistics.at<int>(label, cv::CC_STAT_AREA) < (sky ? least_sky : least_hidden))
          mask.at(x, y) = sky ? 0 : 255;
      }
  }
}

}  // namespace

Result<SkyMask> find_sky_mask(std::span<const Image<Rgb8>> pictures, const Camera& camera, double margin_px) {
  const auto view = view_of(camera);
  if (std::none_of(view.direction.elements().begin(), view.direction.elements().end(),
                   [](const glm::dvec3& d) { return d.z > std::cos(kZenithCap.value); }))
    return fail(FaultKind::bad_input, "expected a camera that sees the sky above {:.0f} deg of elevation",
                90.0 - to_degrees(kZenithCap));
  const auto typical = typical_of(pictures, camera, view);
  if (typical.pictures == 0)
    return fail(FaultKind::bad_input, "{} pictures, all of the night: expected pictures of a day", pictures.size());
  const auto against = against_sky(typical, view);

  SkyMask found;
  found.pictures = typical.pictures;
  found.typical = shown(typical);
  Image<std::uint8_t> decided(camera.width, camera.height, cv::GC_BGD);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      if (!up(view.direction.at(x, y))) continue;
      const double dark = static_cast<double>(against.at(x, y));
      decided.at(x, y) = dark < kDark                  ? cv::GC_BGD
                         : dark > kSky                 ? cv::GC_FGD
                         : dark > 0.5 * (kDark + kSky) ? cv::GC_PR_FGD
                                                       : cv::GC_PR_BGD;
    }
  const auto is_sky = [](std::uint8_t label) { return label == cv::GC_FGD || label == cv::GC_PR_FGD; };
  const auto before = decided;
  const auto count = [&](int label) { return std::count(before.elements().begin(), before.elements().end(), label); };
  if (count(cv::GC_PR_FGD) + count(cv::GC_PR_BGD) > 0 && count(cv::GC_FGD) > 50 && count(cv::GC_BGD) > 50) {
    auto copy = found.typical.elements();
    const cv::Mat picture(camera.height, camera.width, CV_8UC3, copy.data());
    cv::Mat labels = mat_of(decided), sky, rest;
    cv::setRNGSeed(1);
    try {
      cv::grabCut(picture, labels, {}, sky, rest, 3, cv::GC_INIT_WITH_MASK);
    } catch (const cv::Exception& error) {
      return fail(FaultKind::bad_input, "the pictures cannot be segmented: {}", error.err);
    }
  }

  found.mask = Image<std::uint8_t>(camera.width, camera.height, 0);
  for (std::size_t i = 0; i < found.mask.elements().size(); ++i)
    found.mask.elements()[i] = is_sky(decided.elements()[i]) ? 255 : 0;
  drop_specks(found.mask);
  if (margin_px > 0.0) {
    auto mask = mat_of(found.mask);
    cv::Mat distance;
    cv::distanceTransform(mask, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    mask.setTo(0, distance <= margin_px);
  }

  double all = 0.0, hidden = 0.0, unsure = 0.0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const auto& d = view.direction.at(x, y);
      if (!up(d)) continue;
      // Solid angle of a pixel of an equidistant lens, accurate enough for a share.
      const double zenith = zenith_angle(d).value, weight = zenith > 1e-6 ? std::sin(zenith) / zenith : 1.0;
      all += weight;
      if (found.mask.at(x, y) == 0) hidden += weight;
      const auto label = before.at(x, y);
      if (label == cv::GC_PR_FGD || label == cv::GC_PR_BGD) unsure += weight;
    }
  found.hidden_share = hidden / all;
  found.unsure_share = unsure / all;
  return found;
}

}  // namespace kasumi

// Noise, sun and shade in a photograph, on pictures for which they are known.
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "estimator/photograph/land_around.hpp"
#include "estimator/photograph/picture_noise.hpp"

namespace kasumi {
namespace {

// Box and Muller, so that it is the same on every platform.
class Normal {
 public:
  double operator()() {
    const double a = unit(), b = unit();
    return std::sqrt(-2.0 * std::log(a)) * std::cos(6.283185307179586 * b);
  }
  double unit() { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53; }

 private:
  std::mt19937_64 engine_{7};
};

// A slope on the left, texture of five pixels on the right, as 8 bits.
Image<glm::vec3> noisy(double sigma, bool with_noise) {
  Image<glm::vec3> picture(120, 80);
  Normal normal;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      for (int c = 0; c < 3; ++c) {
        const double clean =
            x < 60 ? 0.3 + 0.002 * x + 0.001 * y : 0.5 + 0.2 * std::sin(1.2566 * x) * std::sin(1.2566 * y);
        picture.at(x, y)[c] =
            static_cast<float>(std::round(255.0 * (clean + (with_noise ? sigma * normal() : 0.0))) / 255.0);
      }
  return picture;
}

TEST(PictureNoise, IsMeasuredWhateverIsInThePicture) {
  for (const double sigma : {1.3, 3.0, 8.0}) {
    const auto found = 255.0 * noise_of(noisy(sigma / 255.0, true));
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(found[k], sigma, 0.15 * sigma) << "direction " << k;
  }
}

TEST(PictureNoise, IsZeroInDrawnPictures) {
  Image<glm::vec3> drawn(64, 64, glm::vec3(0.5F));
  for (int y = 0; y < 64; ++y)
    for (int x = 20; x < 40; ++x) drawn.at(x, y) = {0.1F, 0.9F, 0.3F};
  EXPECT_EQ(noise_of(drawn), glm::dvec3{0.0});
  EXPECT_EQ(without_noise(drawn, glm::dvec3{0.0}).elements(), drawn.elements());
}

TEST(PictureNoise, IsRemovedFromFlatPartsAndEdgesAreKept) {
  const double sigma = 4.0 / 255.0;
  const auto truth = noisy(sigma, false), taken = noisy(sigma, true);
  const auto clean = without_noise(taken, noise_of(taken));
  const auto off = [&](const Image<glm::vec3>& picture, int from, int to) {
    double sum = 0.0;
    for (int y = 4; y < 76; ++y)
      for (int x = from; x < to; ++x) {
        const auto d = glm::dvec3(picture.at(x, y) - truth.at(x, y));
        sum += glm::dot(d, d);
      }
    return std::sqrt(sum);
  };
  EXPECT_LT(off(clean, 4, 54), 0.45 * off(taken, 4, 54)) << "slope";
  EXPECT_LT(off(clean, 66, 116), off(taken, 66, 116)) << "texture";
  EXPECT_LT(off(clean, 56, 64), off(taken, 56, 64)) << "border between the two";
}

AttenuationNodes grey_nodes() {
  AttenuationNodes nodes;
  for (std::size_t i = 0; i < nodes.weight.size(); ++i) {
    nodes.weight[i] = glm::dvec3{i == 0 ? 1.0 : 0.0};
    nodes.wavelength_nm[i] = glm::dvec3{550.0};
  }
  return nodes;
}

const RetargetAir kHazy{Turbidity{8.0}, {1, 1, glm::vec3{0.5F}}}, kNoAir{std::nullopt, {1, 1, glm::vec3{0.5F}}};

// A wall with its haze removed: its contrast grows fivefold, its noise does not.
TEST(Retarget, DoesNotAmplifyNoise) {
  const auto nodes = grey_nodes();
  const double per_m = rayleigh_per_m(ScatteringModel::morales2017, 550.0) +
                       mie_per_m(ScatteringModel::morales2017, 550.0, Turbidity{8.0});
  const RetargetGeometry depth{Image<float>(80, 80, static_cast<float>(std::log(5.0) / per_m)), {}, 0.0};
  const double sigma = 0.01, wall = 0.45;  // 0.5 + 5 (0.45 - 0.5) = 0.25 without haze
  Normal normal;
  Image<glm::vec3> light(80, 80);
  for (auto& pixel : light.elements())
    for (int c = 0; c < 3; ++c) pixel[c] = static_cast<float>(wall + sigma * normal());
  RetargetHints parts;
  parts.clean = without_noise(light, noise_of(light));
  const auto varies = [](const Image<glm::vec3>& picture) {
    double sum = 0.0, squares = 0.0;
    for (const auto& pixel : picture.elements())
      for (int c = 0; c < 3; ++c) {
        sum += static_cast<double>(pixel[c]);
        squares += static_cast<double>(pixel[c]) * static_cast<double>(pixel[c]);
      }
    const double count = 3.0 * static_cast<double>(picture.elements().size()), mean = sum / count;
    return std::pair{mean, std::sqrt(squares / count - mean * mean)};
  };
  const auto plain = varies(retarget(light, depth, kHazy, kNoAir, nodes).light);
  const auto made = varies(retarget(light, depth, kHazy, kNoAir, nodes, {}, parts).light);
  EXPECT_NEAR(plain.second, 5.0 * sigma, 0.1 * sigma);
  // Photon noise at the resulting light, plus what remains in the windows' means.
  EXPECT_LT(made.second, 1.5 * sigma * std::sqrt(0.25 / wall));
  EXPECT_NEAR(made.first, 0.25, 0.002);
}

// Stripes a pixel wide, seen through haze: half of the land in the sun, half in its shade.
struct Stripes {
  glm::dvec3 sun{0.20, 0.17, 0.13}, sky{0.18, 0.20, 0.24};  // of the light from infinity, under the source's air
  Relighting relit{glm::dvec3{0.0}, glm::dvec3{0.8, 0.75, 0.7}, glm::dvec3{2.0, 1.9, 1.8}};
  RetargetGeometry depth{Image<float>(101, 61, 1500.0F), {}, 0.0};
  RetargetAir source{Turbidity{2.0}, {1, 1, glm::vec3{0.5F, 0.55F, 0.6F}}},
      target{Turbidity{5.0}, {1, 1, glm::vec3{0.6F, 0.62F, 0.63F}}};

  Stripes() { relit.land = (0.5 * relit.sun * sun + relit.shade * sky) / (0.5 * sun + sky); }
  static bool lit(int x) { return x % 2 == 0; }
  glm::dvec3 surface(int x, bool then) const {
    return (then ? relit.shade : glm::dvec3{1.0}) * sky +
           (lit(x) ? (then ? relit.sun : glm::dvec3{1.0}) * sun : glm::dvec3{0.0});
  }
  Image<glm::vec3> seen(const AttenuationNodes& nodes, bool then) const {
    const auto& air = then ? target : source;
    Image<glm::vec3> light(depth.distance_m.width(), depth.distance_m.height());
    const auto left =
        attenuation(haze_coefficients(nodes, ScatteringModel::morales2017, *air.state), optical_path(0.0, 0.0, 1500.0));
    for (int y = 0; y < light.height(); ++y)
      for (int x = 0; x < light.width(); ++x)
        light.at(x, y) = glm::dvec3(air.of(x, y)) * (1.0 + left * (surface(x, then) - 1.0));
    return light;
  }
};

TEST(Retarget, ReducesTheContrastOfSunAndShadeByHalfOfTheTrueChange) {
  const Stripes stripes;
  const auto nodes = attenuation_nodes(spectral_measure(generic_sensitivity()));
  const auto light = stripes.seen(nodes, false), truth = stripes.seen(nodes, true);
  RetargetLimits options;
  options.relit = stripes.relit;
  const auto one = retarget(light, stripes.depth, stripes.source, stripes.target, nodes, options).light;
  RetargetHints parts;
  parts.land_around = land_around(light, stripes.depth, stripes.source, nodes);
  const auto made = retarget(light, stripes.depth, stripes.source, stripes.target, nodes, options, parts).light;
  for (int x = 40; x < 60; ++x)
    for (int c = 0; c < 3; ++c) {
      const float off = made.at(x, 30)[c] - truth.at(x, 30)[c], off_one = one.at(x, 30)[c] - truth.at(x, 30)[c];
      ASSERT_GT(std::abs(off_one), 0.004F) << "otherwise there was nothing to correct";
      EXPECT_NEAR(off / off_one, 0.5F, 0.2F) << "stripe " << x << ", channel " << c;
    }
}

TEST(Retarget, TreatsLandWithoutContrastAsOneSurface) {
  const auto nodes = attenuation_nodes(spectral_measure(generic_sensitivity()));
  Stripes stripes;
  const Image<glm::vec3> light(101, 61, glm::vec3{0.3F, 0.32F, 0.35F});
  RetargetLimits options;
  options.relit = stripes.relit;
  RetargetHints parts{light, land_around(light, stripes.depth, stripes.source, nodes)};
  const auto one = retarget(light, stripes.depth, stripes.source, stripes.target, nodes, options).light;
  const auto made = retarget(light, stripes.depth, stripes.source, stripes.target, nodes, options, parts).light;
  for (std::size_t i = 0; i < one.elements().size(); ++i)
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(made.elements()[i][c], one.elements()[i][c], 1e-5F);
}

// Whatever the picture, no surface's light may grow more than in shade nor less than in the sun.
TEST(Retarget, NeverExceedsSunAndShadeThemselves) {
  const auto nodes = grey_nodes();
  Stripes stripes;
  Normal random;
  Image<glm::vec3> light(101, 61);
  for (auto& pixel : light.elements())
    for (int c = 0; c < 3; ++c) pixel[c] = static_cast<float>(random.unit() * random.unit());
  RetargetLimits options;
  options.relit = stripes.relit;
  RetargetHints parts;
  parts.land_around = land_around(light, stripes.depth, kNoAir, nodes);
  const auto made = retarget(light, stripes.depth, kNoAir, kNoAir, nodes, options, parts).light;
  for (std::size_t i = 0; i < light.elements().size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double was = static_cast<double>(light.elements()[i][c]), is = static_cast<double>(made.elements()[i][c]);
      ASSERT_GE(is, stripes.relit.sun[c] * was - 1e-6);
      ASSERT_LE(is, stripes.relit.shade[c] * was + 1e-6);
    }
}

TEST(Retarget, KeepsThePictureAndItsNoiseWhenNothingChanges) {
  const auto nodes = attenuation_nodes(spectral_measure(generic_sensitivity()));
  const auto light = noisy(0.01, true);
  RetargetGeometry depth{Image<float>(120, 80, 2500.0F), {}, 0.0};
  for (int x = 0; x < 120; ++x) depth.distance_m.at(x, 0) = 0.0F;
  const RetargetHints parts{without_noise(light, noise_of(light)), land_around(light, depth, kHazy, nodes)};
  const auto made = retarget(light, depth, kHazy, kHazy, nodes, {}, parts).light;
  for (std::size_t i = 0; i < light.elements().size(); ++i)
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(made.elements()[i][c], light.elements()[i][c], 2e-6F);
}

// A white house in front of far dark hills, both in haze: each has its own surroundings.
TEST(LandAround, DoesNotMixNearWithFar) {
  const auto nodes = grey_nodes();
  const RetargetAir air{Turbidity{2.0}, {1, 1, glm::vec3{0.5F}}};
  RetargetGeometry depth{Image<float>(120, 80, 6000.0F), {}, 0.0};
  Image<glm::vec3> light(120, 80);
  const auto haze = haze_coefficients(nodes, ScatteringModel::morales2017, Turbidity{2.0});
  const double house = 0.9, hills = 0.15;
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 120; ++x) {
      if (x < 60) depth.distance_m.at(x, y) = 300.0F;
      const auto left = attenuation(haze, depth.path(x, y)).g;
      light.at(x, y) = glm::vec3(glm::dvec3(0.5 * (1.0 + left * ((x < 60 ? house : hills) - 1.0))));
    }
  const auto around = land_around(light, depth, air, nodes);
  for (int x = 1; x < 119; ++x) {
    const double truth = x < 60 ? house : hills;
    EXPECT_NEAR(static_cast<double>(around.at(x, 40).g), truth, x == 59 || x == 60 ? 0.08 : 0.05) << "column " << x;
  }
}

// Sun 25 deg high: thicker haze shifts light from the sun to the sky, and level ground receives both.
TEST(Relighting, IsBetweenThatOfTheSunAndThatOfTheSky) {
  const Camera camera;
  const auto sun = direction_from(from_degrees(65.0), from_degrees(110.0));
  const Direction north{0.0, 1.0, 0.0};
  const auto thicker = relighting(camera, Turbidity{1.9}, Turbidity{4.36}, sun, north, 300.0);
  const auto same = relighting(camera, Turbidity{3.0}, Turbidity{3.0}, sun, north, 300.0);
  for (int c = 0; c < 3; ++c) {
    EXPECT_LT(thicker.sun[c], thicker.land[c]);
    EXPECT_LT(thicker.land[c], thicker.shade[c]);
    EXPECT_DOUBLE_EQ(same.land[c], 1.0);
    EXPECT_DOUBLE_EQ(same.sun[c], 1.0);
    EXPECT_DOUBLE_EQ(same.shade[c], 1.0);
  }
}

}  // namespace
}  // namespace kasumi

// Clear air told from cloud by its own form, and what is read of it.
#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/colour/colorimetry.hpp"
#include "estimator/turbidity/clear_air.hpp"
#include "estimator/turbidity/cloud_mask.hpp"
#include "estimator/turbidity/picture_readings.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi {
namespace {

constexpr int kPixels = 300;

// A picture, and its clear air by the form that begins with what Preetham's sky takes for clear.
struct Marked {
  explicit Marked(const test::SyntheticSky& description)
      : camera(test::upward_camera(kPixels)),
        rendered(test::render(description, camera)),
        picture(*sky_picture(rendered.encoded, 1.0 / 255.0, camera)),
        geometry(sky_geometry(camera, picture)),
        light(sky_light(picture, geometry, rendered.sun, {})),
        by_model(light),
        by_form(light) {
    mask_clouds(by_model, geometry, rendered.sun);
    air = mask_all_but_clear_air(by_form, looks_of(picture, camera, light), geometry, by_model.use, rendered.sun);
  }
  struct Shares {
    double cloud_kept = 0.0, clear_kept = 0.0;  // of the true clouds; of the true clear sky: called clear
  };
  Shares shares(const Image<PixelUse>& use) const {
    double cloud = 0.0, cloud_kept = 0.0, clear = 0.0, clear_kept = 0.0;
    for (int y = 0; y < kPixels; ++y)
      for (int x = 0; x < kPixels; ++x) {
        if (light.use.at(x, y) != PixelUse::clear) continue;
        const auto angle = static_cast<double>(geometry.solid_angle.at(x, y));
        const bool is_cloud = rendered.cloud.at(x, y) != 0;
        (is_cloud ? cloud : clear) += angle;
        if (use.at(x, y) == PixelUse::clear) (is_cloud ? cloud_kept : clear_kept) += angle;
      }
    return {cloud > 0.0 ? cloud_kept / cloud : 0.0, clear > 0.0 ? clear_kept / clear : 0.0};
  }
  Camera camera;
  test::RenderedSky rendered;
  SkyPicture picture;
  ElementGeometry geometry;
  ElementLight light, by_model, by_form;
  ClearAir air;
};

// Dust: a pale sky with an aureole that no turbidity has. XYZ, kcd/m2.
glm::dvec3 pale_aureole(const Direction& view) {
  const Direction sun = direction_from(from_degrees(58.4), from_degrees(-179.4));
  const double gamma = angle_between(view, sun).value;
  const double molecules = 2.0 * (1.0 + std::pow(std::cos(gamma), 2)) / (view.z + 0.25);
  const double dust = 1.5 * (1.0 + 12.0 * std::exp(-5.0 * gamma)) / (view.z + 0.2);
  return molecules * glm::dvec3{0.75, 0.85, 1.5} + dust * glm::dvec3{0.97, 1.0, 0.9};
}

TEST(ClearAir, KeepsAllOfAClearSkyWhateverItsAerosol) {
  for (const Marked& sky : {Marked({.turbidity = 2.2, .noise = 0.005}), Marked({.turbidity = 9.0, .noise = 0.005}),
                            Marked({.noise = 0.005, .clear = pale_aureole})}) {
    ASSERT_TRUE(sky.air.found);
    EXPECT_GT(sky.shares(sky.by_form.use).clear_kept, 0.99);
    EXPECT_GT(sky.air.clear_fraction, 0.99);
    EXPECT_GT(sky.air.agreement, 1.0);
  }
}

TEST(ClearAir, IsNoWorseThanTheModelsMaskOnTheModelsOwnSky) {
  double form = 0.0, model = 0.0;
  for (const double cover : {0.3, 0.5})
    for (const double turbidity : {2.5, 6.0})
      for (const std::uint64_t seed : {41u, 42u}) {
        const Marked sky({.turbidity = turbidity, .cloud_cover = cover, .cloud_seed = seed, .noise = 0.005});
        const Marked::Shares by_form = sky.shares(sky.by_form.use), by_model = sky.shares(sky.by_model.use);
        form += by_form.cloud_kept / 8.0;
        model += by_model.cloud_kept / 8.0;
        EXPECT_GT(by_form.clear_kept, by_model.clear_kept - 0.1) << cover << " " << turbidity << " " << seed;
      }
  std::printf("clouds taken for clear air: %.2f %% by the form, %.2f %% by Preetham's sky\n", 100 * form, 100 * model);
  EXPECT_LE(form, model + 0.002);
}

TEST(ClearAir, KeepsAnAureoleBetweenCloudsThatNoModelHas) {
  double form = 0.0, model = 0.0;
  for (const std::uint64_t seed : {51u, 52u, 53u, 54u}) {
    const Marked sky({.cloud_cover = 0.3, .cloud_seed = seed, .clear = pale_aureole});
    EXPECT_LT(sky.shares(sky.by_form.use).cloud_kept, 0.02) << seed;
    form += sky.shares(sky.by_form.use).clear_kept / 4.0;
    model += sky.shares(sky.by_model.use).clear_kept / 4.0;
  }
  std::printf("clear air kept: %.1f %% by the form, %.1f %% by Preetham's sky\n", 100 * form, 100 * model);
  EXPECT_GT(form, 0.75);
}

// Between saturated elements of a cloud's bright top single ones are not: they look smooth, since nothing is known
// around them.
TEST(ClearAir, ElementsAloneAmongSaturatedOnesAreNoClearAir) {
  Camera camera = test::upward_camera(kPixels);
  test::RenderedSky rendered = test::render({.turbidity = 5.0}, camera);
  for (int y = 60; y < 100; ++y)
    for (int x = 140; x < 180; ++x) rendered.encoded.at(x, y) = glm::vec3{(x + y) % 5 == 0 ? 0.95f : 1.0f};
  const SkyPicture picture = *sky_picture(rendered.encoded, 1.0 / 255.0, camera);
  const ElementGeometry geometry = sky_geometry(camera, picture);
  ElementLight light = sky_light(picture, geometry, rendered.sun, {});
  const Image<PixelUse> begin = light.use;
  mask_all_but_clear_air(light, looks_of(picture, camera, light), geometry, begin, rendered.sun);
  for (int y = 62; y < 98; ++y)
    for (int x = 142; x < 178; ++x) ASSERT_NE(light.use.at(x, y), PixelUse::clear) << x << " " << y;
}

TEST(ElementReadings, AreTheSkysLightWithTheNoiseThatIsInIt) {
  const Marked sky({.turbidity = 3.0, .noise = 0.005});
  std::mt19937_64 random(1);
  const auto elements = draw_elements(sky.light, sky.geometry, 300, random);
  const ElementReadings read =
      readings_at(elements, sky.picture, sky.geometry, sky.light, sky.camera, sky.rendered.sun, {});
  ASSERT_GT(read.readings.size(), 290u);
  const PreethamSky model(Turbidity{3.0}, sky.rendered.sun);
  const glm::dmat3 to_xyz = glm::inverse(xyz_to_linear_srgb());
  double mean = 0.0, square = 0.0, stated = 0.0;
  for (const SkyReading& r : read.readings) {
    const double off = std::log((to_xyz * r.light).y / model.relative_xyz(r.direction).y);
    mean += off / static_cast<double>(read.readings.size());
    square += off * off / static_cast<double>(read.readings.size());
    stated += r.sigma.g * r.sigma.g / static_cast<double>(read.readings.size());
    EXPECT_LE(r.off_axis, 1.0);
  }
  const double scatter = std::sqrt(square - mean * mean);
  std::printf("readings scatter by %.4f, stated %.4f\n", scatter, std::sqrt(stated));
  EXPECT_LT(scatter, 0.01);
  EXPECT_GT(std::sqrt(stated), 0.4 * scatter);
  EXPECT_LT(std::sqrt(stated), 2.5 * scatter);
}

TEST(ElementReadings, ACameraIsDoubtedLessForWhatWasMeasuredOfIt) {
  Camera camera = test::upward_camera(kPixels);
  EXPECT_DOUBLE_EQ(doubt_of(camera).white_balance, 0.1);
  EXPECT_DOUBLE_EQ(doubt_of(camera).vignetting, 0.15);
  camera.vignetting.coefficients = {-0.2, 0.0, 0.0};
  EXPECT_DOUBLE_EQ(doubt_of(camera).vignetting, 0.02);
  camera.colour_space = Camera::ColourSpace::sensor;
  EXPECT_DOUBLE_EQ(doubt_of(camera).white_balance, 0.1);  // still the generic sensitivity
  camera.sensitivity.name = "measured";
  EXPECT_DOUBLE_EQ(doubt_of(camera).white_balance, 0.02);
}

TEST(EveryModel, FollowsPreethamsSkyWhereItIsHis) {
  const Marked sky({.turbidity = 3.3, .cloud_cover = 0.3, .cloud_seed = 5});
  EstimateParameters options;
  options.sky.every_model = true;
  const TurbidityObservation seen = SkyObserver(sky.camera).observe(sky.picture, sky.rendered.sun, options);
  ASSERT_TRUE(seen.estimate.usable) << seen.estimate.reason;
  EXPECT_NEAR(seen.estimate.turbidity.value, 3.3, 0.02);
  ASSERT_TRUE(seen.estimate.found);
  EXPECT_GT(seen.estimate.found->papers_share, 0.5);
  EXPECT_EQ(seen.sky.model, DaylightModel::preetham);
  EXPECT_FALSE(seen.sky.aerosol);
  ASSERT_FALSE(seen.estimate.models.empty());
  EXPECT_EQ(seen.estimate.models.front().name, "preetham");
  EXPECT_EQ(seen.samples.size(), seen.inlier.size());
  EXPECT_EQ(seen.samples.size(), seen.elements.size());
}

TEST(EveryModel, OnePreethamsModelAloneIsAskedAsEver) {
  const Marked sky({.turbidity = 4.1, .cloud_cover = 0.2, .cloud_seed = 6});
  const TurbidityObservation alone = SkyObserver(sky.camera).observe(sky.picture, sky.rendered.sun);
  EXPECT_FALSE(alone.estimate.found);
  EXPECT_TRUE(alone.estimate.models.empty());
}

}  // namespace
}  // namespace kasumi

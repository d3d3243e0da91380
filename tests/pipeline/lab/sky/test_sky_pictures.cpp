// Skies drawn by the GPU against the CPU's reference, and properties that U requires.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "estimator/sky/dome.hpp"
#include "pipeline/lab/bench/gles.hpp"
#include "pipeline/lab/sky/dome_drawing.hpp"
#include "pipeline/lab/sky/sky_comparison.hpp"
#include "pipeline/lab/sky/sky_window.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

Viewpoint small_camera(PanoramaProjection projection) {
  Viewpoint camera;
  camera.projection = projection;
  camera.width = projection == PanoramaProjection::fisheye ? 240 : 320;
  camera.height = projection == PanoramaProjection::equirectangular ? 160 : 240;
  return camera;
}

DomeRequest sky_under(double turbidity, double sun_zenith_deg, double altitude_m = 0.0) {
  DomeRequest request;
  request.turbidity = {turbidity};
  request.altitude_m = altitude_m;
  request.sun = direction_from(from_degrees(sun_zenith_deg), from_degrees(8.0));
  return request;
}

double psnr_db(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.elements().size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double off = static_cast<double>(a.elements()[i][c]) - static_cast<double>(b.elements()[i][c]);
      sum += off * off / (3.0 * static_cast<double>(a.elements().size()));
    }
  return 10.0 * std::log10(255.0 * 255.0 / std::max(sum, 1e-9));
}

class DrawnSkies : public testing::Test {
 protected:
  void SetUp() override {
    auto gpu = DomeDrawing::by_gpu();
    if (!gpu) GTEST_SKIP() << gpu.error().message;
    gpu_.emplace(std::move(*gpu));
  }
  Image<Rgb8> by_gpu(const Viewpoint& camera, const DomeRequest& sky, const LandAround* land = nullptr) {
    auto drawn = gpu_->draw(view_of(camera), sky_scene(sky), land);
    EXPECT_TRUE(drawn.has_value()) << (drawn ? "" : drawn.error().message);
    return drawn ? std::move(*drawn) : Image<Rgb8>(camera.width, camera.height);
  }
  static Image<Rgb8> by_cpu(const Viewpoint& camera, const DomeRequest& sky, const LandAround* land = nullptr) {
    return DomeDrawing::by_cpu().draw(view_of(camera), sky_scene(sky), land).value();
  }
  std::optional<DomeDrawing> gpu_;
};

TEST_F(DrawnSkies, MatchTheCpuTo50Decibels) {
  for (const auto projection :
       {PanoramaProjection::perspective, PanoramaProjection::fisheye, PanoramaProjection::equirectangular})
    for (const double sun : {5.0, 50.0, 80.0, 90.0})
      for (const double altitude_m : {0.0, 3000.0, 20000.0}) {
        const Viewpoint camera = small_camera(projection);
        const DomeRequest sky = sky_under(altitude_m > 0.0 ? 2.0 : 5.0, sun, altitude_m);
        EXPECT_GE(psnr_db(by_gpu(camera, sky), by_cpu(camera, sky)), 50.0)
            << name_of(projection) << ", sun at " << sun << " deg, " << altitude_m << " m";
      }
}

TEST_F(DrawnSkies, OfTheEarlierModelsMatchTheCpuTo50Decibels) {
  using enum SkyKind;
  for (const SkyKind kind : {preetham1999, hoffman_preetham2002, nielsen2003}) {
    DomeRequest sky = sky_under(3.0, 60.0);
    sky.kind = kind;
    const Viewpoint camera = small_camera(PanoramaProjection::perspective);
    EXPECT_GE(psnr_db(by_gpu(camera, sky), by_cpu(camera, sky)), 50.0) << name_of(kind);
  }
}

TEST_F(DrawnSkies, WithLandMatchTheCpuAwayFromEdges) {
  const Viewpoint camera = small_camera(PanoramaProjection::perspective);
  for (const double altitude_m : {40.0, 3000.0}) {
    const DomeRequest sky = sky_under(2.5, 60.0, altitude_m);
    const auto land = must(land_for(camera, altitude_m, true));
    const auto drawn = by_gpu(camera, sky, &*land), expected = by_cpu(camera, sky, &*land);
    // An edge of the land may differ by a pixel.
    int far_off = 0;
    double sum = 0.0;
    for (std::size_t i = 0; i < drawn.elements().size(); ++i) {
      const double off = glm::length(glm::dvec3(drawn.elements()[i]) - glm::dvec3(expected.elements()[i]));
      far_off += off > 12.0 ? 1 : 0;
      sum += off;
    }
    const double count = static_cast<double>(drawn.elements().size());
    EXPECT_LT(far_off / count, 0.02) << altitude_m << " m";
    EXPECT_LT(sum / count, 1.5) << "steps of 255, " << altitude_m << " m";
  }
}

TEST_F(DrawnSkies, AreDitheredAgainstBanding) {
  // The mean over a dither pattern's 8 x 8 pixels resolves values between two steps.
  const Viewpoint camera = small_camera(PanoramaProjection::perspective);
  DomeRequest sky = sky_under(2.0, 40.0);
  sky.sun = direction_from(from_degrees(40.0), from_degrees(180.0));  // behind
  const auto drawn = by_gpu(camera, sky);
  const DomeScene scene = sky_scene(sky);
  const DomePainter painter(scene);
  const PanoramaView view = view_of(camera);
  double worst = 0.0;
  for (int by = 0; by < 160; by += 8)
    for (int bx = 0; bx < 320; bx += 8) {
      glm::dvec3 mean(0.0), expected(0.0);
      for (int y = by; y < by + 8; ++y)
        for (int x = bx; x < bx + 8; ++x) {
          mean += glm::dvec3(drawn.at(x, y)) / 64.0;
          expected += 255.0 * sky_shown_at(view, painter, 0.0, nullptr, {x, y}) / 64.0;
        }
      const glm::dvec3 off = glm::abs(mean - expected);
      worst = std::max({worst, off.x, off.y, off.z});
    }
  EXPECT_LT(worst, 0.7) << "steps of 255";  // the mesh may be half a step off, and more between its lines' crossings
}

double luminance_at(const DomePainter& painter, double zenith_deg, double azimuth_deg) {
  return sky_text::luminance_of(painter.sky(direction_from(from_degrees(zenith_deg), from_degrees(azimuth_deg))));
}

TEST(TheDome, DarkensOverheadAndStaysBrightAtTheHorizonOnTheWayUp) {
  // U Fig 5.4.
  double zenith_before = 1e9;
  for (const double altitude_m : {0.0, 5000.0, 10000.0}) {
    const DomePainter painter(sky_scene(sky_under(2.0, 45.0, altitude_m)));
    const double zenith = luminance_at(painter, 0.0, 0.0), horizon = luminance_at(painter, 89.0, 188.0);
    EXPECT_LT(zenith, 0.75 * zenith_before) << altitude_m << " m";
    EXPECT_GT(horizon, 4000.0) << "cd/m2, " << altitude_m << " m";
    EXPECT_GT(horizon, 2.0 * zenith) << altitude_m << " m";
    zenith_before = zenith;
  }
}

TEST(TheDome, HasNoBandOppositeTheSun) {
  // Along circles around the zenith it is darkest at about a right angle to the sun, as skies are, and brightens evenly
  // from there.
  for (const double zenith_deg : {60.0, 75.0, 85.0}) {
    const DomePainter painter(sky_scene(sky_under(2.0, zenith_deg)));
    const auto along = [&](double degrees) { return luminance_at(painter, zenith_deg, 8.0 + degrees); };
    double darkest = 0.0;
    for (double degrees = 0.0; degrees <= 180.0; degrees += 1.0)
      if (along(degrees) < along(darkest)) darkest = degrees;
    EXPECT_GT(darkest, 80.0);
    EXPECT_LT(darkest, 130.0);
    for (double degrees = darkest; degrees < 180.0; degrees += 1.0)
      EXPECT_GE(along(degrees + 1.0), 0.999 * along(degrees)) << zenith_deg << " deg, " << degrees;
  }
}

TEST(Nielsen, HalvesTheBandOfHoffmanAndPreetham) {
  // U Fig 5.7 (U Eq 2.29).
  const auto sun = direction_from(from_degrees(75.0), from_degrees(180.0));
  const auto before = flaws_of(SkyKind::hoffman_preetham2002, {1.7}, sun, sun);
  const auto after = flaws_of(SkyKind::nielsen2003, {1.7}, sun, sun);
  EXPECT_LT(before.band, 0.9);
  EXPECT_LT(1.0 - after.band, 0.5 * (1.0 - before.band));
}

TEST(TheDome, IsBlueOverheadUnderALowSun) {
  const auto low = direction_from(from_degrees(88.0), from_degrees(180.0));
  const auto ours = flaws_of(SkyKind::dome, {2.0}, low, low);
  EXPECT_LT(ours.zenith_x, 0.28);
  EXPECT_LT(ours.zenith_y, 0.29);
  const auto theirs = flaws_of(SkyKind::nielsen2003, {2.0}, low, low);
  EXPECT_GT(theirs.zenith_x, ours.zenith_x + 0.05);
}

TEST(MadeLand, IsHitFromAboveWhereItsPointsAre) {
  Viewpoint camera = small_camera(PanoramaProjection::perspective);
  camera.pitch_deg = -20.0;
  const auto land = must(land_for(camera, 3000.0, true));
  const LandRayCaster sight(land->land, land->from, land->to);
  // Down to the plain: the ray's slope determines where it hits.
  const auto hit = must(sight.along(direction_from(from_degrees(120.0), from_degrees(0.0)), 3000.0));
  const double ground = synthetic_height_m({hit->place.x, hit->place.y});
  EXPECT_NEAR(hit->altitude_m, ground, 8.0);
  EXPECT_NEAR(std::hypot(hit->place.x, hit->place.y), (3000.0 - ground) * std::tan(from_degrees(60.0).value), 20.0);
  EXPECT_FALSE(sight.along({0.0, 0.0, 1.0}, 3000.0).has_value());
}

// Share of the picture that is white in all channels.
double burnt_out(const Image<Rgb8>& picture) {
  const auto white = std::ranges::count_if(picture.elements(), [](const Rgb8& pixel) {
    return std::min({pixel.r, pixel.g, pixel.b}) >= 250;
  });
  return static_cast<double>(white) / static_cast<double>(picture.elements().size());
}

TEST(SeenScene, HasASunWithinItsGlowAndNoWhiteHalves) {
  Viewpoint camera = small_camera(PanoramaProjection::perspective);
  for (const double turbidity : {2.0, 3.0, 6.0, 9.0})
    for (const double zenith_deg : {65.0, 75.0, 85.0}) {
      if (turbidity > 5.0 && zenith_deg > 80.0) continue;  // haze hides it
      const DomeRequest sky = standing_on_land(camera, sky_under(turbidity, zenith_deg));
      const auto picture =
          DomeDrawing::by_cpu().draw(view_of(camera), scene_seen(camera, sky, nullptr), nullptr).value();
      EXPECT_LT(burnt_out(picture), 0.01) << "T " << turbidity << ", sun " << zenith_deg << " deg from the zenith";
      const auto sun = pixel_of(view_of(camera), sky.sun);
      const auto at = [&](double off) { return picture.at(static_cast<int>(sun->x + off), static_cast<int>(sun->y)); };
      EXPECT_GE(at(0.0).g, 245) << "the disc, T " << turbidity << ", " << zenith_deg;
      EXPECT_GT(at(0.0).g, at(25.0).g);
      EXPECT_GT(at(25.0).g, at(75.0).g);
    }
}

TEST(SeenScene, MetersOnItsOwnPictureAndTakesAGivenExposure) {
  Viewpoint camera = small_camera(PanoramaProjection::perspective);
  for (const double heading_deg : {8.0, 188.0}) {  // into the sun and away from it
    camera.heading_deg = heading_deg;
    const DomeRequest sky = standing_on_land(camera, sky_under(4.0, 70.0));
    const auto picture = DomeDrawing::by_cpu().draw(view_of(camera), scene_seen(camera, sky, nullptr), nullptr).value();
    double sum = 0.0;
    for (const Rgb8& pixel : picture.elements()) sum += pixel.g;
    EXPECT_NEAR(sum / static_cast<double>(picture.elements().size()), 185.0, 20.0) << heading_deg;
  }
  DomeRequest given = sky_under(4.0, 70.0);
  given.exposure = 3e-5;
  EXPECT_EQ(scene_seen(camera, given, nullptr).exposure, 3e-5);
}

TEST(SeenScene, HasNoGlareOfASunBehindMountains) {
  Viewpoint camera = small_camera(PanoramaProjection::perspective);
  DomeRequest sky = standing_on_land(camera, sky_under(2.0, 89.0));
  const auto land = must(land_for(camera, sky.altitude_m, true));
  EXPECT_EQ(scene_seen(camera, sky, &*land).sun_luminance, glm::dvec3(0.0));
  EXPECT_GT(scene_seen(camera, sky, nullptr).sun_luminance.g, 0.0);
}

TEST(MadeLand, FadesIntoTheSkyAtTheHorizonInHaze) {
  Viewpoint camera = small_camera(PanoramaProjection::perspective);
  camera.pitch_deg = 2.0;
  for (const double azimuth_deg : {8.0, 98.0, 188.0}) {
    camera.heading_deg = azimuth_deg;
    const DomeRequest sky = standing_on_land(camera, sky_under(6.0, 60.0));
    const auto land = land_for(camera, sky.altitude_m, false);
    const LandRayCaster sight(land->land, land->from, land->to);
    const DomeScene scene = scene_seen(camera, sky, &*land);
    const PanoramaView view = view_of(camera);
    const DomePainter painter(scene);
    for (int x = 20; x < camera.width; x += 40)
      for (int y = 1; y < camera.height; ++y) {
        const auto hit = sight.along(direction_of(view, {x, y}), scene.altitude_m);
        if (!hit || glm::length(hit->place) > 40e3) continue;
        if (glm::length(hit->place) < 12e3) break;
        const auto shown = [&](int row) {
          return 255.0 * sky_shown_at(view, painter, scene.altitude_m, &sight, {x, row});
        };
        EXPECT_LT(glm::length(shown(y) - shown(y - 1)), 9.0) << azimuth_deg << " deg, column " << x;
        break;
      }
  }
}

TEST(SkyWindow, PutsTheSunWhereThePointerIs) {
  SkyWindowState shown;
  shown.camera = small_camera(PanoramaProjection::perspective);
  shown.sky = sky_under(2.5, 45.0);
  EXPECT_FALSE(shown.apply({false, 100.0, 60.0, ""}));
  EXPECT_TRUE(shown.apply({true, 100.0, 60.0, ""}));
  const auto seen = must(pixel_of(view_of(shown.camera), shown.sky.sun));
  EXPECT_NEAR(seen->x + 0.5, 100.0, 1e-6);
  EXPECT_NEAR(seen->y + 0.5, 60.0, 1e-6);
}

TEST(SkyWindow, KeysChangeAirAndAltitudeWithinTheirRanges) {
  SkyWindowState shown;
  shown.sky = sky_under(2.5, 45.0);
  EXPECT_TRUE(shown.apply({false, 0, 0, "ta"}));
  EXPECT_NEAR(shown.sky.turbidity.value, 2.75, 1e-12);
  EXPECT_NEAR(shown.sky.altitude_m, 100.0, 1e-12);
  EXPECT_NE(shown.caption().find("T 2.75    altitude 100 m    sun 45.0 deg"), std::string::npos) << shown.caption();
  shown.apply({false, 0, 0, std::string(200, 'g') + std::string(200, 'z')});
  EXPECT_EQ(shown.sky.turbidity, kLowestTurbidity);
  EXPECT_EQ(shown.sky.altitude_m, 0.0);
}

TEST(SkyBench, HasItsRows) {
  const auto rows = bench_dome({64, 36, 1});
  if (!rows) GTEST_SKIP() << rows.error().message;
  ASSERT_EQ(rows->size(), 11u);
  for (const auto& row : *rows) EXPECT_GT(row.value, 0.0) << row.name;
  EXPECT_EQ(rows->front().goal, 1.5);
}

}  // namespace
}  // namespace kasumi

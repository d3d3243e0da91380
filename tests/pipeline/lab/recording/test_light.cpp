// The object's light, from the cameras' pictures to its own pixels, against the slow spectral path.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "calib/colour/colorimetry.hpp"
#include "capture/fixture/replay_source.hpp"
#include "estimator/sky/dome.hpp"
#include "estimator/sky/sun.hpp"
#include "fixtures/landscape/building.hpp"
#include "fixtures/landscape/scene_view.hpp"
#include "gles/light/airlight_grid.hpp"
#include "pipeline/lab/recording/replay.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/pipeline/recorded.hpp"
#include "tests/pipeline/replayed.hpp"

namespace kasumi {
namespace {

// White balance that makes a black body's light grey.
glm::dvec3 balance_for(const Camera& camera, double kelvin) {
  Camera raw = camera;
  raw.white_balance = glm::dvec3{1.0};
  fixtures::Spectrum body{};
  for (int i = 0; i < fixtures::kWavelengths; ++i) {
    const double m = fixtures::wavelength_nm(i) * 1e-9;
    body[static_cast<std::size_t>(i)] = std::pow(m, -5.0) / std::expm1(0.014387769 / (m * kelvin)) * 1e-30;
  }
  const glm::dvec3 seen = fixtures::Channels(raw).of(body);
  return seen.y / seen;
}

// A white board that faces south: the patch in the scene, and its rendered twin.
fixtures::Mesh board(float half_m = 30.0F) {
  fixtures::Mesh mesh;
  mesh.materials = {{"white", Image<Rgb8>(4, 4, Rgb8(255))}};
  fixtures::MeshPart part;
  for (const auto& [x, y] : {std::pair{-1.0F, -1.0F}, {1.0F, -1.0F}, {1.0F, 1.0F}, {-1.0F, 1.0F}})
    part.vertices.push_back({{half_m * x, half_m * y, 0.0F}, {0, 0, 1}, {x, y}});
  part.indices = {0, 1, 2, 0, 2, 3};
  mesh.parts = {part};
  return mesh;
}

double through_density(double length_m, double altitude_m, double rise_m, double scale_height_m) {
  const double start = std::exp(-altitude_m / scale_height_m), x = rise_m / scale_height_m;
  return length_m * start * (std::abs(x) < 1e-9 ? 1.0 : -std::expm1(-x) / x);
}

struct DrawnAir {
  ObjectAppearance appearance;
  AirlightGrid measured;
};
DrawnAir drawn_air(const SceneAir& air, const SceneConditions& conditions, const PixelBox& box) {
  return {air.appearance(conditions, box), air.measured(conditions, box)};
}

// As a camera's next frame, in which the horizon is measured.
void see_horizon(SceneAir& air, const FrameMetadata& metadata, const Image<Rgb8>& picture) {
  air.follow_exposure(metadata);
  if (air.horizon_is_due(metadata))
    air.adopt({air.observer(), metadata, air.observer()->observe(view_of(picture), nullptr, nullptr)});
}

// The renderer's result for a white surface (gles/shaders), on the CPU: rho Gamma + 1 - Gamma over the measured light.
glm::dvec3 drawn(const DrawnAir& air, const glm::dvec2& pixel, const glm::dvec3& place, const glm::dvec3& normal) {
  const ObjectAppearance& appearance = air.appearance;
  const ObjectLight& light = appearance.light;
  const glm::dvec3 irradiance_here =
      std::max(0.0, glm::dot(normal, light.sun_direction)) * light.sun_irradiance + irradiance(light.around, normal);
  const glm::dvec3 rho = irradiance_here / kPi / airlight_at(appearance.horizon, pixel);
  const Haze& haze = appearance.haze;
  const double length = glm::length(place);
  const double rayleigh = through_density(length, haze.observer_altitude_m, place.z, haze.rayleigh_scale_height_m);
  const double mie = through_density(length, haze.observer_altitude_m, place.z, haze.mie_scale_height_m);
  glm::dvec3 gamma{0.0};
  for (std::size_t k = 0; k < kHazeNodes; ++k)
    gamma += haze.weight[k] * glm::exp(-haze.rayleigh_per_m[k] * rayleigh - haze.mie_per_m[k] * mie);
  return airlight_at(air.measured, pixel) * (rho * gamma + 1.0 - gamma);
}

TEST(ObjectsLight, FollowsTheCamerasExposureAndWhiteBalanceFromTheHorizonAlone) {
  const fixtures::PinholeCamera made =
      fixtures::scene_camera({.width = 480, .height = 270, .field_of_view_deg = 6.2, .heading_deg = 4.0});
  fixtures::Weather weather;
  weather.turbidity = 3.0;
  weather.sun = direction_from(from_degrees(50.0), from_degrees(200.0));
  weather.altitude_m = 980.0;
  const fixtures::Illumination day(weather);
  const double heading = from_degrees(4.0).value;
  const glm::dvec3 place{3500.0 * std::sin(heading), 3500.0 * std::cos(heading), 60.0};
  // Without land, so that the horizon is exact: finding it above ridges is tested elsewhere.
  fixtures::SceneGeometry land;
  land.points = Image<fixtures::GroundPoint>(480 * fixtures::kRaysPerSide, 270 * fixtures::kRaysPerSide);
  const glm::ivec2 pixel = glm::ivec2(glm::round(made.camera.pixel_of(glm::normalize(place)).value()));

  Installation installation;
  installation.site.altitude_m = weather.altitude_m;
  installation.scene = made.camera;  // as configured: it does not know the white balance's steps
  const PixelBox box{pixel.x - 4, pixel.y - 4, pixel.x + 4, pixel.y + 4};
  const SceneConditions conditions{Turbidity{weather.turbidity}, weather.sun, SkyCondition::clear, nullptr};

  std::vector<glm::dvec3> ratios;
  for (const double kelvin : {3000.0, 5000.0, 6500.0, 9000.0})
    for (const double stops : {-3.0, 0.0, 3.0}) {
      if (kelvin != 6500.0 && stops != 0.0) continue;  // each alone: fewer pictures
      Camera camera = made.camera;
      camera.white_balance = balance_for(camera, kelvin);
      const Image<glm::dvec3> light = fixtures::look_at_scene(day, camera, land);
      // The exposure steps start where +3 EV still fits; at -3 EV the picture is too dark to find a horizon, so the
      // earlier result is scaled by the exposure the camera reports.
      const bool steps = kelvin == 6500.0;
      fixtures::Exposure exposure = fixtures::automatic_exposure(light, 0.97, steps ? 0.115 : 0.5);
      exposure.seed = 7;
      SceneAir air(installation, {});
      FrameMetadata metadata;
      metadata.exposure_s = exposure.exposure_s;
      metadata.gain = exposure.gain;
      if (stops != 0.0) {
        see_horizon(air, metadata, fixtures::expose(light, camera, exposure));
        exposure.exposure_s *= std::exp2(stops);
        metadata.exposure_s = exposure.exposure_s;
        metadata.captured_at += std::chrono::seconds(2);
      }
      see_horizon(air, metadata, fixtures::expose(light, camera, exposure));

      const fixtures::Building patch(board(), {place.x, place.y, place.z, 0.0});
      const auto seen = fixtures::look_at_building(patch, day, camera, land);
      ASSERT_EQ(seen.coverage.at(pixel.x, pixel.y), 1.0);
      const glm::dvec3 real = seen.light.at(pixel.x, pixel.y) * camera.vignetting.at(pixel) * fixtures::kResponsivity *
                              exposure.exposure_s * exposure.gain;

      ASSERT_TRUE(air.horizon().usable()) << air.horizon().reason;
      const glm::dvec3 rendered = drawn(drawn_air(air, conditions, box), pixel, place, {0.0, -1.0, 0.0});
      ratios.push_back(rendered / real);
      fmt::print("{} K, {:+.0f} EV: rendered / real {:.4f} {:.4f} {:.4f}\n", kelvin, stops, ratios.back().r,
                 ratios.back().g, ratios.back().b);
    }
  glm::dvec3 least{1e9}, greatest{0.0};
  for (const auto& ratio : ratios) {
    least = glm::min(least, ratio);
    greatest = glm::max(greatest, ratio);
  }
  for (int c = 0; c < 3; ++c) {
    EXPECT_LE(greatest[c] / least[c] - 1.0, 0.02) << "channel " << c;
    EXPECT_NEAR(0.5 * (least[c] + greatest[c]), 1.0, 0.03) << "channel " << c;
  }
}

// A low sun at the right edge of a wide view, 15 deg above it; boards below the horizon line on both sides, so far away
// that they show mostly the air in front of them.
TEST(ObjectsLight, IsSeenThroughAirThatIsBrighterOnTheSunsSideAndBelowTheHorizon) {
  const fixtures::PinholeCamera made = fixtures::scene_camera(
      {.width = 480, .height = 270, .field_of_view_deg = 40.0, .heading_deg = 220.0, .pitch_deg = 0.0});
  fixtures::SceneGeometry land;
  land.points = Image<fixtures::GroundPoint>(480 * fixtures::kRaysPerSide, 270 * fixtures::kRaysPerSide);
  Installation installation;
  installation.site.altitude_m = 980.0;
  installation.surroundings.sky_model = DaylightModel::preetham;  // the world is
  installation.scene = made.camera;
  for (const double turbidity : {2.5, 5.0}) {
    fixtures::Weather weather;
    weather.turbidity = turbidity;
    weather.sun = direction_from(from_degrees(75.0), from_degrees(240.0));
    weather.altitude_m = 980.0;
    const fixtures::Illumination day(weather);
    const Image<glm::dvec3> light = fixtures::look_at_scene(day, made.camera, land);
    fixtures::Exposure exposure = fixtures::automatic_exposure(light, 0.97, 0.5);
    exposure.seed = 11;
    const double scale = fixtures::kResponsivity * exposure.exposure_s * exposure.gain;
    SceneAir air(installation, {});
    see_horizon(air, {}, fixtures::expose(light, made.camera, exposure));
    ASSERT_TRUE(air.horizon().usable()) << air.horizon().reason;
    const SceneConditions conditions{Turbidity{turbidity}, weather.sun, SkyCondition::clear, nullptr};
    const PixelBox box{20, 100, 460, 180};
    const auto over = drawn_air(air, conditions, box);

    std::array<double, 2> real_green{}, drawn_green{};
    for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
      const Direction towards = direction_from(from_degrees(92.0), from_degrees(side == 0 ? 203.0 : 237.0));
      const glm::dvec3 place = 12e3 * towards;
      const glm::dvec2 pixel = glm::round(made.camera.pixel_of(towards).value());
      const fixtures::Building patch(board(150.0F), {place.x, place.y, place.z, 40.0});
      const auto seen = fixtures::look_at_building(patch, day, made.camera, land);
      const glm::ivec2 at(pixel);
      ASSERT_EQ(seen.coverage.at(at.x, at.y), 1.0);
      const glm::dvec3 real = seen.light.at(at.x, at.y) * made.camera.vignetting.at(pixel) * scale;
      const double turn = from_degrees(40.0).value;
      const glm::dvec3 ours = drawn(over, pixel, place, {-std::sin(turn), -std::cos(turn), 0.0});
      fmt::print("T {}, {}: rendered / real {:.4f} {:.4f} {:.4f}\n", turbidity,
                 side == 0 ? "away from the sun" : "near it", ours.r / real.r, ours.g / real.g, ours.b / real.b);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(ours[c] / real[c], 1.0, 0.03) << "channel " << c << ", side " << side;
      real_green[side] = real.g;
      drawn_green[side] = ours.g;
    }
    EXPECT_GT(real_green[1], 1.15 * real_green[0]) << "the scene must be brighter on the sun's side";
    EXPECT_NEAR(drawn_green[1] / drawn_green[0] / (real_green[1] / real_green[0]), 1.0, 0.02);
  }
}

TEST(ObjectsLight, UnderAnOvercastSkyIsTheCloudsAloneAndCloseToTheSpectralReference) {
  auto recipe = small("overcast", 1);
  recipe.truth_frames = 1;
  const auto fixture = recorded(recipe, "light-overcast");
  const auto out = test_folder("light-overcast-out");
  AirRendering air;
  air.turbidity = Turbidity{recipe.turbidity};  // not measurable through clouds; only the light is tested here
  const auto summary = replay({fixture, out, false, false, 1, air});
  ASSERT_TRUE(summary) << summary.error().message;
  ASSERT_TRUE(summary->last && summary->last->measured);
  EXPECT_EQ(summary->last->measured->sun_share, 0.0);
  EXPECT_TRUE(summary->sighting.in_picture()) << summary->sighting.message;
  EXPECT_LE(building_error(fixture, out, "overcast", "pictures"), 4.0);

  // Between two pictures of a slow sky camera its clouds stay valid for a while.
  const auto read = read_fixture(fixture).value();
  FastForwardClock clock(read.info.start_utc);
  auto sources = open_fixture_sources(fixture, clock).value();
  SkyWatch watch(read.installation);
  const auto frame = sources.sky->next(*sources.sky->due() + std::chrono::seconds(1)).value();
  ASSERT_TRUE(watch.observe(frame));
  const auto at = frame.metadata.captured_at;
  EXPECT_TRUE(watch.at(at + std::chrono::seconds(30), frame.metadata.utc, SunSource::ephemeris).measured);
  EXPECT_FALSE(watch.at(at + std::chrono::minutes(5), frame.metadata.utc, SunSource::ephemeris).measured);
}

// Through 8 bits of sRGB, as a fisheye that looks up sees it; the brightest light away from the sun is full scale.
Frame frame_of(const DomeFunction& sky, const SunDirection& sun, const Camera& camera, Utc utc) {
  const DomeFunction in_rgb = in_space(sky, xyz_to_linear_srgb());
  std::vector<glm::dvec3> light;
  double brightest = 0.0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const auto view = camera.direction_at({x, y});
      const bool seen = view && view->z > 0.0;
      light.push_back(seen ? glm::max(dome_light(in_rgb, *view), 0.0) : glm::dvec3{0.0});
      const auto& at = light.back();
      if (seen && to_degrees(angle_between(*view, sun)) > 10.0) brightest = std::max({brightest, at.r, at.g, at.b});
    }
  std::vector<std::uint8_t> bytes;
  for (const auto& at : light) {
    const glm::dvec3 encoded = camera.response.to_encoded(glm::min(at / brightest, 1.0));
    for (int c = 0; c < 3; ++c) bytes.push_back(static_cast<std::uint8_t>(std::lround(255.0 * encoded[c])));
  }
  Frame frame;
  frame.metadata.utc = utc;
  frame.metadata.format = four_cc("RGB3");
  frame.metadata.width = camera.width;
  frame.metadata.height = camera.height;
  frame.metadata.stride = 3u * static_cast<std::uint32_t>(camera.width);
  frame.metadata.bytes_used = static_cast<std::uint32_t>(bytes.size());
  frame.payload = payload_of(std::move(bytes));
  return frame;
}

TEST(SkyWatch, TheTurbidityOfAHighSiteMatchesTheDome) {
  Installation installation;
  installation.site = {"pass", 46.5, 8.4, 3000.0};
  Camera& camera = installation.sky;
  camera.width = camera.height = 160;
  camera.lens = equidistant_lens({79.5, 79.5}, 80.0 / from_degrees(90.0).value, from_degrees(90.0));
  camera.to_world = camera_to_world(from_degrees(180.0), from_degrees(90.0), {0.0});
  const Utc utc = std::chrono::sys_days{std::chrono::June / 21 / 2026} + std::chrono::hours(8);
  const SunDirection sun = sun_position(utc, installation.site).direction;
  const Frame frame = frame_of(dome(3000.0, Turbidity{5.0}, sun), sun, camera, utc);
  const auto found = [&] { return SkyWatch(installation).observe(frame, Instant{}, SunSource::ephemeris).value(); };
  const auto by_dome = found();
  ASSERT_TRUE(by_dome.seen_air()) << by_dome.estimate.reason;
  EXPECT_NEAR(by_dome.seen_air()->air.turbidity().value, 5.0, 0.25);
  // Preetham's model has no altitude: a high-altitude sky always looks very clear to it.
  installation.surroundings.sky_model = DaylightModel::preetham;
  const auto by_preetham = found();
  ASSERT_TRUE(by_preetham.seen_air()) << by_preetham.estimate.reason;
  EXPECT_LT(by_preetham.seen_air()->air.turbidity().value, 2.2);
}

TEST(SceneAir, AssumesAnOrdinaryClearDayUntilTheSkyIsKnown) {
  // Aerosol optical depths of clear days on land are .1 to .3 at 550 nm.
  Installation installation;
  const auto supposed = [&] { return SceneAir(installation, {}).conditions({}).air.turbidity(); };
  const auto depth = [](Turbidity turbidity) { return aerosol_optical_depth(turbidity, 550.0); };
  for (const double altitude_m : {100.0, 2200.0, 3000.0}) {
    installation.site.altitude_m = altitude_m;
    EXPECT_GE(depth(supposed()), 0.1) << altitude_m << " m";
    EXPECT_LE(depth(supposed()), 0.3) << altitude_m << " m";
  }
  SkyReport known;
  known.air.emplace().air = Turbidity{2.6};
  EXPECT_EQ(SceneAir(installation, {}).conditions(known).air, AirState(Turbidity{2.6}));
}

TEST(SceneAir, AKnownAerosolFadesWhatIsFarByItsOwnLaw) {
  Installation installation;
  installation.scene.width = installation.scene.height = 40;
  installation.scene.lens = pinhole_lens({{30.0, 30.0}, {19.5, 19.5}, {}});
  installation.scene.to_world = camera_to_world(Radians{0.0}, Radians{0.0}, Radians{0.0});
  const PixelBox box{10, 10, 20, 20};
  const auto haze_of = [&](const AirRendering& options) {
    const SceneAir air(installation, options);
    SkyReport report;
    report.sun.source = SunSource::ephemeris;
    report.sun.direction = direction_from(from_degrees(40.0), from_degrees(180.0));
    return air.appearance(air.conditions(report), box).haze;
  };
  const auto usual = haze_of({});
  EXPECT_GT(usual.mie_per_m[0].b, 1.2 * usual.mie_per_m[0].r) << "the papers' lambda^-2";
  installation.surroundings.air = {0.6, std::nullopt, AerosolKind::dust};
  const auto dust = haze_of({});
  EXPECT_LT(dust.mie_per_m[0].b, dust.mie_per_m[0].r) << "dust takes a little more of the red";
  EXPECT_NEAR(dust.mie_per_m[1].g, 0.6 / 1200.0, 0.03 * 0.6 / 1200.0);
  // Asked for by name, the papers' law holds for the T of that dust.
  AirRendering by_name;
  by_name.scattering = ScatteringModel::morales2017;
  const auto papers = haze_of(by_name);
  EXPECT_NEAR(papers.mie_per_m[1].b / papers.mie_per_m[1].r, usual.mie_per_m[1].b / usual.mie_per_m[1].r, 1e-3);
  installation.surroundings.sky_model = DaylightModel::preetham;
  const auto preetham = haze_of({});
  EXPECT_NEAR(preetham.mie_per_m[1].g, papers.mie_per_m[1].g, 1e-9);
}

}  // namespace
}  // namespace kasumi

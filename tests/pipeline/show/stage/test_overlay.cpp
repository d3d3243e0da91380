// The overlay's shapes against geometry computed here, and their drawing.
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "gles/gl/context.hpp"
#include "pipeline/lab/recording/replay.hpp"
#include "pipeline/show/stage/overlay_drawing.hpp"
#include "pipeline/show/stage/overlay_shapes.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

constexpr double kFocal_px = 3000.0, kCentreX = 479.5, kCentreY = 269.5;

// A camera that looks north over 18 degrees by 10.
Installation kiosk(double pitch_deg = 0.0, double roll_deg = 0.0, double heading_deg = 0.0) {
  Installation installation;
  installation.site = {"", 46.0, 8.0, 1000.0};
  Camera& scene = installation.scene;
  scene.width = 960;
  scene.height = 540;
  scene.lens = pinhole_lens({{kFocal_px, kFocal_px}, {kCentreX, kCentreY}, {}});
  scene.to_world = camera_to_world(from_degrees(heading_deg), from_degrees(pitch_deg), from_degrees(roll_deg));
  installation.object.placement = {.east_m = 20.0, .north_m = 3000.0, .up_m = -10.0};
  return installation;
}
constexpr ModelBounds kBuilding{{-20.0F, 0.0F, -30.0F}, {20.0F, 25.0F, 30.0F}};

std::vector<OverlayLine> lines_of(const OverlayShapes& shapes, OverlayLineKind kind) {
  std::vector<OverlayLine> found;
  for (const auto& line : shapes.lines)
    if (line.kind == kind) found.push_back(line);
  return found;
}
const OverlayLabel* label_of(const OverlayShapes& shapes, const std::string& words) {
  for (const auto& label : shapes.labels)
    if (label.text.find(words) != std::string::npos) return &label;
  return nullptr;
}

TEST(Overlay, TheHorizonsDipMatchesTheNauticalTables) {
  // The Nautical Almanac: dip in minutes of arc = 1.76 sqrt(height in metres), for mean refraction.
  for (const double height_m : {2.0, 10.0, 100.0, 1000.0})
    EXPECT_NEAR(60.0 * to_degrees(dip_of_horizon(height_m)), 1.76 * std::sqrt(height_m),
                0.03 * 1.76 * std::sqrt(height_m));
  EXPECT_EQ(dip_of_horizon(-5.0).value, 0.0);
}

TEST(Overlay, TheHorizonLiesItsDipBelowLevelAndTurnsWithTheCamera) {
  const double dip = dip_of_horizon(1000.0).value;
  for (const double pitch_deg : {0.0, 2.0, -1.5})
    for (const double roll_deg : {0.0, 4.0, -7.0}) {
      const auto lines = lines_of(overlay_shapes(kiosk(pitch_deg, roll_deg), kBuilding), OverlayLineKind::horizon);
      ASSERT_EQ(lines.size(), 1u);
      const double roll = from_degrees(roll_deg).value,
                   below = kFocal_px * std::tan(dip + from_degrees(pitch_deg).value);
      // A camera turned clockwise sees the world turned the other way; far from the axis the projection of a cone
      // curves.
      for (const auto& p : lines[0].points) {
        const double x = p.x - kCentreX, y = p.y - kCentreY;
        const double along = x * std::cos(roll) - y * std::sin(roll), down = x * std::sin(roll) + y * std::cos(roll);
        const double bend =
            0.5 * along * along / kFocal_px * std::tan(dip + std::abs(from_degrees(pitch_deg).value)) + 0.1;
        EXPECT_NEAR(down, below, bend) << "pitch " << pitch_deg << ", roll " << roll_deg << ", at " << along;
      }
    }
}

TEST(Overlay, TheGridsLinesLieWhereTheirLabelsSay) {
  const auto shapes = overlay_shapes(kiosk(0.0, 0.0, 350.0), kBuilding);
  // 18 degrees in at most eight steps: 5, of which 345, 350 and 355 are seen.
  for (const double azimuth : {345.0, 350.0, 355.0}) {
    const auto* label = label_of(shapes, fmt::format("{:.0f}°", azimuth));
    ASSERT_NE(label, nullptr) << azimuth;
    EXPECT_NEAR(label->at.x, kCentreX + kFocal_px * std::tan(from_degrees(azimuth - 350.0).value), 1e-6);
  }
  const auto* level = label_of(shapes, "0°");
  ASSERT_NE(level, nullptr);
  const auto* up = label_of(shapes, "+5°");
  ASSERT_NE(up, nullptr);
  const double across = (up->at.x - kCentreX) / kFocal_px;
  EXPECT_NEAR(up->at.y, kCentreY - kFocal_px * std::tan(from_degrees(5.0).value) * std::hypot(1.0, across), 1e-6);
  EXPECT_EQ(label_of(shapes, "340°"), nullptr) << "out of the picture";
  EXPECT_GE(lines_of(shapes, OverlayLineKind::grid).size(), 5u);
}

TEST(Overlay, TheGridFollowsTheLens) {
  auto installation = kiosk();
  installation.scene.lens = pinhole_lens({{kFocal_px, kFocal_px}, {kCentreX, kCentreY}, {-0.5, 0.0, 0.0, 0.0, 0.0}});
  const auto* label = label_of(overlay_shapes(installation, kBuilding), "5°");
  ASSERT_NE(label, nullptr);
  for (const auto& line : lines_of(overlay_shapes(installation, kBuilding), OverlayLineKind::grid))
    for (const auto& p : line.points) {
      const auto direction = must(installation.scene.direction_at(p));
      const double azimuth = std::remainder(to_degrees(azimuth_angle(*direction)), 5.0);
      const double elevation = std::remainder(90.0 - to_degrees(zenith_angle(*direction)), 5.0);
      EXPECT_LT(std::min(std::abs(azimuth), std::abs(elevation)), 1e-4) << p.x << ", " << p.y;
    }
}

TEST(Overlay, TheBuildingsBoxIsWhereTheBuildingIs) {
  auto installation = kiosk();
  installation.object.placement.heading = from_degrees(90.0);  // its -z, north at heading 0, points east
  installation.object.placement.scale = 2.0;
  const auto shapes = overlay_shapes(installation, kBuilding);
  const auto footprint = lines_of(shapes, OverlayLineKind::footprint), box = lines_of(shapes, OverlayLineKind::box);
  ASSERT_EQ(footprint.size(), 4u);
  EXPECT_EQ(box.size(), 8u);
  // Turned, it is 120 m wide and 80 m deep: from -40 to +80 m east of the camera, 2960 to 3040 m away, foot at -10 m.
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  for (const auto& lines : {footprint, box})
    for (const auto& line : lines)
      for (const auto& p : line.points) {
        left = std::min(left, p.x), right = std::max(right, p.x);
        top = std::min(top, p.y), bottom = std::max(bottom, p.y);
      }
  EXPECT_NEAR(left, kCentreX - kFocal_px * 40.0 / 2960.0, 1e-3);
  EXPECT_NEAR(right, kCentreX + kFocal_px * 80.0 / 2960.0, 1e-3);
  EXPECT_NEAR(top, kCentreY - kFocal_px * 40.0 / 2960.0, 1e-3);
  EXPECT_NEAR(bottom, kCentreY + kFocal_px * 10.0 / 2960.0, 1e-3);
}

TEST(Overlay, AxesAndHeadingFollowTheModelsHeading) {
  auto installation = kiosk();
  for (const double heading_deg : {0.0, 90.0, 30.0}) {
    installation.object.placement.heading = from_degrees(heading_deg);
    const auto shapes = overlay_shapes(installation, kBuilding);
    const double length = 0.75 * 60.0, turn = from_degrees(heading_deg).value;
    // glTF's x points east at heading 0 and turns clockwise.
    const double east = 20.0 + length * std::cos(turn), north = 3000.0 - length * std::sin(turn);
    const auto x = lines_of(shapes, OverlayLineKind::axis_x);
    ASSERT_EQ(x.size(), 1u);
    EXPECT_NEAR(x[0].points.back().x, kCentreX + kFocal_px * east / north, 1e-3) << heading_deg;
    const auto arrow = lines_of(shapes, OverlayLineKind::heading);
    ASSERT_GE(arrow.size(), 1u);
    const double tip_east = 20.0 + length * std::sin(turn), tip_north = 3000.0 + length * std::cos(turn);
    EXPECT_NEAR(arrow[0].points.back().x, kCentreX + kFocal_px * tip_east / tip_north, 1e-3) << heading_deg;
    const auto up = lines_of(shapes, OverlayLineKind::axis_y);
    ASSERT_EQ(up.size(), 1u);
    EXPECT_NEAR(up[0].points.back().y, kCentreY - kFocal_px * (length - 10.0) / 3000.0, 1e-3);
    EXPECT_NE(label_of(shapes, fmt::format("heading {:.1f}°", heading_deg)), nullptr);
  }
}

Installation with_landmarks(const std::string& text) {
  auto installation = kiosk();
  const auto root = ConfigTable::parse(text, "kasumi.toml").value();
  installation.landmarks = read_landmarks(root, installation.site);
  EXPECT_TRUE(root.finish());
  return installation;
}

TEST(Overlay, ALandmarkFortyKilometresAwayIsLoweredByCurvatureAndRaisedByRefraction) {
  // Due north of the site; 40 km of the meridian are .3598 degrees at 46 degrees north (radius 6369 km there).
  const auto installation = with_landmarks(
      "[[landmarks]]\nname = 'Peak'\nlatitude_deg = 46.359836\nlongitude_deg = 8.0\naltitude_m = 2000\n");
  const auto shapes = overlay_shapes(installation, kBuilding);
  const auto* label = label_of(shapes, "Peak, 40.0 km");
  ASSERT_NE(label, nullptr);
  const auto marks = lines_of(shapes, OverlayLineKind::landmark);
  ASSERT_EQ(marks.size(), 4u);
  glm::dvec2 middle{0.0};
  for (const auto& mark : marks) middle += 0.25 * mark.points[0];
  const double drop_m = 0.87 * 40e3 * 40e3 / (2.0 * 6371e3);  // 109 m
  EXPECT_NEAR(middle.x, kCentreX, 0.01);
  EXPECT_NEAR(middle.y, kCentreY - kFocal_px * (1000.0 - drop_m) / 40e3, 0.15) << "of a pixel; the curve is 9 px";
}

TEST(Overlay, LandmarksBehindTheCameraAndOutsideThePictureAreOmitted) {
  const auto shapes = overlay_shapes(
      with_landmarks("[[landmarks]]\nname = 'South'\nlatitude_deg = 45.9\nlongitude_deg = 8.0\naltitude_m = 1000\n"
                     "[[landmarks]]\nname = 'East'\nlatitude_deg = 46.0\nlongitude_deg = 8.3\naltitude_m = 1000\n"),
      kBuilding);
  EXPECT_TRUE(lines_of(shapes, OverlayLineKind::landmark).empty());
  EXPECT_EQ(label_of(shapes, "South"), nullptr);
}

TEST(Landmarks, AllProblemsAreReportedAtOnce) {
  const auto root =
      ConfigTable::parse(
          "[[landmarks]]\nlatitude_deg = 46.1\nlongitude_deg = 8\naltitude_m = 12000\n"
          "[[landmarks]]\nname = 'Far'\nlatitude_deg = 56.1\nlongitude_deg = 8\naltitude_m = 0\nheight = 3\n",
          "kasumi.toml")
          .value();
  read_landmarks(root, {"", 46.0, 8.0, 1000.0});
  const auto finished = root.finish();
  ASSERT_FALSE(finished);
  for (const char* words : {"landmarks[0].name is missing", "landmarks[0].altitude_m = 12000",
                            "landmarks[1].latitude_deg = 56.1: expected a place within 400 km", "landmarks[1].height"})
    EXPECT_THAT(finished.error().message, HasSubstr(words));
}

TEST(OverlayDrawing, ALineCoversItsWidthAndHasADarkEdge) {
  // Across a slanted line the coverage sums to its width, at any subpixel position.
  for (const double shift : {0.0, 0.3, 0.5}) {
    Image<Rgba8> picture(60, 60);
    draw_line(picture, {{-5.0, 20.0 + shift}, {65.0, 34.0 + shift}}, 2.0, {255, 255, 255});
    double bright = 0.0;
    for (int y = 0; y < 60; ++y) {
      const Rgba8 p = picture.at(30, y);
      bright += p.a / 255.0 * std::max(0, p.g - 14) / 241.0;
    }
    EXPECT_NEAR(bright / std::hypot(1.0, 0.2), 2.0, 0.12) << "pixels wide";
    int dark = 0;
    for (int y = 0; y < 60; ++y) dark += picture.at(30, y).a > 100 && picture.at(30, y).g < 60 ? 1 : 0;
    EXPECT_GE(dark, 2) << "one above and one below";
    EXPECT_EQ(picture.at(30, 5).a, 0);
  }
}

TEST(OverlayDrawing, SegmentsOfALineHaveNoSeams) {
  std::vector<glm::dvec2> whole{{5.0, 10.3}, {55.0, 10.3}}, pieces;
  for (int i = 0; i <= 50; ++i) pieces.emplace_back(5.0 + i, 10.3);
  Image<Rgba8> one(60, 20), many(60, 20);
  draw_line(one, whole, 1.5, {255, 200, 0});
  draw_line(many, pieces, 1.5, {255, 200, 0});
  EXPECT_EQ(one.elements(), many.elements());
}

TEST(OverlayDrawing, LinesOutsideThePictureAreHarmless) {
  Image<Rgba8> picture(20, 20);
  draw_line(picture, {{-500.0, -3.0}, {900.0, -40.0}}, 2.0, {255, 255, 255});
  draw_line(picture, {{1e7, 1e7}, {2e7, 1e7}}, 2.0, {255, 255, 255});
  draw_line(picture, {}, 2.0, {255, 255, 255});
  for (const Rgba8& p : picture.elements()) EXPECT_EQ(p.a, 0);
}

TEST(OverlayDrawing, IsDrawnAtTheDisplayedSize) {
  const auto shapes = overlay_shapes(kiosk(), kBuilding);
  for (const double scale : {0.5, 1.0, 2.0}) {
    const auto picture = must(draw_shapes(shapes, int(960 * scale), int(540 * scale), scale, std::nullopt));
    EXPECT_EQ(picture->width(), int(960 * scale));
    // The level line of the grid, away from its label.
    const int row = int(std::lround((kCentreY + 0.5) * scale - 0.5));
    EXPECT_GT(picture->at(int(700 * scale), row).a, 60) << scale;
    EXPECT_EQ(picture->at(int(700 * scale), row + int(60 * scale)).a, 0) << scale;
  }
}

TEST(OverlayInReplay, ChangesThePictureAndNoMeasurement) {
  if (const auto context = open_headless_context(); !context) GTEST_SKIP() << context.error().message;
  // With every effect that follows the camera: its noise must be the same in every replay.
  auto recipe = small("clear-noon", 1);
  recipe.scene_width = 320;
  recipe.scene_height = 180;
  recipe.sky_size = 240;
  const auto fixture = recorded(recipe, "overlay");
  auto text = read_text_file(fixture / "fixture.toml").value();
  text.insert(text.find("[scene]\n") + 8, "point_spread_px = 0.5\nshared_chroma = true\n");
  text += "[scene.noise]\nfull_scale_electrons = 2000\nread_electrons = 3\n";
  ASSERT_TRUE(write_text_file(fixture / "fixture.toml", text));
  const auto play = [&](const char* out, bool overlay) {
    ReplayRequest request;
    request.fixture = fixture;
    request.out = test_folder(out);
    request.frames = 1;
    request.overlay = overlay;
    const auto summary = replay(request);
    EXPECT_TRUE(summary) << summary.error().message;
    return std::pair(read_file(*request.out / "frame-000000.png").value(),
                     read_file(*request.out / "turbidity.csv").value());
  };
  const auto plain = play("overlay-none", false), again = play("overlay-again", false),
             overlaid = play("overlay-drawn", true);
  EXPECT_TRUE(plain == again) << "the same fixture, the same bits";
  EXPECT_FALSE(overlaid.first == plain.first);
  EXPECT_TRUE(overlaid.second == plain.second) << "turbidity.csv";
}

TEST(OverlayDrawing, AMissingFontIsReported) {
  EXPECT_THAT(draw_shapes(overlay_shapes(kiosk(), kBuilding), 960, 540, 1.0, "/nowhere/font.ttf"),
              FailsWith(HasSubstr("/nowhere/font.ttf")));
}

}  // namespace
}  // namespace kasumi

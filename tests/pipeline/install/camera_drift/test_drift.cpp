// Drift since the calibration: generated days disturbed by known amounts, and days that are merely different.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "capture/fixture/replay_source.hpp"
#include "pipeline/install/camera_drift/drift.hpp"
#include "pipeline/install/camera_drift/drift_gather.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/install/calibrate/calibrating.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Pictures = std::vector<std::pair<FrameMetadata, Image<Rgb8>>>;

struct Day {
  Installation installation;
  Pictures scene, sky;
};

constexpr Utc kNoon = std::chrono::sys_days{std::chrono::June / 21 / 2026} + 3h;

fixtures::Recipe day(std::uint64_t seed, double turbidity, double clouds) {
  auto recipe = small("papers-noon", 3);
  recipe.seed = seed;
  recipe.start_utc = kNoon;
  recipe.turbidity = recipe.turbidity_end = turbidity;
  recipe.cloud_cover = clouds;
  recipe.sky_frames = 9;
  recipe.sky_period_s = 180.0;
  recipe.sky_size = 260;
  recipe.scene_width = 320;
  recipe.scene_height = 180;
  recipe.scene_frames = 3;
  recipe.scene_period_s = 600.0;
  return recipe;
}

Pictures read(const std::filesystem::path& folder, const Camera& camera, Utc start) {
  FastForwardClock clock(start);
  auto source = open_replay(folder / camera.name, clock).value();
  Pictures pictures;
  while (const auto frame = source->next(Instant::max()))
    pictures.emplace_back(frame->metadata, to_rgb(decode(*frame, camera.yuv_encoding).value().view()));
  return pictures;
}

Day made(const fixtures::Recipe& recipe, const std::string& name) {
  const auto folder = recorded(recipe, "drift-" + name);
  const auto fixture = read_fixture(folder).value();
  const auto& installation = fixture.installation;
  return {installation, read(folder, installation.scene, fixture.info.start_utc),
          read(folder, installation.sky, fixture.info.start_utc)};
}

DriftFrames frames_of(const Day& day) {
  DriftFrames frames(day.installation);
  for (const auto& [metadata, picture] : day.scene) frames.add_scene(view_of(picture));
  for (const auto& [metadata, picture] : day.sky) frames.add_sky(view_of(picture), metadata, metadata.utc);
  return frames;
}

const Day& first_day() {
  static const Day day_one = made(day(11, 2.5, 0.0), "first");
  return day_one;
}
const DriftReference& reference() {
  static const auto taken = take_reference(frames_of(first_day()), first_day().installation, kNoon).value();
  return taken;
}

DriftReport report(const Day& day) {
  const auto found = find_drift(frames_of(day), reference(), first_day().installation, kNoon + 24h);
  std::printf("%s%s\n", drift_text(found).c_str(), drift_summary(found).c_str());
  return found;
}

const DriftFinding& finding(const DriftReport& report, const std::string& camera, const std::string& what) {
  for (const auto& found : report.findings)
    if (found.camera == camera && found.what == what) return found;
  ADD_FAILURE() << camera << "." << what;
  return report.findings.front();
}

std::vector<std::string> drifted(const DriftReport& report) {
  std::vector<std::string> found;
  for (const auto& one : report.findings)
    if (one.state == DriftState::drifted) found.push_back(one.camera + "." + one.what);
  return found;
}

// A picture with each pixel's light computed from the old one's.
using Light = std::function<glm::dvec3(const glm::dvec2&)>;
void redraw(Pictures& pictures, const Camera& camera, const std::function<glm::dvec3(const Light&, glm::dvec2)>& make) {
  for (auto& [metadata, picture] : pictures) {
    Image<glm::dvec3> light(picture.width(), picture.height());
    for (std::size_t i = 0; i < light.elements().size(); ++i)
      light.elements()[i] = camera.response.to_light(glm::dvec3(picture.elements()[i]) / 255.0);
    const Light sample = [&](const glm::dvec2& at) {
      const auto p = glm::clamp(at, glm::dvec2(0.0), glm::dvec2(light.width() - 1.001, light.height() - 1.001));
      const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
      const double fx = p.x - x, fy = p.y - y;
      return (1 - fy) * ((1 - fx) * light.at(x, y) + fx * light.at(x + 1, y)) +
             fy * ((1 - fx) * light.at(x, y + 1) + fx * light.at(x + 1, y + 1));
    };
    for (int y = 0; y < picture.height(); ++y)
      for (int x = 0; x < picture.width(); ++x) {
        const auto encoded = camera.response.to_encoded(glm::clamp(make(sample, {x, y}), 0.0, 1.0));
        picture.at(x, y) = Rgb8(glm::round(255.0 * encoded));
      }
  }
}

Day other_day() {
  static const Day later = made(day(12, 2.8, 0.0), "other");
  return later;
}

TEST(Drift, OtherCloudsHazeAndHourAreNotDrift) {
  auto recipe = day(21, 8.0, 0.5);
  recipe.start_utc = kNoon - 2h - 30min;
  const auto hazy = report(made(recipe, "hazy"));
  EXPECT_THAT(drifted(hazy), testing::IsEmpty());
  EXPECT_EQ(finding(hazy, "scene", "view").state, DriftState::steady) << "it can still be determined";
  EXPECT_THAT(drifted(report(other_day())), testing::IsEmpty());
}

// Applies each disturbance to the other day; one test, since drawing the days takes long.
void bump_the_sky_camera(Day later) {
  const auto& camera = first_day().installation.sky;
  // Half a degree about the picture's x axis: the content moves up.
  const double angle = from_degrees(0.5).value;
  const glm::dmat3 back{{1, 0, 0}, {0, std::cos(angle), -std::sin(angle)}, {0, std::sin(angle), std::cos(angle)}};
  redraw(later.sky, camera, [&](const Light& light, glm::dvec2 pixel) {
    const auto ray = camera.lens->unproject(pixel);
    const auto from = ray ? camera.lens->project(back * *ray) : std::nullopt;
    return light(from.value_or(pixel));
  });
  const auto found = report(later);
  const auto& view = finding(found, "sky", "view");
  EXPECT_EQ(view.state, DriftState::drifted);
  EXPECT_NEAR(view.value.value_or(0.0), 0.5, 0.12);
  // At .7 deg a pixel the sun determines it less accurately.
  const auto& sun = finding(found, "sky", "sun");
  EXPECT_NEAR(sun.value.value_or(0.0), 0.5, 0.2);
}

void dirty_the_dome(Day later) {
  const auto& camera = first_day().installation.sky;
  // Two specks of dust near the dome's top, out of focus, each taking 30 % in its middle.
  redraw(later.sky, camera, [&](const Light& light, glm::dvec2 pixel) {
    const double one = glm::distance(pixel, {143.0, 82.0}), other = glm::distance(pixel, {104.0, 108.0});
    return light(pixel) * (1.0 - 0.30 * std::exp(-0.5 * one * one / 20.0)) *
           (1.0 - 0.30 * std::exp(-0.5 * other * other / 20.0));
  });
  const auto found = report(later);
  EXPECT_THAT(drifted(found), testing::ElementsAre("sky.dome"));
  const auto& dome = finding(found, "sky", "dome");
  EXPECT_NEAR(dome.value.value_or(0.0), 27.0, 8.0) << "30 %, less the dilution by the surroundings and the pixels";
  EXPECT_THAT(dome.message, HasSubstr("2 spots"));
}

void put_the_scene_out_of_focus(Day later) {
  const auto& camera = first_day().installation.scene;
  redraw(later.scene, camera, [&](const Light& light, glm::dvec2 pixel) {
    glm::dvec3 sum{0.0};
    double weights = 0.0;
    for (int dy = -4; dy <= 4; ++dy)
      for (int dx = -4; dx <= 4; ++dx) {
        const double weight = std::exp(-0.5 * (dx * dx + dy * dy) / (1.5 * 1.5));
        sum += weight * light(pixel + glm::dvec2(dx, dy));
        weights += weight;
      }
    return sum / weights;
  });
  const auto found = report(later);
  EXPECT_THAT(drifted(found), testing::ElementsAre("scene.focus"));
  // .6 px of the pixels' own and 1.5 px make 1.6: 2.7 times as wide.
  EXPECT_NEAR(finding(found, "scene", "focus").value.value_or(0.0), 170.0, 35.0);
}

void fog_the_scene_camera(Day later) {
  const auto& camera = first_day().installation.scene;
  glm::dvec3 mean{0.0};
  const auto& pixels = later.scene[0].second.elements();
  for (const auto& pixel : pixels)
    mean += camera.response.to_light(glm::dvec3(pixel) / 255.0) / static_cast<double>(pixels.size());
  redraw(later.scene, camera, [&](const Light& light, glm::dvec2 pixel) { return 0.5 * light(pixel) + 0.5 * mean; });
  const auto found = report(later);
  EXPECT_THAT(drifted(found), testing::ElementsAre("scene.lens"));
  EXPECT_THAT(finding(found, "scene", "lens").message, HasSubstr("fogged"));
}

TEST(Drift, EachDisturbanceIsDetectedNamedAndMeasured) {
  const auto day = other_day();
  bump_the_sky_camera(day);
  dirty_the_dome(day);
  put_the_scene_out_of_focus(day);
  fog_the_scene_camera(day);
}

// As a user calls it: on recordings, with the reference next to a file.
TEST(Drift, TheCommandTakesAReferenceThenComparesAndSetsItsExitCode) {
  const auto stem = fresh_folder("drift-command") / "calibration";
  ASSERT_TRUE(write_text_file(stem.string() + ".toml", "[scene]\n"));
  auto recipe = day(11, 2.5, 0.0);
  recipe.sky_frames = 3;
  recipe.sky_size = 120;
  const auto first = recorded(recipe, "drift-command-first");
  recipe.seed = 31;
  recipe.outlook.pitch_deg += 0.5;
  const auto bumped = recorded(recipe, "drift-command-bumped");
  const auto call = [&](const std::filesystem::path& recording, const std::string& more) {
    return run(fmt::format("check {} --calibration {}.toml {}", recording.string(), stem.string(), more));
  };
  auto outcome = ended(0, call(first, ""));
  EXPECT_THAT(outcome.err, HasSubstr("saved as the reference"));
  outcome = call(first, "");
  EXPECT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr("scene.view"));

  outcome = call(bumped, "--json");
  EXPECT_EQ(outcome.code, 1) << outcome.err;
  const auto json = parse_json(outcome.out);
  ASSERT_TRUE(json.is_object()) << outcome.out;
  EXPECT_EQ(json["well"], false);
  const auto& view = json["findings"][0];
  EXPECT_EQ(view["camera"], "scene");
  EXPECT_EQ(view["what"], "view");
  EXPECT_EQ(view["state"], "drifted");
  EXPECT_NEAR(view["value"].get<double>(), 0.5, 0.02);
  EXPECT_THAT(view["words"].get<std::string>(), HasSubstr("0.50 up"));

  EXPECT_EQ(call(bumped, "--reference").code, 0);
  EXPECT_EQ(call(bumped, "").code, 0) << "today's view is the reference now";
  ASSERT_TRUE(write_text_file(stem.string() + ".check.json", "{\"check_reference\": 7}\n"));
  EXPECT_EQ(call(first, "").code, 2);
  EXPECT_EQ(run("check").code, 2);
  EXPECT_EQ(call(stem.string() + "-none", "").code, 2);
}

TEST(Drift, AReferenceIsReadBackUnchanged) {
  const auto fixture = read_fixture(source_folder() / "fixtures/demo").value();
  const auto taken = take_reference(gather_recorded(fixture).value(), fixture.installation, kNoon).value();
  const auto stem = fresh_folder("drift-reference") / "calibration";
  ASSERT_TRUE(save_reference(taken, stem));
  const auto again = must(load_reference(stem, fixture.installation));
  EXPECT_TRUE(belongs_to(*again, fixture.installation));
  ASSERT_TRUE(again->scene && taken.scene);
  EXPECT_EQ(again->scene->lines.strength.elements(), taken.scene->lines.strength.elements());
  EXPECT_EQ(again->scene->darkest.places, taken.scene->darkest.places);
  ASSERT_TRUE(again->dome && taken.dome);
  EXPECT_EQ(again->dome->steps.elements(), taken.dome->steps.elements());
  EXPECT_EQ(again->scene->edges.size(), taken.scene->edges.size());
  EXPECT_LE(std::max(again->scene->lines.strength.width(), again->scene->lines.strength.height()), 480);
  auto other = fixture.installation;
  other.scene.calibrated_utc = kNoon;
  EXPECT_FALSE(belongs_to(*again, other)) << "the cameras were calibrated again";
  ASSERT_TRUE(write_text_file(stem.string() + ".check.json", "{\"check_reference\": 7}\n"));
  EXPECT_EQ(load_reference(stem, fixture.installation).error().kind, FaultKind::bad_input);
  EXPECT_EQ(load_reference(stem.string() + "-none", fixture.installation).error().kind, FaultKind::io);
}

// Earlier versions kept pictures: what they showed is still compared with, and the pictures go.
TEST(Drift, AReferenceWithPicturesBecomesOneWithout) {
  const auto& installation = first_day().installation;
  const auto frames = frames_of(first_day());
  const auto stem = fresh_folder("drift-pictures") / "calibration";
  ASSERT_TRUE(save_reference(reference(), stem));
  const auto file = stem.string() + ".check.json";
  auto json = parse_json(read_text_file(file).value());
  json["check_reference"] = 1;
  for (const char* key : {"scene_lines", "scene_darkest", "sky_lines", "sky_darkest", "dome_shade"}) json.erase(key);
  ASSERT_TRUE(write_text_file(file, json.dump()));
  const auto keep = [&](const char* name, const GreyImage& still, const Camera& camera) {
    ASSERT_EQ(shrink_factor(camera), 1);
    Image<Rgb8> picture(still.width(), still.height());
    for (std::size_t i = 0; i < still.elements().size(); ++i) picture.elements()[i] = Rgb8(still.elements()[i]);
    ASSERT_TRUE(write_png(stem.string() + name, picture));
  };
  keep(".check-scene.png", median_of(frames.scene()), installation.scene);
  keep(".check-sky.png", median_of(frames.sky()), installation.sky);
  ASSERT_TRUE(replace_kept_pictures(stem, installation));
  for (const auto& entry : std::filesystem::directory_iterator(stem.parent_path()))
    EXPECT_EQ(entry.path().string(), file);
  const auto made = must(load_reference(stem, installation));
  ASSERT_TRUE(made->scene && made->sky);
  EXPECT_EQ(made->taken, reference().taken);
  EXPECT_EQ(made->scene->lines.strength.elements(), reference().scene->lines.strength.elements());
  EXPECT_EQ(made->sky->darkest.places, reference().sky->darkest.places);
  EXPECT_EQ(made->scene->edges.size(), reference().scene->edges.size());
}

}  // namespace
}  // namespace kasumi

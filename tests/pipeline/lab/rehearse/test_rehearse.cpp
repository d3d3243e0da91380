// `kasumi rehearse`: hours and airs at the site, before a camera is mounted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "base/files.hpp"
#include "base/picture_files/picture_file.hpp"
#include "pipeline/lab/rehearse/rehearsed_view.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using std::chrono::local_days;
using std::chrono::sys_days;
using testing::HasSubstr;

constexpr std::chrono::year k2026{2026};

TEST(Rehearse, HoursAreThoseOfTheWallClock) {
  using std::chrono::July, std::chrono::January;
  EXPECT_EQ(utc_of(local_days(k2026 / July / 1) + 12h, "Europe/Zurich", 8.5), sys_days(k2026 / July / 1) + 10h);
  EXPECT_EQ(utc_of(local_days(k2026 / January / 1) + 12h, "Europe/Zurich", 8.5), sys_days(k2026 / January / 1) + 11h);
  EXPECT_EQ(utc_of(local_days(k2026 / July / 1) + 12h, "", 135.0), sys_days(k2026 / July / 1) + 3h);
  EXPECT_EQ(utc_of(local_days(k2026 / July / 1) + 12h, "", -60.0), sys_days(k2026 / July / 1) + 16h);
}

TEST(Rehearse, PicturesDarkenWithTwilight) {
  const auto at = [](double up_deg) {
    return brightness_under(direction_from(from_degrees(90.0 - up_deg), Radians{0.0}));
  };
  EXPECT_EQ(at(40.0), 1.0);
  EXPECT_NEAR(at(6.0), 1.0, 1e-9);
  EXPECT_NEAR(at(-1.9), 0.243, 0.001) << "Nara, 21 December, 17:00";
  EXPECT_NEAR(at(-3.0), 0.1995, 1e-4);
  EXPECT_NEAR(at(-5.7), 0.01995, 1e-5);
  EXPECT_LT(at(-18.0), 1e-5);
}

// A white house of 40 m whose corner points to the camera, which looks north at it.
Model corner_house() {
  Model model;
  model.materials.emplace_back();
  model.materials[0].base_colour = {0.7F, 0.7F, 0.7F, 1.0F};
  for (int side = 0; side < 4; ++side) {
    const float turn = 1.5707963F * static_cast<float>(side) + 0.7853982F;
    const glm::vec3 out{std::sin(turn), 0, std::cos(turn)}, along{out.z, 0, -out.x};
    ModelPart wall;
    for (const glm::vec2 at : {glm::vec2(-20, 0), glm::vec2(20, 0), glm::vec2(20, 30), glm::vec2(-20, 30)})
      wall.vertices.push_back({.position = 20.0F * out + at.x * along + glm::vec3(0, at.y, 0), .normal = out});
    wall.indices = {0, 1, 2, 0, 2, 3};
    model.parts.push_back(wall);
  }
  return model;
}

Installation lookout(double distance_m, double focal_px) {
  Installation kiosk;
  kiosk.site = {"", 46.9, 8.3, 450.0};
  kiosk.surroundings.sky_model = DaylightModel::dome;
  kiosk.scene.name = "scene";
  kiosk.scene.width = 160;
  kiosk.scene.height = 90;
  kiosk.scene.lens = pinhole_lens({{focal_px, focal_px}, {79.5, 44.5}, {}});
  kiosk.scene.to_world = camera_to_world(Radians{0.0}, Radians{0.0}, Radians{0.0});
  kiosk.object.placement.north_m = distance_m;
  kiosk.object.placement.up_m = -15.0;
  return kiosk;
}

double mean_green(const Image<Rgb8>& picture, int left, int top, int right, int bottom) {
  double sum = 0.0;
  for (int y = top; y < bottom; ++y)
    for (int x = left; x < right; ++x) sum += picture.at(x, y).g;
  return sum / ((right - left) * (bottom - top));
}

TEST(Rehearse, TheMorningLightsTheEastAndTheAfternoonTheWest) {
  auto context = open_headless_context();
  if (!context) GTEST_SKIP() << context.error().message;
  const auto kiosk = lookout(400.0, 600.0);  // 60 pixels of it to each side of the corner
  const Model house = corner_house();
  auto view = must(RehearsedView::create(**context, kiosk, house, Turbidity{2.0}));
  const auto noon = utc_of(local_days(k2026 / 3 / 21) + 12h, "", kiosk.site.longitude_deg);
  const auto morning = must(view->draw(noon - 4h)), afternoon = must(view->draw(noon + 4h));
  const auto east = [](const Image<Rgb8>& p) { return mean_green(p, 90, 40, 105, 55); };
  const auto west = [](const Image<Rgb8>& p) { return mean_green(p, 55, 40, 70, 55); };
  EXPECT_GT(east(*morning), 1.2 * west(*morning));
  EXPECT_GT(west(*afternoon), 1.2 * east(*afternoon));
  // What was drawn before leaves nothing behind.
  const auto again = must(view->draw(noon - 4h));
  EXPECT_NEAR(east(*again), east(*morning), 1.0);
  const auto night = must(view->draw(noon + 12h));
  EXPECT_LT(mean_green(*night, 0, 0, 160, 90), 5.0);
}

TEST(Rehearse, ASmallerCameraSeesTheSame) {
  auto kiosk = lookout(400.0, 600.0);
  kiosk.scene.mask = Image<std::uint8_t>(160, 90, 255);
  kiosk.scene.mask.at(3, 3) = 0;
  const auto small = with_small_scene(kiosk, 40);
  EXPECT_EQ(small.scene.width, 40);
  EXPECT_EQ(small.scene.height, 22);
  EXPECT_EQ(small.scene.mask.width(), 40);
  for (const glm::dvec2 pixel : {glm::dvec2(0, 0), glm::dvec2(79.5, 44.5), glm::dvec2(120, 20)}) {
    const auto seen = must(small.scene.pixel_of(*must(kiosk.scene.direction_at(pixel))));
    EXPECT_NEAR(seen->x, (pixel.x + 0.5) / 4.0 - 0.5, 1e-9);
    EXPECT_NEAR(seen->y, (pixel.y + 0.5) * 22.0 / 90.0 - 0.5, 1e-9);
  }
  EXPECT_EQ(with_small_scene(kiosk, 160).scene.width, 160);
}

TEST(Rehearse, HazePalesWhatIsFar) {
  auto context = open_headless_context();
  if (!context) GTEST_SKIP() << context.error().message;
  auto kiosk = lookout(6000.0, 9000.0);
  Model house = corner_house();
  house.materials[0].base_colour = {0.05F, 0.05F, 0.05F, 1.0F};  // dark
  const auto noon = utc_of(local_days(k2026 / 6 / 21) + 12h, "", kiosk.site.longitude_deg);
  double before = 0.0;
  for (const double turbidity : {2.0, 3.0, 8.0}) {
    auto view = must(RehearsedView::create(**context, kiosk, house, Turbidity{turbidity}));
    const auto picture = must(view->draw(noon));
    const double dark = mean_green(*picture, 60, 35, 100, 55);
    EXPECT_GT(dark, before + 10.0) << turbidity;
    before = dark;
  }
}

TEST(Rehearse, WritesASheetForEachAir) {
  const auto out = test_folder("rehearsal");
  std::filesystem::remove_all(out);
  const auto demo = source_folder() / "fixtures/demo";
  const auto done = ended(0, run_kasumi(fmt::format("rehearse {} --hours 0,12 --out {}", demo.string(), out.string())));
  EXPECT_THAT(done.out, HasSubstr("by the mean sun of the site"));
  for (const char* name : {"clear.png", "usual.png", "hazy.png"}) {
    const auto sheet = to_rgb8(*must(read_photograph(out / name)));
    const int width = sheet.width() / 2, height = sheet.height() / 12;
    EXPECT_LT(mean_green(sheet, 10, 60, width - 10, height - 10), 10.0) << name << ": midnight in January";
    EXPECT_GT(mean_green(sheet, width + 10, 60, 2 * width - 10, height - 10), 60.0) << name << ": noon in January";
  }
  EXPECT_THAT(run_kasumi("rehearse " + demo.string() + " --hours 24 --out " + out.string()).err, HasSubstr("--hours"));
  EXPECT_THAT(ended(2, run_kasumi("rehearse /no/such.toml --out " + out.string())).err, HasSubstr("/no/such.toml"));
}

// Two stories in two languages: where the panels are, the sheets differ, and nowhere else.
TEST(Rehearse, WritesASheetOfTheStoriesForEachLanguage) {
  const auto folder = test_folder("rehearsal-stories"), out = folder / "out";
  std::filesystem::remove_all(folder);
  const auto config = write_config(folder, "trusted", source_folder() / "fixtures/demo");
  replace_in(config, "[", "content = \"content.toml\"\n[");
  ASSERT_TRUE(write_text_file(folder / "content.toml",
                              "languages = [\"en\", \"ja\"]\n[[story]]\nname = \"gate\"\nplace_m = [0, 3, 0]\n"
                              "title = { en = \"The gate\", ja = \"門\" }\n"
                              "text = { en = \"Built in 730.\", ja = \"天平二年に建てられた。\" }\n"
                              "[[story]]\nname = \"roof\"\nplace_m = [0, 20, 0]\n"
                              "title = { en = \"Five roofs\", ja = \"五重の屋根\" }\n"
                              "text = { en = \"They swing.\", ja = \"揺れる。\" }\n"));
  const auto done = ended(0, run_kasumi(fmt::format("rehearse {} --hours 12 --out {}", config.string(), out.string())));
  EXPECT_THAT(done.out, HasSubstr("stories-en.png"));
  const auto english = to_rgb8(*must(read_photograph(out / "stories-en.png"))),
             japanese = to_rgb8(*must(read_photograph(out / "stories-ja.png")));
  ASSERT_EQ(english.width(), japanese.width());
  EXPECT_GT(english.width(), 2 * 900) << "two beside each other, to be read";
  ASSERT_EQ(english.height(), japanese.height());
  std::array<int, 4> differing{};  // quarters of the width
  for (int y = 0; y < english.height(); ++y)
    for (int x = 0; x < english.width(); ++x)
      if (std::abs(english.at(x, y).g - japanese.at(x, y).g) > 24)
        ++differing[static_cast<std::size_t>(4 * x / english.width())];
  EXPECT_GT(differing[0], 200) << "the gate's panel on the left";
  EXPECT_GT(differing[2], 200) << "the roof's in the other tile";
  EXPECT_EQ(differing[1], 0) << "the building's half";
  EXPECT_EQ(differing[3], 0);
}

}  // namespace
}  // namespace kasumi

// A visitor's minute at the demo's kiosk, as pictures of the glass for docs/visitor.md.
#include <gtest/gtest.h>

#include <cstdlib>

#include "base/files.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/recorded.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

namespace fs = std::filesystem;

constexpr const char* kButtons =
    "\n[visitor]\ndevices = [\"/dev/input/by-id/usb-Buttons-event-kbd\"]\nthen_and_now = [\"KEY_1\"]\n"
    "era = [\"KEY_2\"]\nlanguage = [\"KEY_3\"]\nstory = [\"KEY_4\"]\n"
    "hints = [\"then_and_now\", \"era\", \"language\", \"story\"]\n"
    "[opening]\ntime_zone = \"UTC\"\n[[era]]\nname = \"pagoda\"\nhours = \"00:00-24:00\"\n"
    "[[era]]\nname = \"gate\"\nvisitors_only = true\nmodel = \"temple.glb\"\n";
constexpr const char* kTexts =
    "languages = [\"en\", \"de\"]\n[[era]]\nname = \"pagoda\"\ntitle = { en = \"Around 750\", de = \"Um 750\" }\n"
    "[[era]]\nname = \"gate\"\ntitle = { en = \"Around 1100\", de = \"Um 1100\" }\n"
    "[[story]]\nname = \"roof\"\nplace_m = [0, 20, 0]\ntitle = { en = \"Five roofs\", de = \"Fünf Dächer\" }\n"
    "text = { en = \"One pillar stands in the middle and carries none of them: the roofs swing about it in an "
    "earthquake.\", de = \"In der Mitte steht ein Pfeiler, der keines davon trägt: Bei einem Erdbeben schwingen die "
    "Dächer um ihn.\" }\n";

// KASUMI_VISITORS_MINUTE names a folder, which gets a PNG of each step.
TEST(VisitorsMinute, IsSeenOnTheGlass) {
  const char* seen = std::getenv("KASUMI_VISITORS_MINUTE");
  if (!seen) GTEST_SKIP() << "only for docs/make-pictures";
  const auto folder = test_folder("appliance-visitors-minute");
  fs::remove_all(folder);
  fs::create_directories(folder);
  fs::copy_file(source_folder() / "fixtures/temple.glb", folder / "temple.glb");
  ASSERT_TRUE(write_text_file(folder / "content.toml", kTexts));
  Rig rig({.name = "visitors-minute",
           .recording = source_folder() / "fixtures/demo",
           .more_config = kButtons,
           .first_config = "content = \"content.toml\"\n",
           .utc = std::chrono::sys_days{std::chrono::October / 20 / 2026} + 6h + 10min,
           .keep_folder = true});
  auto& buttons = rig.devices.input.devices["/dev/input/by-id/usb-Buttons-event-kbd"];
  const auto press = [&](int code, Duration held = 60ms) {
    buttons.key(code, true);
    rig.advance(held);
    buttons.key(code, false);
  };
  const auto keep = [&](const char* name) {
    ASSERT_TRUE(write_png(fs::path(seen) / (std::string(name) + ".png"), rig.picture()));
  };
  rig.advance(12s);
  ASSERT_EQ(rig.shown(), Shown::live);
  keep("1-nobody");
  buttons.key(KEY_1, true);
  rig.advance(1s);
  keep("2-now");
  buttons.key(KEY_1, false);
  rig.advance(750ms);
  keep("3-gliding-back");
  rig.advance(2s);
  press(KEY_4);
  rig.advance(4s);
  keep("4-story");
  press(KEY_3);
  rig.advance(1s);
  keep("5-language");
  press(KEY_4);
  press(KEY_2);
  ASSERT_TRUE(rig.advance_until([&] { return rig.status().era == "gate"; }, 30s));
  rig.advance(5s);
  keep("6-era");
  ASSERT_TRUE(rig.advance_until([&] { return rig.status().era == "pagoda"; }, 90s)) << "without a hand";
  rig.advance(3s);
  keep("7-as-before");
}

}  // namespace
}  // namespace kasumi

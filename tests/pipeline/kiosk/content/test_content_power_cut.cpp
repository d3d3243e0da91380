// The power goes at any moment of an installation, and with it whatever had not been written through: the content that
// the next boot shows is the old or the new, and whole (fault 22).
#include <gtest/gtest.h>

#include <random>

#include "tests/base/power_cut.hpp"
#include "tests/pipeline/kiosk/content/desk.hpp"

namespace kasumi {
namespace {

namespace fs = std::filesystem;

// `cuts` random instants, each with every way in which the disk may have been behind.
void at_random_cuts(const PowerCut& power, int cuts, const fs::path& found,
                    const std::function<void(std::size_t)>& check) {
  std::mt19937 random(22);
  std::uniform_int_distribution<std::size_t> instant(0, power.calls());
  for (int cut = 0; cut < cuts; ++cut) {
    const auto calls = cut == 0 ? power.calls() : instant(random);
    for (const auto left : PowerCut::kAll) {
      SCOPED_TRACE(fmt::format("cut after {} of {} calls, left over {}", calls, power.calls(), static_cast<int>(left)));
      power.lay_out(calls, left, found);
      check(calls);
    }
  }
}

struct Cut : testing::Test {
  Cut() : folder(content_folder("power-cut")), generations(folder / "disk/content") {
    const auto config = write_desk(folder / "desk");
    spring = install_file(packed(config, "Spring", kMonday), generations, kMonday)->generation.id;
    EXPECT_TRUE(generations.note_proven(spring, kMonday));
    replace_in(config, "The view returns in a moment.", "Summer");
    bundle = packed(config, "Summer", kMonday + 1h);
  }
  // What a boot finds there: whose content, and that it is whole.
  std::string found() const {
    const Generations there(folder / "found/content");
    const auto current = there.current();
    if (!current) return "nothing";
    const auto whole = check_unpacked(there.folder_of(*current), current->manifest);
    EXPECT_TRUE(whole) << whole.error().message;
    const auto text = read_text_file(there.folder_of(*current) / kManifestName);
    EXPECT_EQ(content_id(text.value_or("")), current->id);
    return current->manifest.name;
  }
  fs::path folder, bundle;
  Generations generations;
  std::string spring;
};

TEST_F(Cut, Row22AnInstallationLeavesTheOldContentOrTheNewAndWhole) {
  const PowerCut power(folder / "disk");
  const auto installed = install_file(bundle, generations, kMonday + 2h);
  ASSERT_TRUE(installed) << installed.error().message;
  int old = 0, fresh = 0;
  at_random_cuts(power, 100, folder / "found", [&](std::size_t calls) {
    const auto name = found();
    EXPECT_TRUE(name == "Spring" || name == "Summer") << name;
    if (calls == power.calls()) {
      EXPECT_EQ(name, "Summer") << "it was told that it is installed";
    }
    ++(name == "Spring" ? old : fresh);
    const Generations there(folder / "found/content");
    EXPECT_TRUE(there.find(spring) && there.find(spring)->proven) << "and there is a way back";
    // The next installation finds nothing in its way.
    if (calls % 7 == 0) {
      const auto again = install_file(bundle, there, kMonday + 3h);
      EXPECT_TRUE(again) << again.error().message;
      EXPECT_EQ(found(), "Summer");
    }
  });
  std::printf("22 power cut x100 while content is installed: %d times the old content, %d times the new\n", old, fresh);
  EXPECT_GT(old, 50);
  EXPECT_GT(fresh, 3);
}

TEST_F(Cut, Row22SoDoesGoingBack) {
  const auto summer = install_file(bundle, generations, kMonday + 2h)->generation.id;
  const PowerCut power(folder / "disk");
  ASSERT_TRUE(generations.go_back(summer, kMonday + 3h, "no pictures"));
  at_random_cuts(power, 25, folder / "found", [&](std::size_t calls) {
    const auto name = found();
    EXPECT_TRUE(name == "Spring" || name == "Summer") << name;
    if (calls == power.calls()) {
      EXPECT_EQ(name, "Spring");
    }
    if (name == "Spring") {
      const auto gone = Generations(folder / "found/content").find(summer);
      EXPECT_TRUE(gone && gone->went_back) << "and why";
    }
  });
}

}  // namespace
}  // namespace kasumi

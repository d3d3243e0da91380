// People before the building, as a visitor sees them: a recording with somebody who walks past its foot, played through
// the whole appliance. Who he is and where the building stands is told by the generator, not by what is tested.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "base/picture_files/picture_file.hpp"
#include "capture/fixture/fixture.hpp"
#include "tests/pipeline/kiosk/appliance/reloading.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

constexpr Duration kLoop = 24s;               // of the recording; the walker is seen in the second half
constexpr double kBuildingIsLeftOut = 0.001;  // at most, where nobody stands
constexpr int kAround_px = 6;                 // of the walker: a fringe of the camera's picture is his

using Coverage = Image<std::uint8_t>;

fixtures::Recipe recipe() {
  auto made = small("clear-noon", 24);
  made.scene_width = 320;
  made.scene_height = 180;
  made.scene_period_s = 1.0;
  made.outlook.field_of_view_deg = 4.0;
  made.outlook.pitch_deg = -0.2;
  made.sky_frames = 2;
  made.sky_period_s = 1.0;
  made.sky_size = 240;
  made.truth_frames = 1;
  made.passersby.people = 1;
  return made;
}

Coverage coverage(const std::filesystem::path& file) {
  const auto read = decode_png(read_file(file).value()).value();
  Coverage made(read.width, read.height);
  for (std::size_t i = 0; i < made.elements().size(); ++i) made.elements()[i] = read.samples[i * read.channels];
  return made;
}

// The sky's frames again and again at the scene's rate, so that the recording is a loop without a gap.
void fill_sky(const std::filesystem::path& folder) {
  const auto rows = read_index(folder).value();
  std::string text = std::string(kIndexHeader) + "\n";
  for (std::size_t number = 0; number < static_cast<std::size_t>(recipe().scene_frames); ++number) {
    IndexRow row = rows[number % rows.size()];
    row.metadata.captured_at = rows[0].metadata.captured_at + number * 1s;
    row.metadata.utc = rows[0].metadata.utc + number * 1s;
    row.metadata.sequence = static_cast<std::uint32_t>(number);
    text += index_line(row) + "\n";
  }
  ASSERT_TRUE(write_text_file(folder / "index.csv", text));
}

struct Recording {
  std::filesystem::path folder;
  std::vector<Image<Rgb8>> frames;
  std::vector<Coverage> walker;  // of each frame
  Coverage building;
};

const Recording& recording() {
  static const Recording whole = [] {
    Recording made;
    made.folder = recorded(recipe(), "people-before-the-building");
    fill_sky(made.folder / "sky");
    made.building = coverage(made.folder / "truth" / "coverage-000000.png");
    const auto rows = read_index(made.folder / "scene").value();
    for (const auto& row : rows) {
      const Frame frame{row.metadata, payload_of(read_file(made.folder / "scene" / row.payload).value())};
      const auto who = made.folder / "truth" / fmt::format("passers-{:06}.png", made.frames.size());
      made.walker.push_back(std::filesystem::exists(who) ? coverage(who) : Coverage(320, 180, 0));
      made.frames.push_back(to_rgb(decode(frame, YuvEncoding::bt601_full).value().view()));
    }
    return made;
  }();
  return whole;
}

// As if somebody had turned the camera: 24 pixels to the right and 10 down.
constexpr std::size_t kTurned_px = 10 * 320 + 24;
void turn(Frame& frame) {
  const auto was = frame.payload.bytes;
  std::vector<std::uint8_t> bytes(was.begin(), was.end());
  std::ranges::rotate(bytes, bytes.begin() + 3 * kTurned_px);
  frame.payload = payload_of(std::move(bytes));
}

struct Seen {
  double walker_px = 0.0, camera_px = 0.0;  // of the walker where he is before the building; of these as the camera's
  double worst = 1.0;                       // share of them in a picture
  double building_px = 0.0, holes_px = 0.0,
         most_holes_px = 0.0;  // of the building where nobody is near; of these as the camera's
  double camera_share() const { return camera_px / walker_px; }
  double hole_share() const { return holes_px / building_px; }
  void print(const char* when) const {
    std::printf(
        "%s: %.1f %% of the walker's %.0f pixels are the camera's, %.1f %% in the worst picture; %.4f %% of %.0f "
        "of the building's are, %.0f at most\n",
        when, 100.0 * camera_share(), walker_px, 100.0 * worst, 100.0 * hole_share(), building_px, most_holes_px);
  }
};

bool any_near(const Coverage& who, int column, int row) {
  for (int y = std::max(0, row - kAround_px); y <= std::min(who.height() - 1, row + kAround_px); ++y)
    for (int x = std::max(0, column - kAround_px); x <= std::min(who.width() - 1, column + kAround_px); ++x)
      if (who.at(x, y)) return true;
  return false;
}

class PeopleBefore : public testing::Test {
 protected:
  static std::unique_ptr<Rig> rig(const std::string& name) {
    auto made =
        std::make_unique<Rig>(RigOptions{.name = name, .recording = recording().folder, .utc = recipe().start_utc});
    EXPECT_TRUE(made->advance_until([&] { return made->shown() == Shown::live; }, 30s));
    made->advance(kLoop, kStep);
    EXPECT_TRUE(made->status().render.building_drawn);
    return made;
  }

  // A turn of the recording, live all the time.
  static Seen watch(Rig& rig) {
    Seen seen;
    watch(rig, seen);
    return seen;
  }
  static void watch(Rig& rig, Seen& seen) {
    for (Duration t{}; t < kLoop && !testing::Test::HasFatalFailure(); t += kStep) {
      rig.advance(kStep, kStep);
      EXPECT_EQ(rig.shown(), Shown::live);
      look(rig, seen);
    }
    EXPECT_GT(seen.building_px, 20'000.0);
  }

  // The reload's problems; the picture is live all the time.
  static std::vector<std::string> reload(Rig& rig) {
    const auto problems = problems_of_reload(rig);
    const auto pictures = rig.status().render.pictures;
    rig.advance(4s, kStep);
    EXPECT_GE(rig.status().render.pictures, pictures + 3) << "the picture stands still";
    EXPECT_TRUE(rig.status().render.building_drawn);
    return problems;
  }
  static void switch_key(Rig& rig, bool on) {
    const std::string with = "[scene]\npeople_in_front = true\n", without = "[scene]\n";
    on ? replace_in(rig.config, without, with) : replace_in(rig.config, with, without);
    EXPECT_TRUE(reload(rig).empty());
  }

  static std::optional<PassersState> state(Rig& rig) {
    const auto& passers = rig.status().render.passers;
    return passers ? std::optional(passers->state) : std::nullopt;
  }
  static void await(Rig& rig, PassersState wanted, Duration longest) {
    Duration t{};
    for (; state(rig) != wanted && t < longest; t += kStep) {
      rig.advance(kStep, kStep);
      EXPECT_EQ(rig.shown(), Shown::live);
    }
    EXPECT_EQ(state(rig), wanted);
    std::printf("%s after %.0f s\n", std::string(name_of(wanted)).c_str(), to_seconds(t));
  }

  static bool turned_;
  void TearDown() override { turned_ = false; }

 private:
  static constexpr Duration kStep = 500ms;

  static Image<Rgb8> frame(std::size_t number) {
    Image<Rgb8> made = recording().frames[number];
    if (turned_) std::ranges::rotate(made.elements(), made.elements().begin() + kTurned_px);
    return made;
  }

  static void look(Rig& rig, Seen& seen) {
    const Image<Rgb8> picture = rig.picture();
    ASSERT_EQ(picture.width(), 320);
    // Which of the recorded frames it is, is told by what is beside the building.
    std::size_t number = 0;
    Image<Rgb8> camera;
    const auto is_it = [&] {
      for (int y = 0; y < 180; ++y)
        for (int x = 0; x < 150; ++x)
          if (picture.at(x, y) != camera.at(x, y)) return false;
      return true;
    };
    for (;; ++number) {
      ASSERT_LT(number, recording().frames.size()) << "not a picture of the recording";
      camera = frame(number);
      if (is_it()) break;
    }
    Coverage who = recording().walker[number];
    if (turned_) std::ranges::rotate(who.elements(), who.elements().begin() + kTurned_px);
    const auto same = [&](int x, int y) { return picture.at(x, y) == camera.at(x, y); };
    double walker_px = 0.0, camera_px = 0.0, holes_px = 0.0;
    for (int y = 1; y < 179; ++y)
      for (int x = 1; x < 319; ++x) {
        if (recording().building.at(x, y) < 255) continue;
        if (who.at(x, y) == 255) {
          walker_px += 1.0;
          camera_px += same(x, y);
        } else if (!any_near(who, x, y)) {
          seen.building_px += 1.0;
          // One pixel alone is the same by chance.
          holes_px += same(x, y) && same(x - 1, y) && same(x + 1, y) && same(x, y - 1) && same(x, y + 1);
        }
      }
    seen.holes_px += holes_px;
    seen.most_holes_px = std::max(seen.most_holes_px, holes_px);
    if (walker_px < 100.0) return;
    seen.walker_px += walker_px;
    seen.camera_px += camera_px;
    seen.worst = std::min(seen.worst, camera_px / walker_px);
  }
};
bool PeopleBefore::turned_ = false;

// Path and size of everything in a folder.
std::map<std::string, std::uintmax_t> files_in(const std::filesystem::path& folder) {
  std::map<std::string, std::uintmax_t> found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) found[entry.path().lexically_relative(folder)] = entry.file_size();
  return found;
}

TEST_F(PeopleBefore, StayInFrontWhileTheKeySaysSoAndNothingOfThemIsKept) {
  const auto rig = PeopleBefore::rig("people");
  EXPECT_EQ(state(*rig), std::nullopt);
  const Seen over = watch(*rig);
  over.print("off");
  ASSERT_GT(over.walker_px, 500.0);
  EXPECT_LT(over.camera_share(), 0.1) << "the building is to cover him";
  EXPECT_LE(over.hole_share(), kBuildingIsLeftOut);
  rig->advance(60s, 500ms);  // the history's first line
  const auto files = files_in(rig->folder);
  EXPECT_TRUE(files.contains("state/turbidity.json") && files.contains("state/history.txt"));

  switch_key(*rig, true);
  EXPECT_EQ(state(*rig), PassersState::learning);
  await(*rig, PassersState::watching, 180s);
  rig->advance(kLoop, 500ms);
  const Seen kept = watch(*rig);
  kept.print("on");
  EXPECT_GT(kept.walker_px, 500.0);
  EXPECT_GE(kept.worst, 0.95);
  EXPECT_LE(kept.hole_share(), kBuildingIsLeftOut);
  // In the state folder and beside it lies what lay there without the key, no file of it larger by more than a few
  // lines.
  const auto files_then = files_in(rig->folder);
  for (const auto& [path, bytes] : files_then) {
    const auto before = files.find(path);
    EXPECT_NE(before, files.end()) << path << " is new";
    if (before != files.end() && path != "status.json") {
      EXPECT_LE(bytes, before->second + 1024) << path;
    }
  }

  switch_key(*rig, false);
  EXPECT_EQ(state(*rig), std::nullopt);
  const Seen again = watch(*rig);
  again.print("off again");
  EXPECT_LT(again.camera_share(), 0.1);
  EXPECT_LE(again.hole_share(), kBuildingIsLeftOut);
}

TEST_F(PeopleBefore, AreToldFromTheNewSceneAfterTheCameraWasTurned) {
  const auto rig = PeopleBefore::rig("people-elsewhere");
  switch_key(*rig, true);
  await(*rig, PassersState::watching, 180s);
  rig->devices.scene.spoil = turn;
  turned_ = true;
  rig->advance(2s, 500ms);
  EXPECT_EQ(state(*rig), PassersState::unsettled);
  Seen meanwhile;
  for (int loop = 0; loop < 8; ++loop) watch(*rig, meanwhile);
  meanwhile.print("turned, and three minutes on");
  EXPECT_LE(meanwhile.hole_share(), kBuildingIsLeftOut);
  EXPECT_EQ(state(*rig), PassersState::watching);
  const Seen kept = watch(*rig);
  kept.print("turned, learnt anew");
  EXPECT_GE(kept.worst, 0.95);
  EXPECT_LE(kept.hole_share(), kBuildingIsLeftOut);
}

TEST_F(PeopleBefore, AreToldFromAnotherSceneWhereTheBuildingStandsElsewhere) {
  const auto rig = PeopleBefore::rig("people-other-place");
  switch_key(*rig, true);
  await(*rig, PassersState::watching, 180s);
  EXPECT_TRUE(reload(*rig).empty());
  EXPECT_EQ(state(*rig), PassersState::watching) << "the same scene is not forgotten over a reload";
  auto text = read_text_file(rig->config).value();
  const std::string key = "east_m = ";
  const auto at = text.find(key, text.find("[object]")) + key.size();
  text.replace(at, text.find('\n', at) - at, fmt::format("{:.2f}", std::stod(text.substr(at)) - 25.0));
  ASSERT_TRUE(write_text_file(rig->config, text));
  EXPECT_TRUE(reload(*rig).empty());
  EXPECT_EQ(state(*rig), PassersState::learning) << "what stood beside another building is not known";
}

}  // namespace
}  // namespace kasumi

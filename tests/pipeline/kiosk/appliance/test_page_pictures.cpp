// The blurred picture that kasumi-report may ask for: only where it is allowed, nothing sharp in it, told to visitors, once a
// minute; and peers that mean no good.
#include <atomic>
#include <cmath>
#include <functional>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "base/picture_files/picture_file.hpp"
#include "base/socket/local_socket.hpp"
#include "base/socket/screen_answer.hpp"
#include "base/utc_text.hpp"
#include "pipeline/kiosk/snapshot/blurred_picture.hpp"
#include "pipeline/site/config/messages.hpp"
#include "tests/must.hpp"
#include "tests/picture_difference.hpp"
#include "tests/pipeline/kiosk/appliance/glass.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/kiosk/appliance/safe_rig.hpp"

namespace kasumi {
namespace {

constexpr const char* kAllowed = "\n[snapshot]\nscreen_picture = true\n";

// The appliance's snapshot thread, beside the test's, which turns the clock.
class Served {
 public:
  explicit Served(Rig& rig)
      : Served(rig.appliance->snapshot(), rig.appliance->snapshot_bell(), rig.folder,
               [&rig] { rig.advance(Rig::kTick); }) {}
  explicit Served(SafeRig& rig)
      : Served(rig.safe->snapshot(), rig.safe->snapshot_bell(), rig.folder, [&rig] { rig.advance(Rig::kTick); }) {}
  ~Served() {
    done_ = true;
    bell_.ring();
    serves_.join();
  }

  bool offers() const { return std::filesystem::exists(path_); }
  // Once the thread had its turn, within seconds.
  bool comes_to(bool offered) const {
    for (int i = 0; i < 500 && offers() != offered; ++i) std::this_thread::sleep_for(10ms);
    return offers() == offered;
  }
  UniqueFd connected() const {
    EXPECT_TRUE(comes_to(true)) << "no socket";
    auto socket = connect_to(path_);
    EXPECT_TRUE(socket) << socket.error().message;
    return socket ? std::move(*socket) : UniqueFd();
  }
  // What comes of a call, while the clock turns.
  Result<ScreenAnswer> answer(const UniqueFd& socket) const {
    const auto until = std::chrono::steady_clock::now() + 60s;
    Result<std::string> line = fail(FaultKind::timeout, "");
    while (!line && line.error().kind == FaultKind::timeout && std::chrono::steady_clock::now() < until) {
      turn_();
      line = read_line_within(socket, kLongestScreenLine, 10ms);
    }
    if (!line) return fail(line.error());
    auto answer = parse_screen_line(*line);
    if (!answer || answer->picture.empty()) return answer;
    const auto bytes = read_bytes_within(socket, 3 * answer->picture.elements().size(), 5s);
    if (!bytes) return fail(bytes.error());
    std::copy(bytes->begin(), bytes->end(), reinterpret_cast<char*>(answer->picture.elements().data()));
    EXPECT_EQ(read_bytes_within(socket, 1, 5s).error().kind, FaultKind::disconnected) << "and no more";
    return answer;
  }
  Result<ScreenAnswer> ask() const { return answer(connected()); }

 private:
  Served(SnapshotServer& server, Bell& bell, const std::filesystem::path& folder, std::function<void()> turn)
      : bell_(bell), path_(screen_socket(folder)), turn_(std::move(turn)), serves_([this, &server] {
          while (!done_) server.step();
        }) {}

  Bell& bell_;
  std::filesystem::path path_;
  std::function<void()> turn_;
  std::atomic<bool> done_ = false;
  std::thread serves_;
};

// Between the darkest and the brightest of the lower rows, which words at the top do not reach, away from the edges.
int contrast(const Image<Rgb8>& picture) {
  int lowest = 255, highest = 0;
  for (int y = picture.height() * 3 / 5; y < picture.height() * 9 / 10; ++y)
    for (int x = picture.width() / 8; x < picture.width() * 7 / 8; ++x) {
      lowest = std::min<int>(lowest, picture.at(x, y).g);
      highest = std::max<int>(highest, picture.at(x, y).g);
    }
  return highest - lowest;
}

TEST(PagePicture, ThereIsNoSocketUnlessItIsAllowed) {
  Rig rig({.name = "page"});
  rig.advance(1s);
  rig.appliance->snapshot().step();
  EXPECT_FALSE(std::filesystem::exists(screen_socket(rig.folder)));
  EXPECT_FALSE(parse_json(status_json(rig.status()))["screen_picture"]["allowed"].get<bool>());
}

TEST(PagePicture, IsWhatTheGlassShowsAndVisitorsAreTold) {
  auto rig = running({.name = "page", .more_config = kAllowed});
  const auto before = rig->picture();
  const Served served(*rig);
  const auto answer = must(served.ask());
  EXPECT_FALSE(answer->wait);
  const auto expected = blurred_beyond_recognition(before);
  ASSERT_EQ(answer->picture.width(), expected.width());
  ASSERT_EQ(answer->picture.height(), expected.height());
  Image<Rgb8> lower(expected.width(), expected.height() / 2), seen = lower;
  std::copy(expected.row(expected.height() - lower.height()), expected.row(0) + expected.elements().size(),
            lower.row(0));
  std::copy(answer->picture.row(expected.height() - lower.height()),
            answer->picture.row(0) + expected.elements().size(), seen.row(0));
  EXPECT_LE(difference(seen, lower).mean, 3.0) << "below the words it is the picture that they see";
  EXPECT_LE(rig->clock.utc() - answer->utc, 2s);

  const auto told = [&] { return difference(upper_quarter(rig->picture()), upper_quarter(before)).mean > 5.0; };
  EXPECT_TRUE(told()) << "it is on the glass when it is taken";
  rig->advance(SnapshotDesk::kToldAfter - 1s);
  EXPECT_TRUE(told()) << "and for some seconds after";
  rig->advance(2s);
  EXPECT_FALSE(told());
  const auto status = parse_json(status_json(rig->status()))["screen_picture"];
  EXPECT_TRUE(status["allowed"].get<bool>());
  EXPECT_EQ(status["taken"], 1);
  EXPECT_EQ(status["last_utc"], utc_text(answer->utc));
}

TEST(PagePicture, IsTakenOnceAMinuteAndTheRestIsTold) {
  auto rig = running({.name = "page", .more_config = kAllowed});
  const Served served(*rig);
  ASSERT_TRUE(served.ask());
  const auto began = rig->clock.now();
  rig->advance(20s);
  const auto soon = must(served.ask());
  EXPECT_TRUE(soon->picture.empty());
  ASSERT_TRUE(soon->wait);
  EXPECT_NEAR(static_cast<double>(soon->wait->count()), 40.0, 3.0);
  rig->advance(*soon->wait);
  const auto next = must(served.ask());
  EXPECT_FALSE(next->picture.empty());
  EXPECT_GE(rig->clock.now() - began, 55s);
  rig->advance(1s);  // it tells its status twice a second
  EXPECT_EQ(rig->status().render.page_pictures.taken, 2u);
}

// Stripes of full contrast on the glass: of those closer together than two pixels of the picture nothing is left.
TEST(PagePicture, HoldsNothingThatTheBlurDoesNotLeave) {
  const auto left_of = [](double period_px, int& on_glass) {
    SafeRig rig("page-blur");
    replace_in(rig.config, "The view returns in a moment.", "");
    Image<Rgb8> stripes(320, 180);  // as the glass
    for (int y = 0; y < stripes.height(); ++y)
      for (int x = 0; x < stripes.width(); ++x)
        stripes.at(x, y) = Rgb8(std::fmod(x, period_px * 10.0) < period_px * 5.0 ? 0 : 255);
    EXPECT_TRUE(write_file(rig.folder / "still.png", encode_png(stripes).value()));
    EXPECT_TRUE(write_text_file(rig.config, read_text_file(rig.config).value() + kAllowed));
    rig.start();
    rig.advance(2s);
    on_glass = contrast(read_picture(*rig.safe->display()).value());
    const auto answer = Served(rig).ask();
    EXPECT_TRUE(answer && !answer->picture.empty());
    return answer ? contrast(answer->picture) : 255;
  };
  int on_glass = 0;
  for (const double period_px : {0.6, 1.0, 1.6, 2.0}) {
    const int left = left_of(period_px, on_glass);
    EXPECT_GE(on_glass, 250) << period_px;
    EXPECT_LE(left, 5) << period_px;
    std::printf("stripes %.1f pixels of the picture apart: %d of 255 on the glass, %d in what is sent\n", period_px,
                on_glass, left);
  }
  EXPECT_GE(left_of(16.0, on_glass), 200) << "what is large stays to be seen";
}

TEST(PagePicture, WhereNothingIsOnTheGlassThereIsNone) {
  Rig closed({.name = "page", .more_config = std::string(kAllowed) + "[opening]\nevery_day = \"closed\"\n"});
  closed.advance(4s);
  const auto dark = must(Served(closed).ask());
  EXPECT_TRUE(dark->picture.empty());
  EXPECT_FALSE(dark->wait);
  EXPECT_EQ(closed.status().render.page_pictures.taken, 0u);
}

TEST(PagePicture, ComesAndGoesWithTheConfiguration) {
  auto rig = running({.name = "page", .more_config = kAllowed});
  const Served served(*rig);
  EXPECT_TRUE(served.comes_to(true));
  replace_in(rig->config, "screen_picture = true", "screen_picture = false");
  rig->hang_up();
  EXPECT_TRUE(rig->advance_until([&] { return !rig->status().render.page_pictures.allowed; }, 60s));
  EXPECT_TRUE(served.comes_to(false));
}

TEST(PagePicture, PeersThatMeanNoGoodKeepNobodyOut) {
  auto rig = running({.name = "page", .more_config = kAllowed});
  const Served served(*rig);
  const auto pictures = rig->status().render.pictures;
  {
    const auto rubbish = served.connected();
    ASSERT_TRUE(write_within(rubbish, std::string(100'000, 'x'), 1s)) << "which nobody reads";
    ASSERT_TRUE(served.answer(rubbish));
  }
  for (int i = 0; i < 50; ++i) {  // who hangs up at once, and who never reads
    const auto gone = connect_to(screen_socket(rig->folder));
    rig->advance(Rig::kTick);
  }
  std::vector<UniqueFd> silent;
  for (int i = 0; i < 3; ++i)
    if (auto one = connect_to(screen_socket(rig->folder))) silent.push_back(std::move(*one));
  rig->advance(SnapshotDesk::kToldAfter + 1s);
  EXPECT_EQ(rig->status().render.page_pictures.taken, 1u);
  EXPECT_GT(rig->status().render.pictures, pictures + 5) << "the picture goes on";
  rig->advance(60s);
  const auto answer = must(served.ask());
  EXPECT_FALSE(answer->picture.empty());

  // `kasumi snapshot` is answered meanwhile.
  const auto socket = must(connect_to(rig->folder / kSnapshotSocket));
  ASSERT_TRUE(write_within(*socket, snapshot_request_line(SnapshotKind::blurred), 1s));
  Result<std::string> line = fail(FaultKind::timeout, "");
  for (int i = 0; i < 1000 && !line; ++i) {
    rig->advance(Rig::kTick);
    line = read_line_within(*socket, 10000, 10ms);
  }
  EXPECT_TRUE(line) << line.error().message;
}

TEST(ScreenAnswer, SaysWhatItMeansAndNothingElseIsTaken) {
  ScreenAnswer picture{Image<Rgb8>(2, 1, Rgb8(1, 10, 255)), *parse_utc("2026-06-21T12:00:00Z"), {}};
  EXPECT_EQ(screen_answer_bytes(picture), "picture 2 1 2026-06-21T12:00:00Z\n\x01\n\xff\x01\n\xff");
  const auto read = must(parse_screen_line("picture 32 18 2026-06-21T12:00:00Z"));
  EXPECT_EQ(read->picture.width(), 32);
  EXPECT_EQ(read->picture.height(), 18);
  EXPECT_EQ(read->utc, picture.utc);
  EXPECT_EQ(screen_answer_bytes({{}, {}, 37s}), "wait 37\n");
  EXPECT_EQ(parse_screen_line("wait 37")->wait, 37s);
  EXPECT_EQ(screen_answer_bytes({}), "nothing\n");
  EXPECT_TRUE(parse_screen_line("nothing")->picture.empty());
  for (const char* line : {"", "picture", "picture 33 18 2026-06-21T12:00:00Z", "picture 0 18 2026-06-21T12:00:00Z",
                           "picture 32 -1 2026-06-21T12:00:00Z", "picture 32 18 noon", "picture 32 18",
                           "picture  32 18 2026-06-21T12:00:00Z", "wait", "wait 0", "wait 61", "wait 1 ", "wait 1e1",
                           "nothing ", "HTTP/1.1 200 OK", "picture 99999999999 1 2026-06-21T12:00:00Z"})
    EXPECT_EQ(parse_screen_line(line).error().kind, FaultKind::bad_input) << line;
}

}  // namespace
}  // namespace kasumi

// `kasumi snapshot` and the appliance that answers it: what it gets, what visitors are told, what it cannot get.
#include <atomic>
#include <cmath>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/socket/local_socket.hpp"
#include "pipeline/kiosk/snapshot/blurred_picture.hpp"
#include "tests/must.hpp"
#include "tests/picture_difference.hpp"
#include "tests/pipeline/kiosk/appliance/glass.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"
#include "tests/pipeline/kiosk/appliance/safe_rig.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

// Whoever is asked, and what turns its clock.
struct Asked {
  Asked(Rig& rig)
      : server(rig.appliance->snapshot()),
        bell(rig.appliance->snapshot_bell()),
        folder(rig.folder),
        turn([&rig] { rig.advance(Rig::kTick); }) {}
  Asked(SafeRig& rig)
      : server(rig.safe->snapshot()),
        bell(rig.safe->snapshot_bell()),
        folder(rig.folder),
        turn([&rig] { rig.advance(Rig::kTick); }) {}

  SnapshotServer& server;
  Bell& bell;
  std::filesystem::path folder;
  std::function<void()> turn;
};

// Somebody who asks, while the appliance's snapshot thread runs beside the test's.
class Asking {
 public:
  Asking(Asked asked, SnapshotKind kind)
      : asked_(std::move(asked)),
        serves_([this] {
          while (!done_) asked_.server.step();
        }),
        asks_([this, kind] {
          answer_ = ask(kind);
          done_ = true;
        }) {}
  ~Asking() {
    done_ = true;
    asked_.bell.ring();
    asks_.join();
    serves_.join();
  }
  bool answered() const { return done_; }
  // Turns the clock until the answer is here.
  Result<Snapshot> wait() {
    const auto until = std::chrono::steady_clock::now() + 60s;
    while (!done_ && std::chrono::steady_clock::now() < until) asked_.turn();
    return done_ ? answer_ : fail(FaultKind::timeout, "no answer");
  }

 private:
  Result<Snapshot> ask(SnapshotKind kind) const {
    const auto socket = connect_to(asked_.folder / kSnapshotSocket);
    if (!socket) return fail(socket.error());
    if (auto sent = write_within(*socket, snapshot_request_line(kind), 5s); !sent) return fail(sent.error());
    const auto line = read_line_within(*socket, 10000, 30s);
    if (!line) return fail(line.error());
    auto header = parse_snapshot_header(*line);
    if (!header) return fail(header.error());
    const auto bytes = read_bytes_within(*socket, header->picture_bytes, 5s);
    if (!bytes) return fail(bytes.error());
    std::copy(bytes->begin(), bytes->end(), reinterpret_cast<char*>(header->snapshot.picture.elements().data()));
    return std::move(header->snapshot);
  }

  Asked asked_;
  std::atomic<bool> done_ = false;
  Result<Snapshot> answer_ = fail(FaultKind::timeout, "not yet");
  std::thread serves_, asks_;
};

TEST(Snapshot, IsWhatTheGlassShowsBlurred) {
  auto rig = running({.name = "snapshot"});
  const auto before = rig->picture();
  const auto snapshot = must(Asking(*rig, SnapshotKind::blurred).wait());
  EXPECT_EQ(snapshot->shown, "live");
  EXPECT_TRUE(snapshot->building);
  EXPECT_THAT(snapshot->words, IsEmpty());
  EXPECT_EQ(snapshot->screen_width, before.width());
  EXPECT_EQ(std::max(snapshot->picture.width(), snapshot->picture.height()), kBlurredPixels)
      << "nothing sharp leaves it";
  EXPECT_LE(difference(snapshot->picture, blurred_beyond_recognition(before)).mean, 3.0);
  EXPECT_LE(difference(rig->picture(), before).mean, 3.0) << "visitors see nothing of it";
}

TEST(Snapshot, OfTheStillPictureSaysWhyAndItsWords) {
  auto rig = running({.name = "snapshot"});
  rig->devices.scene.unplugged = true;
  rig->advance(4s);
  ASSERT_TRUE(rig->shows_still());
  const auto snapshot = must(Asking(*rig, SnapshotKind::blurred).wait());
  EXPECT_EQ(snapshot->shown, "still");
  EXPECT_FALSE(snapshot->reason.empty());
  EXPECT_THAT(snapshot->words, HasSubstr("The view returns in a moment."));
  EXPECT_THAT(snapshot->words, HasSubstr("No picture is coming from the camera."));
  EXPECT_FALSE(snapshot->building);
}

TEST(Snapshot, Row34SafeModeAnswersAsWell) {
  SafeRig rig("snapshot");
  rig.start();
  rig.advance(2s);
  const auto before = must(read_picture(*rig.safe->display()));
  const auto snapshot = must(Asking(rig, SnapshotKind::blurred).wait());
  EXPECT_EQ(snapshot->shown, "still");
  EXPECT_THAT(snapshot->reason, HasSubstr("safe mode"));
  EXPECT_THAT(snapshot->words, HasSubstr("The view returns in a moment."));
  EXPECT_FALSE(snapshot->building);
  EXPECT_LE(difference(snapshot->picture, blurred_beyond_recognition(*before)).mean, 3.0);
  const auto sharp = must(Asking(rig, SnapshotKind::sharp).wait());
  EXPECT_TRUE(sharp->refused);

  rig.devices.display.unplugged = true;
  rig.devices.display.context_lost = true;
  rig.advance(3s);
  const auto none = must(Asking(rig, SnapshotKind::blurred).wait());
  EXPECT_EQ(none->shown, "nothing");
  EXPECT_THAT(none->reason, HasSubstr("no display"));
  EXPECT_TRUE(none->picture.empty());
}

TEST(Snapshot, Row34SafeModeTellsVisitorsBeforeASharpOne) {
  SafeRig rig("snapshot-sharp");
  ASSERT_TRUE(write_text_file(rig.config, read_text_file(rig.config).value() + "\n[snapshot]\nsharp = true\n"));
  rig.start();
  rig.advance(2s);
  const auto before = upper_quarter(read_picture(*rig.safe->display()).value());
  const auto began = rig.clock.now();
  const auto snapshot = must(Asking(rig, SnapshotKind::sharp).wait());
  EXPECT_GE(rig.clock.now() - began, SnapshotDesk::kTold);
  EXPECT_EQ(snapshot->picture.width(), snapshot->screen_width);
  EXPECT_GT(difference(upper_quarter(snapshot->picture), before).mean, 1.0) << "the picture itself says so";
  rig.advance(2s);
  EXPECT_LE(difference(upper_quarter(read_picture(*rig.safe->display()).value()), before).mean, 0.1);
}

TEST(Snapshot, SharpIsRefusedUnlessTheConfigurationAllowsIt) {
  auto rig = running({.name = "snapshot"});
  const auto snapshot = must(Asking(*rig, SnapshotKind::sharp).wait());
  EXPECT_TRUE(snapshot->refused);
  EXPECT_TRUE(snapshot->picture.empty());
}

TEST(Snapshot, SharpIsToldToVisitorsBeforeAndOnThePictureItself) {
  auto rig = running({.name = "snapshot", .more_config = "\n[snapshot]\nsharp = true\n"});
  const auto before = upper_quarter(rig->picture());
  const auto began = rig->clock.now();
  Asking asking(*rig, SnapshotKind::sharp);
  const auto told = [&] { return difference(upper_quarter(rig->picture()), before).mean > 5.0; };
  ASSERT_TRUE(rig->advance_until(told, 60s)) << "words on the glass";
  const auto told_at = rig->clock.now();
  EXPECT_FALSE(asking.answered());
  const auto snapshot = must(asking.wait());
  EXPECT_GE(rig->clock.now() - told_at, 2900ms);
  EXPECT_EQ(snapshot->kind, SnapshotKind::sharp);
  EXPECT_EQ(snapshot->picture.width(), snapshot->screen_width);
  EXPECT_THAT(snapshot->words, HasSubstr("A picture of what you see here"));
  EXPECT_GT(difference(upper_quarter(snapshot->picture), before).mean, 5.0) << "they are on the picture";
  rig->advance(1s);
  EXPECT_LT(difference(upper_quarter(rig->picture()), before).mean, 5.0) << "and gone afterwards";
  EXPECT_LT(rig->clock.now() - began, 60s);
}

TEST(Snapshot, WhatIsWrongStaysOnTheGlassBelowThatSomebodyLooks) {
  auto rig = running({.name = "snapshot", .more_config = "\n[snapshot]\nsharp = true\n"});
  rig->devices.scene.unplugged = true;
  rig->advance(4s);
  ASSERT_TRUE(rig->shows_still());
  const auto snapshot = must(Asking(*rig, SnapshotKind::sharp).wait());
  EXPECT_THAT(snapshot->words, HasSubstr("A picture of what you see here"));
  EXPECT_THAT(snapshot->words, HasSubstr("No picture is coming from the camera."));
}

TEST(Snapshot, WhereNothingIsOnTheGlassItSaysWhy) {
  auto rig = running({.name = "snapshot"});
  rig->devices.display.unplugged = true;
  rig->advance(2s);
  const auto without = must(Asking(*rig, SnapshotKind::blurred).wait());
  EXPECT_TRUE(without->picture.empty());
  EXPECT_EQ(without->shown, "nothing");
  EXPECT_THAT(without->reason, HasSubstr("no display"));

  Rig closed({.name = "snapshot", .more_config = "\n[opening]\nevery_day = \"closed\"\n"});
  closed.advance(4s);
  const auto dark = must(Asking(closed, SnapshotKind::blurred).wait());
  EXPECT_TRUE(dark->picture.empty());
  EXPECT_EQ(dark->shown, "dark");
}

TEST(Snapshot, StrangersOnItsSocketDoNotHoldItUp) {
  auto rig = running({.name = "snapshot"});
  const auto path = rig->folder / kSnapshotSocket;
  const auto silent = connect_to(path), strange = connect_to(path);
  auto gone = connect_to(path);
  ASSERT_TRUE(silent && strange && gone);
  ASSERT_TRUE(write_within(*strange, std::string(5000, 'x'), 1s));
  ASSERT_TRUE(write_within(*gone, "blurred\n", 1s));
  *gone = UniqueFd();
  const auto snapshot = must(Asking(*rig, SnapshotKind::blurred).wait());
  EXPECT_FALSE(snapshot->picture.empty());
}

}  // namespace
}  // namespace kasumi

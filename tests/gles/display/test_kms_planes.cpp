// The camera's picture on one plane of a scripted card, the building on the one above.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gles/display/kms_plane_choice.hpp"
#include "tests/gles/display/kms_rig.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint32_t kRgb = drm_format("XR24"), kNv12 = drm_format("NV12");

KmsPlane with_zpos(KmsPlane plane, std::uint64_t now, std::uint64_t least, std::uint64_t most) {
  plane.zpos = KmsPlane::Zpos{now, least, most, least == most};
  return plane;
}

const KmsPlane kPrimary = fake_plane(50, KmsPlane::Kind::primary);
const KmsPlane kOverlay = fake_plane(51, KmsPlane::Kind::overlay);

TEST(KmsPlaneChoice, PutsTheBuildingOnTheOverlay) {
  const auto pairs = must(choose_planes({kPrimary, kOverlay}, 50, kRgb, std::nullopt));
  EXPECT_THAT(*pairs, ElementsAre(KmsPlanePair{50, 51}));
}

TEST(KmsPlaneChoice, PutsTheCameraOnAnOverlayUnderThePrimaryPlane) {
  const auto low = with_zpos(kOverlay, 0, 0, 0), high = with_zpos(kPrimary, 1, 1, 1);
  EXPECT_THAT(choose_planes({high, low}, 50, kRgb, std::nullopt).value(), ElementsAre(KmsPlanePair{51, 50}));
}

TEST(KmsPlaneChoice, SetsTheOrderWhereItCan) {
  const auto base = with_zpos(kPrimary, 3, 0, 3), other = with_zpos(kOverlay, 0, 0, 3);
  EXPECT_THAT(choose_planes({base, other}, 50, kRgb, std::nullopt).value(),
              ElementsAre(KmsPlanePair{50, 51, 0, 3}, KmsPlanePair{51, 50, 0, 3}));
  // One of them is fixed.
  EXPECT_THAT(choose_planes({with_zpos(kPrimary, 1, 1, 1), other}, 50, kRgb, std::nullopt).value(),
              ElementsAre(KmsPlanePair{50, 51, std::nullopt, 3}, KmsPlanePair{51, 50, 0, std::nullopt}));
}

TEST(KmsPlaneChoice, ShowsYuvWhereItIsConvertedAsTheCameraMeansIt) {
  KmsPlane video = with_zpos(kOverlay, 0, 0, 0), graphics = with_zpos(kPrimary, 1, 1, 1);
  video.formats = {kNv12};
  video.encodings = {YuvEncoding::bt709_limited};
  EXPECT_THAT(choose_planes({graphics, video}, 50, kNv12, YuvEncoding::bt709_limited).value(),
              ElementsAre(KmsPlanePair{51, 50}));
  EXPECT_THAT(choose_planes({graphics, video}, 50, kNv12, YuvEncoding::bt601_full),
              FailsWith(HasSubstr("plane 51 cannot convert")));
}

TEST(KmsPlaneChoice, SaysWhyNot) {
  const auto why = [](const std::vector<KmsPlane>& planes, std::uint32_t format = kRgb) {
    const auto pairs = choose_planes(planes, 50, format, std::nullopt);
    return pairs ? std::string("it does") : pairs.error().message;
  };
  const KmsPlane cursor = fake_plane(52, KmsPlane::Kind::cursor);  // virtio_gpu has these two
  EXPECT_EQ(why({kPrimary, cursor}), "the display has no overlay plane");
  KmsPlane taken = kOverlay;
  taken.free = false;
  EXPECT_EQ(why({kPrimary, taken}), "the display has no overlay plane");
  EXPECT_THAT(why({kPrimary, kOverlay}, kNv12), HasSubstr("plane 50 does not show NV12"));
  KmsPlane opaque = kOverlay;
  opaque.formats = {kRgb};
  EXPECT_THAT(why({kPrimary, opaque}), HasSubstr("plane 51 does not show AR24"));
  KmsPlane coverage = kOverlay;
  coverage.premultiplied = false;
  EXPECT_THAT(why({kPrimary, coverage}), HasSubstr("plane 51 does not blend premultiplied alpha"));
  EXPECT_THAT(why({with_zpos(kPrimary, 1, 1, 1), with_zpos(kOverlay, 1, 1, 1)}),
              HasSubstr("plane 51 cannot lie over plane 50"));
}

class KmsPlanes : public KmsRig {
 protected:
  void SetUp() override {
    KmsRig::SetUp();
    if (IsSkipped()) return;
    switch_on();
    ASSERT_TRUE(show().has_value());  // sets the mode
    auto made = must(display_->make_plane_buffer(16, 12));
    building_ = *made;
    settle();
    card_.calls.clear();
  }
  void TearDown() override { building_.reset(); }

  PlaneStack picture(std::uint64_t buffer = 1) const {
    PlaneStack made;
    made.camera = {0, buffer, PixelLayout::bgra8, {}, 64, 48, {ExternalPlane{0, 256}}};
    made.building = building_;
    made.left = 20, made.top = 10, made.right = 30, made.bottom = 18;
    made.source_left = 3, made.source_top = 2;
    return made;
  }
  Result<std::uint64_t> show_planes(const PlaneStack& shown, std::shared_ptr<const void> holder = nullptr) {
    if (const auto target = display_->begin(clock_.now() + 50ms); !target) return fail(target.error());
    return display_->show_planes(shown, std::move(holder));
  }
  void settle() { ASSERT_TRUE(display_->begin(clock_.now() + 50ms).has_value()); }

  std::shared_ptr<PlaneBuffer> building_;
};

TEST_F(KmsPlanes, ShowTheCameraAndTheBuildingInOneCommit) {
  for (const std::uint64_t buffer : {1u, 2u, 1u, 2u}) ASSERT_TRUE(show_planes(picture(buffer)).has_value());
  EXPECT_THAT(card_.calls,
              ElementsAre("ask_for_planes", "commit_planes", "commit_planes", "commit_planes", "commit_planes"));
  ASSERT_EQ(card_.shown.size(), 2u);
  const auto& camera = card_.shown.at(50);
  EXPECT_EQ(camera.source, (KmsRectangle{0, 0, 64, 48}));
  EXPECT_EQ(card_.framebuffers.at(camera.framebuffer).dma_buf, 0);
  const auto& building = card_.shown.at(51);
  EXPECT_EQ(building.framebuffer, building_->framebuffer());
  EXPECT_EQ(building.source, (KmsRectangle{3, 2, 10, 8}));
  EXPECT_EQ(std::pair(building.x, building.y), std::pair(20, 10));
  EXPECT_TRUE(building.blends);
  EXPECT_EQ(card_.framebuffers.size(), 3u + 1u + 2u) << "each of the camera's buffers is imported once";
}

// Neither of the other way: the picture is whole at every moment.
TEST_F(KmsPlanes, AreSwitchedToAndFromInOneCommit) {
  ASSERT_TRUE(show_planes(picture()).has_value());
  settle();
  card_.calls.clear();
  ASSERT_TRUE(show().has_value());
  EXPECT_THAT(card_.calls, ElementsAre("commit_planes"));
  ASSERT_EQ(card_.shown.size(), 1u);
  EXPECT_EQ(card_.shown.at(50).source, (KmsRectangle{0, 0, 64, 48}));
  settle();
  ASSERT_TRUE(show().has_value());
  EXPECT_EQ(card_.calls.back(), "commit_flip");
}

TEST_F(KmsPlanes, KeepTheCamerasBufferUntilTheNextPictureIsShown) {
  auto first = std::make_shared<int>(1);
  const std::weak_ptr<int> watched = first;
  ASSERT_TRUE(show_planes(picture(1), std::move(first)).has_value());
  settle();
  ASSERT_TRUE(display_->show_planes(picture(2)).has_value());
  EXPECT_FALSE(watched.expired()) << "its picture is still scanned out";
  settle();
  EXPECT_TRUE(watched.expired());
}

TEST_F(KmsPlanes, KeepTheBuildingsBufferWhileItIsShown) {
  const std::weak_ptr<PlaneBuffer> watched = building_;
  ASSERT_TRUE(show_planes(picture()).has_value());
  building_.reset();
  settle();
  EXPECT_FALSE(watched.expired());
  ASSERT_TRUE(show().has_value());
  settle();
  EXPECT_TRUE(watched.expired());
  EXPECT_EQ(card_.framebuffers.size(), 3u);
}

TEST_F(KmsPlanes, TurnTheBuildingsPlaneOffWhereItIsNotSeen) {
  ASSERT_TRUE(show_planes(picture()).has_value());
  auto alone = picture();
  alone.building.reset();
  ASSERT_TRUE(show_planes(alone).has_value());
  EXPECT_EQ(card_.shown.size(), 1u);
}

TEST_F(KmsPlanes, TakeTheFirstPairThatTheDriverAccepts) {
  card_.planes = {with_zpos(kPrimary, 0, 0, 3), with_zpos(kOverlay, 0, 0, 3), with_zpos(kOverlay, 0, 0, 3)};
  card_.planes[2].id = 52;
  card_.planes[1].formats = {kRgb};  // cannot carry the building
  ASSERT_TRUE(show_planes(picture()).has_value());
  EXPECT_TRUE(card_.shown.contains(52));
}

TEST_F(KmsPlanes, ReportWhatTheDriverRefuses) {
  const auto refusal = [&](std::uint64_t buffer) {
    const auto shown = show_planes(picture(buffer));
    if (shown) return std::string("shown");
    EXPECT_EQ(shown.error().kind, FaultKind::unsupported);
    return shown.error().message;
  };
  card_.most_overlay_pixels = 50;  // as vc4 does for more than its memory can deliver
  EXPECT_THAT(refusal(1), HasSubstr("No space left"));
  card_.most_overlay_pixels = 1000;
  card_.no_import = true;
  EXPECT_THAT(refusal(2), HasSubstr("importing"));
  card_.no_import = false;
  card_.planes = {kPrimary, fake_plane(52, KmsPlane::Kind::cursor)};
  EXPECT_EQ(refusal(3), "the display has no overlay plane");
  EXPECT_EQ(card_.count("commit_planes"), 0);
  card_.planes = {kPrimary, kOverlay};
  EXPECT_EQ(refusal(4), "shown");
}

TEST_F(KmsPlanes, ShowOnlyPicturesOfTheScreensSize) {
  auto small = picture();
  small.camera.width = 32;
  EXPECT_THAT(show_planes(small), FailsWith(HasSubstr("32 x 48")));
  EXPECT_TRUE(card_.calls.empty());
}

TEST_F(KmsPlanes, NeedAtomicCommits) {
  building_.reset();
  display_.reset();
  options_.atomic = false;
  switch_on();
  ASSERT_TRUE(show().has_value());
  building_ = display_->make_plane_buffer(16, 12).value();
  EXPECT_THAT(show_planes(picture()), FailsWith(HasSubstr("no atomic commits")));
}

// A refused commit leaves what is shown as it is, and the display goes on.
TEST_F(KmsPlanes, LeaveOutAPictureThatIsRefused) {
  ASSERT_TRUE(show_planes(picture(1)).has_value());
  settle();
  const auto before = card_.shown.at(50).framebuffer;
  card_.refusals = {std::errc::no_space_on_device};
  const auto refused = display_->show_planes(picture(2));
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().kind, FaultKind::unsupported);
  EXPECT_EQ(card_.shown.at(50).framebuffer, before);
  ASSERT_TRUE(show_planes(picture(3)).has_value());
  EXPECT_EQ(card_.count("commit_mode"), 0);
}

TEST_F(KmsPlanes, AreTriedAgainWhileTheDriverIsBusy) {
  card_.busy = 2;
  const auto number = must(show_planes(picture()));
  settle();
  EXPECT_EQ(display_->take_flips().back().number, *number);
}

// The buffers stay while the display may read them, and an ordinary picture sets the mode.
TEST_F(KmsPlanes, RecoverFromAFlipThatNeverCompletes) {
  auto holder = std::make_shared<int>(1);
  const std::weak_ptr<int> watched = holder;
  card_.lost_events = 1;
  ASSERT_TRUE(show_planes(picture(), std::move(holder)).has_value());
  clock_.advance(2s);
  ASSERT_TRUE(display_->begin(clock_.now() + 50ms).has_value());
  EXPECT_FALSE(watched.expired());
  const auto refused = display_->show_planes(picture(2));
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().kind, FaultKind::unsupported);
  ASSERT_TRUE(display_->show().has_value());
  EXPECT_EQ(card_.count("commit_mode"), 1);
  settle();
  EXPECT_TRUE(watched.expired());
  EXPECT_EQ(display_->counts().flip_timeouts, 1u);
}

TEST_F(KmsPlanes, WaitForTheMode) {
  ASSERT_TRUE(show_planes(picture()).has_value());
  settle();
  ASSERT_TRUE(display_->turn_off().has_value());
  const auto early = show_planes(picture());
  ASSERT_FALSE(early.has_value());
  EXPECT_EQ(early.error().kind, FaultKind::timeout);
  ASSERT_TRUE(show().has_value());
  EXPECT_TRUE(show_planes(picture()).has_value());
}

TEST_F(KmsPlanes, GiveEverythingBack) {
  ASSERT_TRUE(show_planes(picture(1)).has_value());
  ASSERT_TRUE(show_planes(picture(2)).has_value());
  building_.reset();
  display_.reset();
  EXPECT_TRUE(card_.framebuffers.empty());
  EXPECT_EQ(card_.open_devices, 0);
}

}  // namespace
}  // namespace kasumi

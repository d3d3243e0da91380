// People, birds and cars before the building, in generated clips: how much of them is drawn over, and what is left out
// though nobody is there. The land, its light and who passes are the generator's; the watch shares nothing with it.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include <gtest/gtest.h>

#include "fixtures/noise/random.hpp"
#include "tests/estimator/passers/clips.hpp"
#include "tests/figures.hpp"

namespace kasumi {
namespace {

using fixtures::Cutout;

struct Light {
  const char* name;
  std::chrono::minutes utc;  // of the generator's day; noon is 02:42, the sun sets at 08:20
  double clouds;
  double turbidity;
  std::uint64_t seed;
};
// Constants were chosen under the clouds of other seeds at other hours, with other people (02:00 and 05:00).
constexpr Light kClear{"clear", std::chrono::minutes(190), 0.0, 2.8, 31};
constexpr Light kCloudy{"broken cloud", std::chrono::minutes(45), 0.45, 2.4, 32};
constexpr Light kFewClouds{"a few clouds", std::chrono::minutes(240), 0.35, 3.0, 77};
constexpr Light kEvening{"evening", std::chrono::minutes(415), 0.0, 2.2, 33};

constexpr double kWalker_px = 40.0, kSpeed_px_per_s = 32.0;  // 1.4 m/s for somebody of 1.75 m

fixtures::LitLandSettings land(const Light& light, double seconds) {
  fixtures::LitLandSettings settings;
  settings.start_utc = Utc(std::chrono::sys_days(std::chrono::year{2026} / 10 / 20)) + light.utc;
  settings.turbidity = light.turbidity;
  settings.cloud_cover = light.clouds;
  settings.seed = light.seed;
  settings.seconds = seconds;
  return settings;
}

struct Shares {
  double worst = 0.0, drawn_over = 0.0, halo = 0.0;
  int pictures = 0;
  void add(const OutlineErrors& errors) {
    if (errors.passer_px < 100.0) return;
    worst = std::max(worst, errors.drawn_over);
    drawn_over += errors.drawn_over;
    halo += errors.halo;
    ++pictures;
  }
  std::string text() const {
    return fmt::format("drawn over at most {:.1f} % of his pixels, {:.2f} % in the mean; around him {:.0f} %",
                       100.0 * worst, 100.0 * drawn_over / pictures, 100.0 * halo / pictures);
  }
};

// Black, white, as dark and green as the trees behind; then such as people wear.
fixtures::Clothes clothes_of_walker(const Light& light, std::uint64_t who) {
  constexpr std::array<glm::dvec3, 3> kOneColour{{{0.03, 0.03, 0.03}, {0.62, 0.62, 0.60}, {0.08, 0.10, 0.06}}};
  auto clothes = fixtures::clothes_of(light.seed * 10 + who);
  if (who < kOneColour.size()) clothes.jacket = clothes.trousers = kOneColour[who];
  return clothes;
}

// An hour without anybody, then walkers; a picture every 4 s, and 8 a second while they walk.
class PassersInLight : public testing::TestWithParam<Light> {};

TEST_P(PassersInLight, KeepsWalkersInFrontAndLeavesNothingOutForAnHour) {
  const Light& light = GetParam();
  const double settle_s = whole_figures() ? 1500.0 : 900.0, film_s = whole_figures() ? 3600.0 : 300.0;
  Clip clip(land(light, settle_s + film_s + 60.0));
  Passers watch = watch_of_building();
  settle(clip, watch, settle_s);
  double holes_px = 0.0, building_px = 0.0, worst = 0.0;
  int unsettled = 0;
  double t = settle_s;
  for (; t < settle_s + film_s; t += 4.0) {
    const auto errors = clip.errors(clip.show(watch, t));
    holes_px += errors.false_px;
    building_px += errors.building_px;
    worst = std::max(worst, errors.false_px / errors.building_px);
    unsettled += watch.last().state != PassersState::watching;
  }
  Shares walkers;
  for (std::uint64_t who = 0; who < (whole_figures() ? 9U : 3U); ++who) {
    const double begin = t;
    const auto clothes = clothes_of_walker(light, who);
    for (int i = 0; i < 40; ++i, t += 0.125)
      walkers.add(clip.errors(clip.show(watch, t, [&](Cutout& on, double seconds) {
        const glm::dvec2 start{62.0 + 9.0 * static_cast<double>(who), 143.0};
        draw_person(on, fixtures::walking(start, kSpeed_px_per_s, kWalker_px, seconds - begin), clothes);
      })));
  }
  fmt::print(
      "{}: gave up in {} pictures; left out of the building {:.4f} % over {:.0f} s, {:.3f} % in the worst picture; "
      "{}\n",
      light.name, unsettled, 100.0 * holes_px / building_px, film_s, 100.0 * worst, walkers.text());
  figure_row("passers", {light.name, fmt::format("{:.4f} %", 100.0 * holes_px / building_px),
                         fmt::format("{:.1f} %", 100.0 * walkers.worst),
                         fmt::format("{:.2f} %", 100.0 * walkers.drawn_over / walkers.pictures),
                         fmt::format("{:.0f} %", 100.0 * walkers.halo / walkers.pictures)});
  EXPECT_EQ(watch.last().state, PassersState::watching);
  EXPECT_GT(walkers.pictures, 50);
  EXPECT_LE(holes_px / building_px, 0.001);
  EXPECT_LE(walkers.worst, 0.05);
}
// Broken cloud is the worst.
INSTANTIATE_TEST_SUITE_P(Generated, PassersInLight,
                         testing::ValuesIn(whole_figures() ? std::vector{kClear, kCloudy, kFewClouds, kEvening}
                                                           : std::vector{kCloudy}),
                         [](const auto& light) {
                           std::string name = light.param.name;
                           std::ranges::replace(name, ' ', '_');
                           return name;
                         });

// The clips below share their land, which takes long to make.
class PassersBefore : public testing::Test {
 protected:
  static constexpr double kLonger_s = 3000.0;
  static void SetUpTestSuite() { clip_ = new Clip(land(kClear, kLonger_s)); }
  static void TearDownTestSuite() { delete clip_; }
  void SetUp() override { clip_->spoil = {}; }
  static Clip& clip() { return *clip_; }
  static Clip* clip_;
};
Clip* PassersBefore::clip_ = nullptr;

TEST_F(PassersBefore, SomebodyWhoStandsForTenMinutesStaysInFrontAndIsNotRemembered) {
  Passers watch = watch_of_building(), empty = watch_of_building();
  // One is there when the watch begins, and is taken for a part of the scene until he has gone; another comes when all
  // is learnt, and goes again; others walk past.
  constexpr double kGone_s = 600.0, kForgotten_s = kGone_s + 120.0;
  const auto stands = [](double t) { return t >= 1400.0 && t < 2000.0; };
  const auto people = [&](Cutout& on, double t) {
    if (t < kGone_s) draw_person(on, fixtures::standing({220, 142}, 60, t, 5), fixtures::clothes_of(5));
    if (stands(t)) draw_person(on, fixtures::standing({150, 142}, 60, t, 4), fixtures::clothes_of(4));
    const double lap = std::fmod(t, 200.0);
    if (lap < 9.0)
      draw_person(on, fixtures::walking({20, 142}, kSpeed_px_per_s, kWalker_px, lap), fixtures::clothes_of(7));
  };
  double worst = 0.0, left_out = 0.0;
  for (double t = 0.0; t < 2100.0; t += 4.0) {
    clip().show(empty, t);
    const auto& look = clip().show(watch, t, people);
    const auto errors = clip().errors(look);
    if (t > 1404.0 && stands(t)) worst = std::max(worst, errors.drawn_over);
    if (t > kForgotten_s && errors.passer_px == 0.0)
      left_out = std::max(left_out, errors.false_px / errors.building_px);
  }
  fmt::print("stands for ten minutes: drawn over at most {:.1f} %; nobody there: {:.3f} % left out\n", 100.0 * worst,
             100.0 * left_out);
  EXPECT_LE(worst, 0.05);
  EXPECT_LE(left_out, 0.001);
  // What is remembered is what a watch remembers that never saw anybody.
  // (A picture in which more is remembered tells no pixels: the next one does.)
  clip().show(empty, 2100.0);
  clip().show(watch, 2100.0);
  const PartPlace& place = watch.place();
  const Image<std::uint8_t> all(place.columns(), place.rows(), 1);
  ExpectedScene with = watch.expected(), without = empty.expected();
  with.expect_pixels(all);
  without.expect_pixels(all);
  double greatest = 0.0, sum = 0.0;
  int count = 0;
  for (int y = 0; y < place.height; ++y)
    for (int x = 0; x < place.width; ++x) {
      if (!with.knows(x / place.cell_px, y / place.cell_px) || !without.knows(x / place.cell_px, y / place.cell_px))
        continue;
      // As a person is seen: the mean of a few pixels.
      const glm::vec3 off = with.pixel(x, y) - without.pixel(x, y);
      greatest = std::max(greatest, static_cast<double>(std::abs(off.x)));
      sum += static_cast<double>(std::abs(off.x));
      ++count;
    }
  fmt::print("remembered with people and without: {:.2f} of 255 apart in the mean, {:.1f} at most\n", sum / count,
             greatest);
  ASSERT_GT(count, place.width * place.height / 2);
  EXPECT_LT(sum / count, 1.0);
  EXPECT_LT(greatest, 12.0);
  EXPECT_GT(watch.expected().known_share(), 0.97);
}

TEST_F(PassersBefore, BirdsAndACarStayInFront) {
  Passers watch = watch_of_building();
  settle(clip(), watch, 900.0);
  Shares birds, cars;
  for (int i = 0; i < 30; ++i)
    birds.add(clip().errors(clip().show(watch, 900.0 + 0.1 * i, [](Cutout& on, double t) {
      fixtures::draw_flock(on, {100, 90}, 30.0, 14.0, 12, t - 900.0, 3);
    })));
  for (int i = 0; i < 30; ++i)
    cars.add(clip().errors(clip().show(watch, 904.0 + 0.04 * i, [](Cutout& on, double t) {
      fixtures::draw_car(on, {40.0 + 180.0 * (t - 904.0), 144.0}, 100.0, {0.45, 0.08, 0.07});
    })));
  fmt::print("birds: {}\ncar: {}\n", birds.text(), cars.text());
  EXPECT_LE(birds.drawn_over / birds.pictures, 0.10);
  EXPECT_LE(cars.worst, 0.05);
}

// What is not there must not be found.
class NothingThere : public PassersBefore, public testing::WithParamInterface<const char*> {};

TEST_P(NothingThere, IsLeftOut) {
  const std::string what = GetParam();
  clip().jpeg_quality = what == "coarse JPEG" ? 45 : 92;
  clip().spoil = [&](Image<Rgb8>& picture, double seconds) {
    fixtures::Random random(static_cast<std::uint64_t>(seconds * 8.0) + 1);
    const auto each = [&](auto change) {
      for (Rgb8& pixel : picture.elements())
        for (int c = 0; c < 3; ++c)
          pixel[c] = static_cast<std::uint8_t>(std::clamp(change(static_cast<double>(pixel[c])), 0.0, 255.0));
    };
    if (what == "exposure steps") {
      const double gain = std::fmod(seconds, 60.0) < 30.0 ? 1.0 : 1.22;
      each([&](double value) { return gain * value; });
    } else if (what == "noise") {
      each([&](double value) { return value + 5.0 * random.normal(); });
    } else if (what == "rain") {
      for (int i = 0; i < 60; ++i) {
        const double x0 = random.uniform() * kClipWidth, y0 = random.uniform() * kClipHeight;
        for (int d = 0; d < 18; ++d) {
          const int x = static_cast<int>(x0 + 0.1 * d), y = static_cast<int>(y0 + d);
          if (picture.contains(x, y)) picture.at(x, y) = glm::u8vec3(glm::vec3(picture.at(x, y)) * 0.8F + 42.0F);
        }
      }
    } else if (what == "a drop on the lens" && seconds > 900.0) {
      for (int y = 0; y < kClipHeight; ++y)
        for (int x = 0; x < kClipWidth; ++x) {
          const double off = std::hypot(x - 160.0, y - 100.0) / 45.0;
          const double more = 1.0 + 0.10 * std::exp(-off * off);
          for (int c = 0; c < 3; ++c)
            picture.at(x, y)[c] = static_cast<std::uint8_t>(std::min(255.0, more * picture.at(x, y)[c]));
        }
    } else if (what == "swaying") {
      // Trees that sway by a pixel or two, all below the hill.
      const Image<Rgb8> still = picture;
      for (int y = 60; y < kClipHeight; ++y)
        for (int x = 0; x < kClipWidth; ++x) {
          const double by =
              1.6 * std::sin(2.0 * kPi * seconds / 3.1 + 0.05 * x) * std::clamp((150.0 - y) / 60.0, 0.0, 1.0);
          picture.at(x, y) = still.at(std::clamp(static_cast<int>(std::lround(x + by)), 0, kClipWidth - 1), y);
        }
    }
  };
  Passers watch = watch_of_building();
  settle(clip(), watch, 1000.0);
  double holes_px = 0.0, building_px = 0.0;
  for (double t = 1000.0; t < 1060.0; t += 1.37) {
    const auto errors = clip().errors(clip().show(watch, t));
    holes_px += errors.false_px;
    building_px += errors.building_px;
  }
  fmt::print("{}: {:.4f} % left out, known {:.1f} %\n", what, 100.0 * holes_px / building_px,
             100.0 * watch.last().known_share);
  clip().jpeg_quality = 92;
  EXPECT_LE(holes_px / building_px, 0.001);
  EXPECT_EQ(watch.last().state, PassersState::watching);
}
INSTANTIATE_TEST_SUITE_P(Generated, NothingThere,
                         testing::Values("exposure steps", "noise", "rain", "a drop on the lens", "swaying",
                                         "coarse JPEG"),
                         [](const auto& what) {
                           std::string name = what.param;
                           std::ranges::replace(name, ' ', '_');
                           return name;
                         });

Image<Rgb8> grey(int value, std::uint64_t seed) {
  fixtures::Random random(seed);
  Image<Rgb8> made(kClipWidth, kClipHeight);
  for (Rgb8& pixel : made.elements())
    pixel = Rgb8(static_cast<std::uint8_t>(std::clamp(value + 2.0 * random.normal(), 0.0, 255.0)));
  return made;
}

TEST(PassersByNight, NobodyIsLookedForAndTheStatusSaysWhy) {
  Passers watch = watch_of_building();
  std::uint64_t n = 0;
  for (double t = 0.0; t < 800.0; t += 4.0) watch.look(view_of(grey(90, ++n)), at(t));
  EXPECT_EQ(watch.last().state, PassersState::watching);
  Image<Rgb8> night = grey(9, ++n);
  for (int y = 110; y < 140; ++y)
    for (int x = 100; x < 110; ++x) night.at(x, y) = Rgb8(60);
  const auto& look = watch.look(view_of(night), at(804.0));
  EXPECT_EQ(look.state, PassersState::dark);
  EXPECT_TRUE(look.in_front.empty());
  EXPECT_NE(reason_of(look.state), "");
  // In the morning the light is another, and the scene is learnt anew.
  watch.look(view_of(grey(90, ++n)), at(804.0 + 8.0 * 3600.0));
  EXPECT_EQ(watch.last().state, PassersState::learning);
  EXPECT_GT(to_seconds(watch.last().until_watching), 60.0);
}

TEST(PassersByNight, APictureThatIsAnotherAltogetherIsNotLeftOut) {
  Passers watch = watch_of_building();
  std::uint64_t n = 0;
  for (double t = 0.0; t < 800.0; t += 4.0) watch.look(view_of(grey(90, ++n)), at(t));
  // Somebody turned the camera: stripes of red and green.
  Image<Rgb8> other(kClipWidth, kClipHeight);
  for (int y = 0; y < kClipHeight; ++y)
    for (int x = 0; x < kClipWidth; ++x) other.at(x, y) = x / 12 % 2 ? Rgb8{160, 60, 60} : Rgb8{60, 160, 60};
  const auto& look = watch.look(view_of(other), at(804.0));
  EXPECT_EQ(look.state, PassersState::unsettled);
  EXPECT_TRUE(look.in_front.empty());
  for (double t = 808.0; t < 808.0 + 900.0; t += 4.0) watch.look(view_of(other), at(t));
  EXPECT_EQ(watch.last().state, PassersState::watching);
  EXPECT_TRUE(watch.last().in_front.empty()) << watch.last().covered_share;
}

TEST(PassersPart, IsReadAlikeFromEveryLayout) {
  Image<Rgb8> picture(64, 48);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      picture.at(x, y) = {static_cast<std::uint8_t>(3 * x), static_cast<std::uint8_t>(4 * y),
                          static_cast<std::uint8_t>(200 - 2 * x)};
  const PartPlace place = part_around(11, 9, 40, 30, 3, 64, 48);
  EXPECT_EQ(place, (PartPlace{8, 6, 32, 24}));
  PicturePart from_rgb;
  from_rgb.read(view_of(picture), place);
  for (const char* format : {"YUYV", "UYVY", "NV12", "RGB3"}) {
    const auto frame = encode_frame(picture, parse_four_cc(format).value());
    ASSERT_TRUE(frame) << format;
    const auto decoded = decode(*frame, YuvEncoding::bt601_full);
    ASSERT_TRUE(decoded) << format;
    PicturePart part;
    part.read(decoded->view(), place);
    for (std::size_t i = 0; i < part.cells().elements().size(); ++i)
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(part.cells().elements()[i][c], from_rgb.cells().elements()[i][c], 2.5F) << format << ", cell " << i;
  }
}

}  // namespace
}  // namespace kasumi

// A minute as a line: nothing is lost that a person would ask for, and nothing torn is believed.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "history/history_minute.hpp"
#include "tests/history/minutes.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

TEST(HistoryLines, WhatIsWrittenIsRead) {
  const auto text = history_text(whole_line());
  EXPECT_EQ(text.size(), kHistoryLineBytes);
  EXPECT_THAT(text, testing::StartsWith(
                        "1267 20260621T1410 still scene-white-out 42 2.41 .050 .123 .011 125 1.5 .25 81 61 .50 3 "));
  EXPECT_EQ(parse_history(text), whole_line());
  HistoryLine bare;
  bare.utc = minute("1970-01-01T00:00:00Z");
  EXPECT_EQ(parse_history(history_text(bare)), bare);
}

TEST(HistoryLines, EveryRungFits) {
  for (const Shown shown : kAllShown)
    for (const Trouble trouble : kAllTroubles) {
      auto line = whole_line();
      line.shown = shown;
      line.trouble = trouble;
      EXPECT_EQ(parse_history(history_text(line)), line);
    }
}

TEST(HistoryLines, NumbersOfAnySizeFit) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double value : {0.0, -0.0, 1e-9, 0.9999, 0.99996, 9.996, 99.96, 999.6, 9999.6, 1e12, -5.0, -1e9, kInfinity,
                             -kInfinity, std::numeric_limits<double>::quiet_NaN()}) {
    auto line = whole_line();
    line.number = 0xffffffff;
    line.hidden_s = 1000;
    for (const auto& column : kHistoryColumns) line.*column.value = value;
    const auto text = history_text(line);
    ASSERT_EQ(text.size(), kHistoryLineBytes);
    const auto read = parse_history(text);
    ASSERT_TRUE(read) << text;
    EXPECT_EQ(read->hidden_s, 60);
    const double expected = value >= 0.0 && value < 1000.0 ? value : read->turbidity.value_or(value);
    EXPECT_TRUE(std::isnan(value) || std::isinf(value) ||
                std::abs(read->turbidity.value_or(-1.0) - expected) <= 0.005 * std::abs(expected) + 0.001)
        << text;
  }
}

TEST(HistoryLines, ATornOneIsNotBelieved) {
  const auto text = history_text(whole_line());
  std::mt19937 random(3);
  for (std::size_t cut = 0; cut < text.size(); ++cut) {
    auto torn = text;
    for (std::size_t i = cut; i + 1 < torn.size(); ++i) torn[i] = ' ';
    EXPECT_EQ(parse_history(torn).has_value(), torn == text) << cut;
    auto flipped = text;
    flipped[cut] = static_cast<char>(flipped[cut] ^ (1 << random() % 7));
    EXPECT_FALSE(parse_history(flipped)) << cut;
  }
  EXPECT_FALSE(parse_history(""));
  EXPECT_FALSE(parse_history(text + text));
}

// A second of a state, as the appliance tells it.
HistoryLine second_of(Utc utc, Shown shown, Trouble trouble) {
  HistoryLine line;
  line.utc = std::chrono::floor<std::chrono::minutes>(utc);
  line.shown = shown;
  line.trouble = trouble;
  return line;
}

TEST(HistoryMinutes, KeepTheWorstOfAMinuteAndHowLongItLasted) {
  HistoryMinute minute_of;
  Instant now{};
  Utc utc = *parse_utc("2026-06-21T14:10:00Z");
  std::vector<HistoryLine> ended;
  for (int second = 0; second < 181; ++second) {
    const bool away = second >= 70 && second < 90;
    const auto line = second_of(utc, away ? Shown::still : Shown::live, away ? Trouble::scene_lost : Trouble::none);
    if (auto minute_ended = minute_of.add(line, now)) ended.push_back(*minute_ended);
    now += 1s;
    utc += 1s;
  }
  ASSERT_EQ(ended.size(), 3U);
  EXPECT_EQ(ended[0].shown, Shown::live);
  EXPECT_EQ(ended[0].hidden_s, 0);
  EXPECT_EQ(ended[1].shown, Shown::still);
  EXPECT_EQ(ended[1].trouble, Trouble::scene_lost);
  EXPECT_EQ(ended[1].hidden_s, 20);
  EXPECT_EQ(ended[2].shown, Shown::live);
  EXPECT_EQ(ended[2].utc, minute("2026-06-21T14:12:00Z"));
}

TEST(HistoryMinutes, AnHourThatIsSkippedIsNotCounted) {
  HistoryMinute minute_of;
  EXPECT_FALSE(
      minute_of.add(second_of(*parse_utc("2026-06-21T14:10:58Z"), Shown::still, Trouble::scene_lost), Instant{} + 1s));
  const auto ended =
      minute_of.add(second_of(*parse_utc("2026-06-21T15:30:00Z"), Shown::still, Trouble::scene_lost), Instant{} + 2h);
  ASSERT_TRUE(ended);
  EXPECT_LE(ended->hidden_s, 2);
}

}  // namespace
}  // namespace kasumi

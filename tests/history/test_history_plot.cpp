// A history as people ask for it.
#include <gmock/gmock.h>

#include "history/history_plot.hpp"
#include "tests/history/minutes.hpp"

namespace kasumi {
namespace {

using std::chrono::minutes;
using testing::HasSubstr;

// From noon on: live, two minutes of still, live, off for an hour, live.
std::vector<HistoryLine> a_day() {
  std::vector<HistoryLine> lines;
  for (int i = 0; i < 200; ++i) {
    if (i >= 100 && i < 160) continue;
    HistoryLine line;
    line.number = static_cast<std::uint32_t>(lines.size() + 1);
    line.utc = minute("2026-06-21T12:00:00Z") + minutes{i};
    const bool away = i == 50 || i == 51;
    line.shown = away ? Shown::still : Shown::live;
    line.trouble = away ? Trouble::scene_lost : Trouble::none;
    line.turbidity = 2.0 + 0.01 * i;
    line.sigma_turbidity = 0.1;
    line.celsius = i == 20 ? 70.0 : 50.0;
    lines.push_back(line);
  }
  return lines;
}

TEST(Spells, SayWhatWasWhen) {
  const auto spells = spells_of(a_day());
  ASSERT_EQ(spells.size(), 5U);
  EXPECT_EQ(spell_state(spells[0]), "live");
  EXPECT_EQ(spells[0].to, minute("2026-06-21T12:49:00Z"));
  EXPECT_NEAR(*spells[0].turbidity, 2.245, 1e-9);
  EXPECT_EQ(spells[0].celsius, 70.0);
  EXPECT_EQ(spell_state(spells[1]), "still, scene-lost");
  EXPECT_EQ(spells[1].from, minute("2026-06-21T12:50:00Z"));
  EXPECT_EQ(spells[1].to, minute("2026-06-21T12:51:00Z"));
  EXPECT_EQ(spell_state(spells[3]), "not running");
  EXPECT_EQ(spells[3].from, minute("2026-06-21T13:40:00Z"));
  EXPECT_EQ(spells[3].to, minute("2026-06-21T14:39:00Z"));
  EXPECT_TRUE(spells_of({}).empty());
}

TEST(Spells, AClockThatIsSetBackBeginsAnother) {
  auto lines = a_day();
  lines.resize(20);
  lines[10].utc -= minutes{600};
  EXPECT_GE(spells_of(lines).size(), 3U);
}

TEST(HistoryTables, HaveARowForEachMinute) {
  const auto csv = history_csv(a_day());
  EXPECT_THAT(csv, HasSubstr("\n2026-06-21T12:50:00Z,still,scene-lost,0,2.5,0.1,,,,,,,50,,0,0,0\n"));
  EXPECT_EQ(std::ranges::count(csv, '\n'), 1 + 140);
}

TEST(HistoryPlots, DrawStatesAndFiguresWithGaps) {
  const auto plot = history_plot(a_day(), minute("2026-06-21T12:00:00Z"), minute("2026-06-21T15:20:00Z"), minutes{120});
  EXPECT_THAT(plot, testing::StartsWith("<svg "));
  EXPECT_THAT(plot, HasSubstr("<title>What visitors saw"));
  EXPECT_THAT(plot, HasSubstr(">16:00</text>")) << "wall time";
  EXPECT_THAT(plot, HasSubstr("no figures")) << "of the optical depth there are none";
  std::size_t pieces = 0;
  for (std::size_t at = 0; (at = plot.find("<polyline", at)) != std::string::npos; ++at) ++pieces;
  EXPECT_EQ(pieces, 2U) << "the hour without figures is no line";
  EXPECT_THAT(plot, testing::Not(HasSubstr("nan")));
  EXPECT_THAT(plot, testing::Not(HasSubstr("style=")));
}

TEST(HistoryPlots, OfNothingAndOfNonsenseAreWhole) {
  const auto noon = minute("2026-06-21T12:00:00Z");
  EXPECT_THAT(history_plot({}, noon, noon, minutes{0}), HasSubstr("</svg>"));
  auto lines = a_day();
  for (auto& line : lines) line.turbidity = 9999.0;
  lines[3].utc = minute("1970-01-01T00:00:00Z");
  const auto plot = history_plot(lines, minute("1970-01-01T00:00:00Z"), noon + minutes{300}, minutes{-720});
  EXPECT_THAT(plot, HasSubstr("</svg>"));
  EXPECT_LT(plot.size(), 200000U);
}

}  // namespace
}  // namespace kasumi

// The story beside the building: readable before any picture, and never over the building.
#include <algorithm>
#include <chrono>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/show/stage/story_panel.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

PanelRequest gate() {
  PanelRequest request{"The south gate",
                       "Two storeys, five bays. It burnt in 1233 and was built again within a generation; what stood "
                       "here last came down in the great storm of 1903.",
                       "en"};
  request.width = 1920;
  request.height = 1080;
  request.building = FlatPlace{760, 400, 400, 300};
  return request;
}

bool apart(const FlatPlace& a, const FlatPlace& b) {
  return a.left + a.width <= b.left || b.left + b.width <= a.left || a.top + a.height <= b.top ||
         b.top + b.height <= a.top;
}

void expect_in_its_place(const PanelRequest& request, const StoryPanel& panel) {
  EXPECT_EQ(panel.picture.width(), panel.place.width);
  EXPECT_EQ(panel.picture.height(), panel.place.height);
  EXPECT_GE(panel.place.left, 0.0);
  EXPECT_GE(panel.place.top, 0.0);
  EXPECT_LE(panel.place.left + panel.place.width, request.width);
  EXPECT_LE(panel.place.top + panel.place.height, request.height);
  if (request.building) {
    EXPECT_TRUE(apart(panel.place, *request.building))
        << panel.place.left << " " << panel.place.top << " " << panel.place.width << " x " << panel.place.height;
  }
}

// Relative luminance (WCAG 2.2) of a pixel of the panel over a picture of that grey.
double luminance(const Rgba8& pixel, double behind) {
  double sum = 0.0;
  const double weights[]{0.2126, 0.7152, 0.0722};
  for (int c = 0; c < 3; ++c) {
    const double share = pixel.a / 255.0, v = (pixel[c] * share + behind * (1.0 - share)) / 255.0;
    sum += weights[c] * (v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
  }
  return sum;
}

TEST(StoryPanel, ItsContrastIsSevenToOneBeforeAnyPicture) {
  const auto panel = must(draw_story_panel(gate()));
  for (const double behind : {0.0, 64.0, 128.0, 255.0}) {
    // Letters are where it is opaque, its ground where nothing of a letter is: in the middle of the margin.
    double letters = 0.0;
    for (const Rgba8& pixel : panel->picture.elements())
      if (pixel.a == 255) letters = std::max(letters, luminance(pixel, behind));
    const double ground = luminance(panel->picture.at(panel->picture.width() / 2, 3), behind);
    EXPECT_GE((letters + 0.05) / (ground + 0.05), kPanelContrast) << "before " << behind;
  }
}

TEST(StoryPanel, NeverCoversTheBuilding) {
  int laid = 0, refused = 0;
  for (const double x : {-100.0, 300.0, 760.0, 1800.0})
    for (const double y : {-50.0, 500.0, 900.0})
      for (const double width : {40.0, 1200.0})
        for (const double height : {300.0, 1400.0})
          for (const bool seated : {false, true}) {
            auto request = gate();
            request.building = FlatPlace{x, y, width, height};
            request.reader = {.left_handed = laid % 2 == 1, .seated = seated, .large_print = laid % 3 == 0};
            const auto panel = draw_story_panel(request);
            if (!panel) {
              EXPECT_EQ(panel.error().kind, FaultKind::unsupported) << panel.error().message;
              ++refused;
              continue;
            }
            expect_in_its_place(request, *panel);
            if (seated) {
              EXPECT_GE(panel->place.top, 720.0);
            }
            ++laid;
          }
  EXPECT_GT(laid, 60);
  EXPECT_GT(refused, 0) << "a building that fills the screen leaves no room";
}

TEST(StoryPanel, StandsWhereTheHandIsNot) {
  auto request = gate();
  EXPECT_LT(must(draw_story_panel(request))->place.left, 760.0);
  request.reader.left_handed = true;
  EXPECT_GE(must(draw_story_panel(request))->place.left, 1160.0);
  request.building = FlatPlace{1300, 300, 600, 500};  // no room there
  EXPECT_LT(must(draw_story_panel(request))->place.left, 1300.0);
  request.building.reset();
  EXPECT_GE(must(draw_story_panel(request))->place.left, 640.0);
  request.building = FlatPlace{0, 300, 1920, 300};  // below it, or above
  expect_in_its_place(request, *must(draw_story_panel(request)));
}

// Height of the rows that letters of the first line fill.
int first_line_px(const StoryPanel& panel) {
  int first = -1;
  for (int y = 0; y < panel.picture.height(); ++y) {
    bool any = false;
    for (int x = 0; x < panel.picture.width(); ++x) any = any || panel.picture.at(x, y).a == 255;
    if (any && first < 0) first = y;
    if (!any && first >= 0) return y - first;
  }
  return 0;
}

TEST(StoryPanel, LargePrintIsLargerByHalfAndADegreeAtLeast) {
  auto request = gate();
  request.title = "H";
  const int usual = first_line_px(*must(draw_story_panel(request)));
  request.reader.large_print = true;
  const int large = first_line_px(*must(draw_story_panel(request)));
  EXPECT_NEAR(1.0 * large / usual, 1.5, 0.1);
  request.reader.pixels_per_degree = 60.0;  // read from afar: an em of 60 pixels, in the title of 75
  EXPECT_NEAR(first_line_px(*must(draw_story_panel(request))), 0.73 * 75.0, 3.0) << "DejaVu's capitals are .73 em high";
}

// Where letters begin and end in the rows of the last line.
std::pair<int, int> last_line(const StoryPanel& panel) {
  int bottom = panel.picture.height() - 1, top = 0;
  const auto extent = [&](int y) {
    std::pair found(panel.picture.width(), -1);
    for (int x = 0; x < panel.picture.width(); ++x)
      if (panel.picture.at(x, y).a == 255) found = {std::min(found.first, x), std::max(found.second, x)};
    return found;
  };
  while (bottom > 0 && extent(bottom).second < 0) --bottom;
  std::pair whole(panel.picture.width(), -1);
  for (top = bottom; top > 0 && extent(top).second >= 0; --top) {
    const auto row = extent(top);
    whole = {std::min(whole.first, row.first), std::max(whole.second, row.second)};
  }
  return whole;
}

TEST(StoryPanel, LinesBeginWhereTheirScriptDoes) {
  PanelRequest request = gate();
  request.title.clear();
  request.text = "A line that is rather long, as lines of a story are.\nShort.";
  const auto english = must(draw_story_panel(request));
  EXPECT_LT(last_line(*english).first, english->picture.width() / 6);
  EXPECT_LT(last_line(*english).second, english->picture.width() / 2);
  request.language = "he";
  request.text = "שורה ארוכה למדי כפי ששורות של סיפור הן בדרך כלל.\nKyoto היא";
  const auto hebrew = must(draw_story_panel(request));
  EXPECT_THAT(hebrew->faults, testing::IsEmpty()) << "DejaVu Sans has these letters";
  EXPECT_GT(last_line(*hebrew).first, hebrew->picture.width() / 2) << "though the paragraph begins in Latin letters";
  EXPECT_GT(last_line(*hebrew).second, hebrew->picture.width() * 5 / 6);
}

TEST(StoryPanel, HostileTextIsBounded) {
  auto request = gate();
  std::string many;
  while (many.size() < 9'900) many += "word ";
  for (const std::string& text :
       {many, std::string(9'900, 'x'), std::string(9'900, '\n') + "x", std::string(9'900, '\t')}) {
    request.text = text;
    const auto began = std::chrono::steady_clock::now();
    const auto panel = must(draw_story_panel(request));
    expect_in_its_place(request, *panel);
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(20));
  }
  request.text = many;
  const auto cut = must(draw_story_panel(request));
  EXPECT_GT(cut->left_out, 0U);
  EXPECT_THAT(cut->faults, testing::Contains(HasSubstr("lines more than the panel shows")));
  request.text = std::string(10'001, 'x');
  EXPECT_THAT(draw_story_panel(request), FailsAs(FaultKind::bad_input, HasSubstr("expected 10000 at most")));
  request.text = "\xff\xfe";
  EXPECT_THAT(draw_story_panel(request), FailsAs(FaultKind::bad_input, HasSubstr("UTF-8")));
  request.text = "";
  EXPECT_THAT(draw_story_panel(request), FailsAs(FaultKind::bad_input, HasSubstr("no text")));
  request = gate();
  request.width = 10;
  EXPECT_THAT(draw_story_panel(request), FailsAs(FaultKind::bad_input, HasSubstr("a screen of 10 x 1080")));
}

}  // namespace
}  // namespace kasumi

// Messages on the picture: their texts and rendering.
#include <atomic>
#include <chrono>
#include <filesystem>
#include <set>

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "base/files.hpp"
#include "pipeline/show/stage/caption.hpp"
#include "pipeline/site/config/messages.hpp"
#include "tests/pipeline/show/stage/harfbuzz_line.hpp"
#include "tests/places.hpp"

namespace {
std::atomic<int> font_maps{0};  // that were made
}

// In place of Pango's, which it calls; the types are Pango's and Cairo's.
extern "C" void* pango_cairo_font_map_new_for_font_type(int type) {
  ++font_maps;
  static const auto pangos =
      reinterpret_cast<void* (*)(int)>(::dlsym(RTLD_NEXT, "pango_cairo_font_map_new_for_font_type"));
  return pangos(type);
}

namespace kasumi {
namespace {

using testing::HasSubstr;

#define ASSERT_OK(result) ASSERT_TRUE((result).has_value()) << (result).error().message

TEST(Messages, EveryLanguageHasItsOwnTextForEveryMessage) {
  for (const Language language : all_languages()) {
    std::set<std::string_view> said;
    for (const Message message : kMessages) {
      const auto sentence = message_text(message, language);
      EXPECT_FALSE(sentence.empty()) << code_of(language) << ", message " << static_cast<int>(message);
      if (language != Language::english) {
        EXPECT_NE(sentence, message_text(message, Language::english)) << code_of(language);
      }
      said.insert(sentence);
    }
    EXPECT_EQ(said.size(), std::size(kMessages)) << code_of(language) << ": two messages say the same";
  }
  EXPECT_EQ(std::size(kMessages), static_cast<std::size_t>(Message::earlier_content) + 1);
}

TEST(Messages, LanguagesAreNamedByTheirCodes) {
  for (const Language language : all_languages()) EXPECT_EQ(parse_language(code_of(language)), language);
  EXPECT_EQ(name_of(*parse_language("ja")), "日本語");
  EXPECT_EQ(Language::english, *parse_language("en"));
  const auto wrong = parse_language("tlh");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().kind, FaultKind::bad_input);
  EXPECT_THAT(wrong.error().message, testing::AllOf(HasSubstr("tlh"), HasSubstr("en, de, fr, it, es, ja")));
}

class Captions : public testing::Test {
 protected:
  void SetUp() override {
    if (const auto drawn = draw_caption("x", {}); !drawn && drawn.error().kind == FaultKind::unsupported)
      GTEST_SKIP() << drawn.error().message;
  }
  static Image<Rgba8> draw(const std::string& text, const CaptionStyle& style = {}) {
    auto drawn = draw_caption(text, style);
    EXPECT_TRUE(drawn.has_value()) << (drawn ? "" : drawn.error().message);
    return drawn ? *drawn : Image<Rgba8>();
  }
};

bool has_word(const Rgba8& p) {
  return p.r > 128;
}

// Columns [first, last] that contain text.
std::pair<int, int> columns_with_words(const Image<Rgba8>& picture) {
  int first = picture.width(), last = -1;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      if (has_word(picture.at(x, y))) first = std::min(first, x), last = std::max(last, x);
  return {first, last};
}

// Pango's threads sort fonts for a map of them and read the map when they are done. They outlive a text, and a freed map
// ends the program, if rarely: texts one after another are to be of one map.
TEST_F(Captions, OneAfterAnotherUseOneMapOfFonts) {
  draw("first");
  const int before = font_maps;
  for (int i = 0; i < 40; ++i) draw("label " + std::to_string(i), {.height_px = 20.0 + i});
  EXPECT_EQ(font_maps, before);
  EXPECT_GT(font_maps, 0);
}

TEST_F(Captions, AreLightOnADarkRoundedBackground) {
  const Image<Rgba8> picture = draw("Himeji");
  const int w = picture.width(), h = picture.height();
  EXPECT_EQ(picture.at(0, 0).a, 0) << "corners are cut";
  EXPECT_EQ(picture.at(w - 1, h - 1).a, 0);
  const Rgba8 ground = picture.at(w / 2, 1);
  EXPECT_GT(ground.a, 128);
  EXPECT_LT(ground.a, 255);
  EXPECT_LT(ground.r, 40);
  std::set<int> corner;
  for (int x = 0; x < 16; ++x)
    for (int y = 0; y < 16; ++y) corner.insert(picture.at(x, y).a);
  EXPECT_GT(corner.size(), 5u) << "the corner is anti-aliased";
  std::set<int> greys;
  for (const Rgba8& p : picture.elements()) greys.insert(p.r);
  EXPECT_GT(greys.size(), 20u) << "the letters are anti-aliased";
  EXPECT_GE(*greys.rbegin(), 240);
}

TEST_F(Captions, AreCentredOnTheirBackground) {
  const Image<Rgba8> picture = draw("HHHH", {.height_px = 64});
  const auto [first, last] = columns_with_words(picture);
  EXPECT_NEAR(first, picture.width() - 1 - last, 2) << "pixels left and right";
  for (int y = 0; y < picture.height(); ++y)  // left and right halves mirror each other
    EXPECT_EQ(picture.at(0, y).a, picture.at(picture.width() - 1, y).a);
}

TEST_F(Captions, RefuseWhatIsNotUtf8) {
  // A lone continuation byte, a truncated sequence, Latin-1, overlong (Unicode 15, table 3-7), a surrogate, beyond
  // U+10FFFF.
  for (const char* bytes : {"\x80", "\xE6\xBC", "caf\xE9", "\xC0\xAF", "\xE0\x9F\xBF", "\xF0\x8F\xBF\xBF",
                            "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xF8\x88\x80\x80\x80", "\xFF"})
    EXPECT_FALSE(draw_caption(bytes, {}).has_value()) << testing::PrintToString(bytes);
  EXPECT_THAT(draw_caption("caf\xE9", {}).error().message, HasSubstr("byte 3 (0xe9) is not UTF-8"));
}

TEST_F(Captions, BreakWithinTheirWidthAndKeepTheirHeight) {
  const std::string text{message_text(Message::sky_camera_missing, *parse_language("de"))};
  const Image<Rgba8> one = draw(text, {.height_px = 30, .largest_width_px = 4000});
  const Image<Rgba8> three = draw(text, {.height_px = 30, .largest_width_px = 600});
  EXPECT_GT(one.width(), 1000);
  EXPECT_LE(three.width(), 600);
  const int more = three.height() - one.height();
  EXPECT_GE(more, 30);
  EXPECT_EQ(more % 30, 0) << "whole lines";
}

TEST_F(Captions, GrowInProportion) {
  const auto small = columns_with_words(draw("Turbidity", {.height_px = 32}));
  const auto large = columns_with_words(draw("Turbidity", {.height_px = 128}));
  EXPECT_NEAR(large.second - large.first, 4.0 * (small.second - small.first), 8.0) << "pixels: no rounding per letter";
}

TEST_F(Captions, KernTheirLetters) {
  // The pen advances less between V and A than between H and H.
  const auto width = [](const char* text) { return draw(text, {.height_px = 400, .largest_width_px = 16000}).width(); };
  const int a = width("AA") - width("A"), v = width("VV") - width("V");
  EXPECT_LT(width("AVAVAV") + 20, width("A") + 2 * a + 3 * v);
}

TEST_F(Captions, ShowABoxForMissingGlyphs) {
  // Private use: none of these fonts defines it.
  const auto [first, last] = columns_with_words(draw("\U0010FFFD", {.height_px = 64}));
  EXPECT_GT(last - first, 10);
}

TEST_F(Captions, RejectInvalidTextAndFonts) {
  EXPECT_EQ(draw_caption("caf\xE9", {}).error().kind, FaultKind::bad_input);
  EXPECT_EQ(draw_caption("x", {.height_px = 0}).error().kind, FaultKind::bad_input);
  EXPECT_EQ(draw_caption("x", {.largest_width_px = 0}).error().kind, FaultKind::bad_input);
  EXPECT_EQ(draw_caption(std::string(100000, 'x'), {}).error().kind, FaultKind::bad_input);
  const auto no_font = draw_caption("x", {.font_file = source_folder() / "README.md"});
  ASSERT_FALSE(no_font);
  EXPECT_EQ(no_font.error().kind, FaultKind::bad_input);
  EXPECT_THAT(no_font.error().message, HasSubstr("README.md"));
  EXPECT_EQ(draw_caption("x", {.font_file = "no/such/font.ttf"}).error().kind, FaultKind::bad_input);
}

TEST_F(Captions, OfThousandsOfCharactersAreDrawnInTheTimeTheyTake) {
  const auto began = std::chrono::steady_clock::now();
  std::string long_text, long_word(10'000, 'x'), heaped = "a";
  while (long_text.size() < 9'999) long_text += "\u971e";
  while (heaped.size() < 9'999) heaped += "\u0301";  // accents on one letter
  for (const auto& text : {long_text, long_word, heaped}) {
    const auto picture = draw(text, {.height_px = 20});
    EXPECT_LE(picture.width(), 1200);
    EXPECT_LE(picture.height(), 8 * 3 * 20 + 40);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(20));
  const auto longer = draw_caption(std::string(20000, 'x'), {});
  ASSERT_FALSE(longer);
  EXPECT_THAT(longer.error().message, HasSubstr("20000 bytes: expected 10000 at most"));
}

// DejaVu Sans whose em is said to have 16 units, not 2048: its H would be 22,000 pixels tall and take half a gigabyte.
TEST_F(Captions, AFontsGiantGlyphsTakeNoMoreThanThePicture) {
  const std::filesystem::path installed = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  auto bytes = read_file(installed);
  if (!bytes) GTEST_SKIP() << bytes.error().message;
  const auto number = [&](std::size_t at, int count) {
    std::size_t value = 0;
    for (int i = 0; i < count; ++i) value = value << 8u | (*bytes)[at + static_cast<std::size_t>(i)];
    return value;
  };
  const std::size_t tables = number(4, 2);
  for (std::size_t i = 0; i < tables; ++i) {
    const std::size_t entry = 12 + 16 * i;
    if (std::string(bytes->begin() + static_cast<std::ptrdiff_t>(entry),
                    bytes->begin() + static_cast<std::ptrdiff_t>(entry + 4)) != "head")
      continue;
    const auto units_per_em = number(entry + 8, 4) + 18;  // OpenType 1.9, "head"
    ASSERT_EQ(number(units_per_em, 2), 2048u);
    (*bytes)[units_per_em] = 0;
    (*bytes)[units_per_em + 1] = 16;
  }
  std::filesystem::create_directories(test_output_folder());
  const auto hostile = test_output_folder() / "giant.ttf";
  ASSERT_TRUE(write_file(hostile, *bytes));
  const CaptionStyle style{.font_file = hostile, .height_px = 512};
  const auto giant = draw("H", style);
  EXPECT_LE(giant.width(), 1200);
  EXPECT_LE(giant.height(), 4 * 512);
  const auto of_usual = columns_with_words(draw("H", {.font_file = installed, .height_px = 512}));
  EXPECT_LT(of_usual.first, of_usual.second);
}

// The part of a picture that holds something.
cv::Mat ink_of(const cv::Mat& coverage) {
  std::vector<cv::Point> points;
  cv::findNonZero(coverage > 0.3, points);
  return points.empty() ? cv::Mat() : coverage(cv::boundingRect(points)).clone();
}
cv::Mat ink_of(const Image<Rgba8>& caption) {
  cv::Mat coverage(caption.height(), caption.width(), CV_32F);
  for (int y = 0; y < caption.height(); ++y)
    for (int x = 0; x < caption.width(); ++x)
      coverage.at<float>(y, x) = static_cast<float>(std::max(0, caption.at(x, y).r - 17)) / 230.0f;
  return ink_of(coverage);
}
// Correlation of two lines, wherever their first pixel begins.
double alike(const cv::Mat& a, const cv::Mat& b) {
  if (a.empty() || b.empty() || std::abs(a.cols - b.cols) > 2 || std::abs(a.rows - b.rows) > 2) return 0.0;
  cv::Mat framed, other, agreement;
  cv::copyMakeBorder(a, framed, 3, 3, 3, 3, cv::BORDER_CONSTANT, 0.0);
  cv::copyMakeBorder(b, other, 1, 1, 1, 1, cv::BORDER_CONSTANT, 0.0);
  for (auto* part : {&framed, &other}) cv::GaussianBlur(*part, *part, {3, 3}, 0.0);
  cv::matchTemplate(framed, other, agreement, cv::TM_CCOEFF_NORMED);
  double best = 0.0;
  cv::minMaxLoc(agreement, nullptr, &best);
  return best;
}

// Arabic joins its letters and runs to the left, as Hebrew does; Latin kerns, Vietnamese heaps accents. HarfBuzz and
// FreeType by themselves are the measure.
TEST_F(Captions, AreShapedAsHarfBuzzShapesThem) {
  const std::filesystem::path font = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  if (!std::filesystem::exists(font)) GTEST_SKIP() << font << " is not installed";
  for (const char* text : {"مَعْبَدٌ كَانَ هُنَا", "كان المعبد هنا", "המקדש עמד כאן", "AVATAR To Wave", "đền cổ ở đây"}) {
    SCOPED_TRACE(text);
    const auto ours = ink_of(draw(text, {.font_file = font, .height_px = 72, .largest_width_px = 3000}));
    double best = 0.0;
    for (const double shift_px : {0.0, 0.25, 0.5, 0.75}) {
      const auto theirs = harfbuzz_line(text, font, 60.0, shift_px);
      const cv::Mat drawn(theirs.height(), theirs.width(), CV_32F, const_cast<float*>(theirs.elements().data()));
      best = std::max(best, alike(ours, ink_of(drawn)));
    }
    EXPECT_GE(best, 0.99);
  }
}

// A Hebrew name within English stands where its reader looks for it: the letters from the right, the sentence from the
// left.
TEST_F(Captions, MixDirectionsAsUnicodeOrdersThem) {
  const std::filesystem::path font = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  if (!std::filesystem::exists(font)) GTEST_SKIP() << font << " is not installed";
  const CaptionStyle style{.font_file = font, .height_px = 72, .largest_width_px = 3000};
  const auto stored = ink_of(draw("ab אבג cd", style));
  const auto seen = ink_of(draw("ab \u202dגבא\u202c cd", style));  // the letters' order forced, as they are seen
  EXPECT_GT(alike(stored, seen), 0.98);
}

TEST_F(Captions, SayWhatTheFontsCannotShow) {
  EXPECT_THAT(*caption_faults("Himeji 3.5 km", {}), testing::IsEmpty());
  const auto faults = caption_faults("the castle \U0010FFFDx stood here", {});
  ASSERT_TRUE(faults);
  ASSERT_THAT(*faults, testing::SizeIs(1));
  EXPECT_THAT(faults->front(), HasSubstr("\"\U0010FFFDx\""));
  // Adlam: of all fonts in Debian only Noto's have it. Korean: DejaVu does not.
  for (const auto& [text, package] :
       {std::pair("\U0001E900\U0001E901", "fonts-noto-core"), std::pair("한국어", "fonts-noto-cjk")}) {
    const auto missing = caption_faults(text, {});
    ASSERT_TRUE(missing);
    if (!missing->empty()) {
      EXPECT_THAT(missing->front(), HasSubstr(std::string("apt install ") + package));
    }
  }
}

TEST_F(Captions, AreCutOffAfterEightLines) {
  std::string text;
  for (int i = 0; i < 12; ++i) text += fmt::format("line {}\n", i);
  const CaptionStyle style{.height_px = 30};
  const auto eight = draw("1\n2\n3\n4\n5\n6\n7\n8", style);
  EXPECT_EQ(draw(text, style).height(), eight.height());
  EXPECT_THAT(*caption_faults(text, style), testing::Contains(HasSubstr("5 lines more than the 8")));
  EXPECT_EQ(draw(std::string(3000, '\n'), style).height(), eight.height());
  EXPECT_LE(draw(std::string(9000, 'w'), style).height(), eight.height());
}

// For visual inspection: every message in every language over a grey sky.
TEST_F(Captions, AreWrittenForInspection) {
  std::filesystem::create_directories(test_output_folder());
  for (const Language language : all_languages()) {
    cv::Mat sheet(1200, 1280, CV_8UC3, cv::Scalar(205, 190, 170));
    int top = 10;
    for (const Message message : kMessages) {
      const Image<Rgba8> picture =
          draw(std::string(message_text(message, language)), {.height_px = 30, .largest_width_px = 800});
      ASSERT_LE(picture.width(), 800);
      for (int y = 0; y < picture.height() && top + y < sheet.rows; ++y)
        for (int x = 0; x < picture.width(); ++x) {
          const Rgba8 over = picture.at(x, y);
          auto& below = sheet.at<cv::Vec3b>(top + y, 20 + x);
          for (int c = 0; c < 3; ++c)
            below[c] = static_cast<std::uint8_t>((over[2 - c] * over.a + below[c] * (255 - over.a) + 127) / 255);
        }
      top += picture.height() + 8;
    }
    EXPECT_LE(top, sheet.rows);
    cv::imwrite(fmt::format("{}/words-{}.png", test_output_folder().string(), code_of(language)), sheet);
  }
}

}  // namespace
}  // namespace kasumi

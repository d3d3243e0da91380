// kasumi calibrate board: the printed board has its stated size.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <regex>

#include "pipeline/install/calibrate/board_sheet.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/install/calibrate/calibrating.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

TEST(BoardSheet, ACheckerboardIsTrueToScaleAndCentredOnItsPaper) {
  const auto sheet = lay_out(Board{8, 5, 0.025}).value();  // 9 x 6 squares: 225 x 150 mm
  EXPECT_EQ(sheet.paper, "A4");
  ASSERT_EQ(sheet.black.size(), 27u);
  double left = 1e9, right = 0.0, area = 0.0;
  for (const auto& box : sheet.black) {
    left = std::min(left, 1e3 * box.corner_m.x);
    right = std::max(right, 1e3 * (box.corner_m.x + box.side_m));
    area += 1e6 * box.side_m * box.side_m;
  }
  EXPECT_NEAR(right - left, 225.0, 1e-9);
  EXPECT_NEAR(left + right, 297.0, 1e-9);
  EXPECT_NEAR(area, 27 * 625.0, 1e-6);
  EXPECT_EQ(lay_out(Board{8, 5, 0.04}).value().paper, "A3");
  EXPECT_FALSE(lay_out(Board{40, 40, 0.1}));
}

TEST(BoardSheet, ThePdfsOffsetsAreCorrect) {
  const auto pdf = pdf_of(lay_out(CharucoBoard{8, 6, 0.03, 0.022, "DICT_4X4_50"}).value());
  // Each object is at the table's offset, and the stream has its stated length.
  const auto table_at = static_cast<std::size_t>(std::atol(pdf.c_str() + pdf.find("startxref") + 10));
  ASSERT_EQ(pdf.compare(table_at, 4, "xref"), 0);
  std::istringstream table(pdf.substr(table_at));
  std::string line;
  for (int i = 0; i < 3; ++i) std::getline(table, line);
  for (int object = 1; object <= 5; ++object) {
    std::getline(table, line);
    EXPECT_EQ(line.size(), 19u);
    const auto at = static_cast<std::size_t>(std::atol(line.c_str()));
    const auto head = fmt::format("{} 0 obj", object);
    EXPECT_EQ(pdf.compare(at, head.size(), head), 0) << object;
  }
  std::smatch length;
  ASSERT_TRUE(std::regex_search(pdf, length, std::regex("/Length ([0-9]+)")));
  const auto begin = pdf.find("stream\n") + 7;
  EXPECT_EQ(pdf.find("endstream") - begin, static_cast<std::size_t>(std::stol(length[1])));
  EXPECT_THAT(pdf, HasSubstr("/MediaBox [0 0 841.8898 595.2756]"));  // A4 landscape, in points
  EXPECT_THAT(pdf, HasSubstr("\\(DICT_4X4_50, squares of 30 mm, markers of 22 mm\\)"));
}

TEST(CalibrateBoard, WritesAPageAndReportsAllProblemsAtOnce) {
  const auto folder = fresh_folder("calibrate-board");
  const auto file = folder / "board.svg";
  const auto done = ended(0, run("board --charuco 8x6 --square-mm 30 --marker-mm 22 --out " + file.string()));
  EXPECT_THAT(done.out, HasSubstr("on A4"));
  const auto svg = read_text_file(file).value();
  EXPECT_THAT(svg, HasSubstr("width=\"297mm\" height=\"210mm\" viewBox=\"0 0 297 210\""));
  EXPECT_THAT(svg, HasSubstr("width=\"30\" height=\"30\""));

  const auto wrong =
      ended(2, run("board --charuco 8by6 --square-mm 30 --marker-mm 40 --dictionary DICT_0 --out b.gif"));
  for (const char* part : {"--charuco 8by6", "--marker-mm 40", "--dictionary DICT_0", "--out b.gif"})
    EXPECT_THAT(wrong.err, HasSubstr(part));
}

}  // namespace
}  // namespace kasumi

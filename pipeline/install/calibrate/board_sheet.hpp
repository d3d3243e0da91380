// A calibration board as a page to print to scale.
#pragma once

#include <string>
#include <vector>

#include "base/result.hpp"
#include "calib/board/any_board.hpp"

namespace kasumi {

struct BoardSheet {
  std::string paper;            // "A4", "A3", ...: the smallest that fits, landscape
  glm::dvec2 page_mm{};         // width and height
  std::vector<BlackBox> black;  // metres from the page's top left corner
  glm::dvec2 ruler_mm{};        // the left end of a line of 100 mm
  std::string caption;          // under the board
};
constexpr double kRuler_mm = 100.0;

// With a white margin of at least 8 mm and a 100 mm line to verify the print's scale. Errors (bad_input): larger
// than A0.
Result<BoardSheet> lay_out(const AnyBoard& board);

std::string svg_of(const BoardSheet& sheet);
std::string pdf_of(const BoardSheet& sheet);  // PDF 1.4

}  // namespace kasumi

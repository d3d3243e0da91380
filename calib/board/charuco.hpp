// A board of squares with markers in the white ones: it is recognised when part of it is out of the picture or hidden,
// so that its corners reach a fisheye's rim. And every board as it is printed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec2.hpp>

#include "base/image.hpp"
#include "base/result.hpp"
#include "calib/board/board.hpp"

namespace kasumi {

struct CharucoBoard {
  int columns = 0;  // squares along one side; there is one inner corner less
  int rows = 0;     // and along the other
  double square_m = 0.0;
  double marker_m = 0.0;                   // side of a marker, its black border included
  std::string dictionary = "DICT_4X4_50";  // as OpenCV calls it
};

// What is wrong with it, in the options' words; empty when nothing is.
std::vector<std::string> problems_of(const CharucoBoard& board);

// The inner corners that are seen, six or more that do not lie on a line; none otherwise, or when problems_of tells.
std::optional<BoardView> find_charuco(const Image<std::uint8_t>& grey, const CharucoBoard& board, std::string name);

// What is black of a board, in its squares' unit, from its top left corner, y down.
struct BlackBox {
  glm::dvec2 corner_m{};
  double side_m = 0.0;
};
std::vector<BlackBox> black_of(const CharucoBoard& board);  // which has no problems
std::vector<BlackBox> black_of(const Board& board);         // one square more than inner corners each way

}  // namespace kasumi

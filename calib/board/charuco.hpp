// A checkerboard with markers in the white squares. It is recognised even when partly hidden or outside the picture,
// so its corners reach a fisheye's rim. Also the printed layout of both kinds of board.
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

// Its problems, by the options' names; empty when there are none.
std::vector<std::string> problems_of(const CharucoBoard& board);

// The inner corners that are seen, at least six and not collinear; empty otherwise, or when the board has problems.
std::optional<BoardView> find_charuco(const Image<std::uint8_t>& grey, const CharucoBoard& board, std::string name);

// The black areas of a board, in metres from its top left corner, y down.
struct BlackBox {
  glm::dvec2 corner_m{};
  double side_m = 0.0;
};
std::vector<BlackBox> black_of(const CharucoBoard& board);  // which has no problems
std::vector<BlackBox> black_of(const Board& board);         // one square more than inner corners each way

}  // namespace kasumi

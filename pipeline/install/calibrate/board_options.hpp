// The options for the board, which `calibrate lens` and `calibrate board` share.
#pragma once

#include <string>

#include "base/result.hpp"
#include "calib/board/any_board.hpp"

namespace CLI {
class App;
}

namespace kasumi {

struct BoardOptions {
  std::string board, charuco;
  double square_mm = 0.0, marker_mm = 0.0;
  std::string dictionary = "DICT_4X4_50";
};
void add_board_options(CLI::App& command, BoardOptions& arguments);

// Adds every problem; the result is then a 3 x 3 checkerboard. `with_size`: a checkerboard needs the size of its
// squares, too.
AnyBoard read_board(const BoardOptions& arguments, bool with_size, Problems& problems);

}  // namespace kasumi

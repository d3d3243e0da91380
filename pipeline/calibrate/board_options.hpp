// Which board is meant, by the options that `calibrate lens` and `calibrate board` share.
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

// A checkerboard 3 x 3 and a problem for each thing wrong when it is not one of the two, whole. `with_size`: squares of
// a checkerboard need a size, too.
AnyBoard read_board(const BoardOptions& arguments, bool with_size, Problems& problems);

}  // namespace kasumi

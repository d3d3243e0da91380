#include "pipeline/install/calibrate/board_options.hpp"

#include <cstdio>

#include <CLI/CLI.hpp>

namespace kasumi {

namespace {

std::optional<glm::ivec2> counts_of(const std::string& text) {
  glm::ivec2 counts{0};
  char end = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &counts.x, &counts.y, &end) != 2) return std::nullopt;
  const auto fine = [](int count) { return count >= 3 && count <= 100; };
  if (!fine(counts.x) || !fine(counts.y)) return std::nullopt;
  return counts;
}

}  // namespace

void add_board_options(CLI::App& command, BoardOptions& arguments) {
  auto& a = arguments;
  command.add_option("--board", a.board, "Checkerboard, as its number of inner corners")->type_name("COLUMNSxROWS");
  command.add_option("--charuco", a.charuco, "ChArUco board, as its number of squares; may be partly visible")
      ->type_name("COLUMNSxROWS");
  command.add_option("--square-mm", a.square_mm, "Side of a square, measured on the print");
  command.add_option("--marker-mm", a.marker_mm, "Side of a ChArUco marker, including its black border");
  command.add_option("--dictionary", a.dictionary, "Marker dictionary of the ChArUco board, by OpenCV's name")
      ->capture_default_str();
}

AnyBoard read_board(const BoardOptions& arguments, bool with_size, Problems& problems) {
  const Board none{3, 3, 0.03};
  if (arguments.board.empty() == arguments.charuco.empty()) {
    problems.add(
        "--board {}, --charuco {}: expected one of them, like --board 8x6 (inner corners: one less than its "
        "squares each way) or --charuco 8x6 (squares)",
        arguments.board.empty() ? "(none)" : arguments.board, arguments.charuco.empty() ? "(none)" : arguments.charuco);
    return none;
  }
  if (!arguments.board.empty()) {
    const auto counts = counts_of(arguments.board);
    if (!counts)
      problems.add("--board {}: expected the board's inner corners, like 8x6: one less than its squares each way",
                   arguments.board);
    if (arguments.square_mm < 0.0 || (with_size && !(arguments.square_mm > 0.0)))
      problems.add("--square-mm {}: expected the side of a square, more than 0", arguments.square_mm);
    if (arguments.marker_mm != 0.0) problems.add("--marker-mm: expected with --charuco only");
    if (!counts) return none;
    return Board{counts->x, counts->y, arguments.square_mm > 0.0 ? 1e-3 * arguments.square_mm : 1.0};
  }
  const auto counts = counts_of(arguments.charuco);
  if (!counts) problems.add("--charuco {}: expected the board's squares, like 8x6", arguments.charuco);
  const auto size = counts.value_or(glm::ivec2{3, 3});
  CharucoBoard board{size.x, size.y, 1e-3 * arguments.square_mm, 1e-3 * arguments.marker_mm, arguments.dictionary};
  const auto wrong = problems_of(board);
  for (const auto& problem : wrong) problems.add("{}", problem);
  if (!counts || !wrong.empty()) return none;
  return board;
}

}  // namespace kasumi

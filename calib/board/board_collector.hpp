// Collects views of a board from a live camera: which to keep, and what the next should be.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calib/board/any_board.hpp"

namespace kasumi {

// How a board leans, as its squares' sizes show: the side named is nearer.
enum class Lean { left, right, top, bottom };
constexpr int kLeans = 4;

class BoardCollector {
 public:
  enum class Found {
    nothing,  // no board
    moving,   // since the previous frame
    blurred,
    known,  // like a view that was taken
    taken,
  };

  explicit BoardCollector(AnyBoard board) : board_(std::move(board)) {}

  // Frames of one size. `name`: for the view if it is taken.
  Found look(const Image<std::uint8_t>& grey, const std::string& name);

  static constexpr int kCells = kCoverageCells;  // along each side of the picture
  enum class Cell { dark, bare, covered };       // dark: outside the image circle
  Cell cell(int column, int row) const;
  double covered() const;  // share of the cells that are not dark
  bool leaned(Lean lean) const { return leaned_[static_cast<std::size_t>(lean)]; }
  const std::vector<BoardView>& views() const { return views_; }
  const std::optional<BoardView>& seen() const { return seen_; }  // in the last frame

  // 12 views, .8 of the picture, leaned all four ways.
  bool enough() const;
  // What to do next, in words: "move the board to the lower left and tilt it, its right side nearer".
  std::string advice() const;
  std::string map() const;  // a line for each row of cells: "#" covered, "." bare, " " dark

 private:
  void look_for_light(const Image<std::uint8_t>& grey);
  bool adds(const BoardView& view) const;
  void take(BoardView view);

  AnyBoard board_;
  int width_ = 0, height_ = 0;
  std::vector<BoardView> views_;
  std::optional<BoardView> seen_;
  std::array<bool, kCells * kCells> lit_{}, covered_{};
  std::array<bool, kLeans> leaned_{};
  std::array<bool, 9 * (kLeans + 1)> known_{};  // a ninth of the picture, and a lean or none
};

std::string_view message_of(BoardCollector::Found found);  // "hold it still"

}  // namespace kasumi

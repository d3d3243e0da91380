#include "calib/board/any_board.hpp"

#include <fmt/format.h>

namespace kasumi {

std::optional<BoardView> find_any_board(const Image<std::uint8_t>& grey, const AnyBoard& board, std::string name,
                                        bool fast) {
  if (const auto* charuco = std::get_if<CharucoBoard>(&board)) return find_charuco(grey, *charuco, std::move(name));
  return find_board(grey, std::get<Board>(board), std::move(name), fast);
}

std::string description_of(const AnyBoard& board) {
  if (const auto* charuco = std::get_if<CharucoBoard>(&board))
    return fmt::format("ChArUco board of {} x {} squares ({}, squares of {:.4g} mm, markers of {:.4g} mm)",
                       charuco->columns, charuco->rows, charuco->dictionary, 1e3 * charuco->square_m,
                       1e3 * charuco->marker_m);
  const auto& checkerboard = std::get<Board>(board);
  return fmt::format("checkerboard of {} x {} inner corners", checkerboard.columns, checkerboard.rows);
}

}  // namespace kasumi

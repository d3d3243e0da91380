// A board of either kind.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "base/image.hpp"
#include "calib/board/board.hpp"
#include "calib/board/charuco.hpp"

namespace kasumi {

using AnyBoard = std::variant<Board, CharucoBoard>;

// As find_board and find_charuco; `fast` affects only the former.
std::optional<BoardView> find_any_board(const Image<std::uint8_t>& grey, const AnyBoard& board, std::string name,
                                        bool fast = false);
std::string description_of(const AnyBoard& board);  // "checkerboard of 8 x 6 inner corners"

}  // namespace kasumi

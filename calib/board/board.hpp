// The checkerboard that a lens is calibrated with, and where a picture shows its inner corners.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "base/image.hpp"

namespace kasumi {

struct Board {
  int columns = 0;        // inner corners along one side
  int rows = 0;           // and along the other
  double square_m = 1.0;  // side of a square; sets the unit of distances only, no lens depends on it
};

// One picture of the board. Which corner is the first does not matter: every view has a pose of its own.
struct BoardView {
  std::string name;                  // of the picture, for people
  std::vector<glm::dvec2> pixels;    // sub-pixel
  std::vector<glm::dvec2> on_board;  // the same corners in metres, in the board's plane
  // To locate the corners again once the lens is known (refine_corners); null: they stay.
  std::shared_ptr<const Image<std::uint8_t>> picture{};
  double clear_m = 0.0;  // within this distance of a corner only its own four squares are printed
};

// Cells along each side of a picture, in which coverage by the board is counted.
constexpr int kCoverageCells = 6;

// Every inner corner, or none. The whole board must be in the picture. Unless `fast`, what the usual finder misses is
// searched for by a second, slower one.
std::optional<BoardView> find_board(const Image<std::uint8_t>& grey, const Board& board, std::string name,
                                    bool fast = false);

}  // namespace kasumi

// Drawn pictures of boards seen through a lens.
#pragma once

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/image.hpp"
#include "calib/board/board.hpp"
#include "calib/lens/lens.hpp"
#include "calib/lens/lens_fit.hpp"

namespace kasumi {

// The chessboard with a white margin of one square, in front of a grey wall; `fine` x `fine` rays a pixel.
inline Image<std::uint8_t> picture_of_board(const Lens& lens, int width, int height, const Board& board,
                                            const BoardPose& pose, int fine) {
  Image<std::uint8_t> picture(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0.0;
      for (int i = 0; i < fine * fine; ++i) {
        const auto ray = lens.unproject({x + (i % fine + 0.5) / fine - 0.5, y + (i / fine + 0.5) / fine - 0.5});
        double level = 190.0;
        if (ray) {
          const double along = glm::dot(pose.translation_m, pose.rotation[2]) / glm::dot(*ray, pose.rotation[2]);
          const glm::dvec3 at = glm::transpose(pose.rotation) * (along * *ray - pose.translation_m) / board.square_m;
          const double u = std::floor(at.x), v = std::floor(at.y);
          if (along > 0.0 && u >= -1 && v >= -1 && u < board.columns && v < board.rows)
            level = std::fmod(u + v + 4.0, 2.0) == 0.0 ? 30.0 : 220.0;
        }
        sum += level;
      }
      picture.at(x, y) = static_cast<std::uint8_t>(std::lround(sum / (fine * fine)));
    }
  return picture;
}

// Faces the camera 0.2 m away, its centre off the axis, tilted.
inline BoardPose board_at(const Board& board, double right_m, double down_m, double tilt_x, double tilt_y) {
  const glm::dvec3 normal = glm::normalize(glm::dvec3{tilt_x, tilt_y, 1.0});
  const glm::dvec3 x = glm::normalize(glm::cross(glm::dvec3{0, 1, 0}, normal)), y = glm::cross(normal, x);
  BoardPose pose{{x, y, normal}, {}};
  const glm::dvec3 middle = 0.5 * board.square_m * glm::dvec3{board.columns - 1.0, board.rows - 1.0, 0.0};
  pose.translation_m = glm::dvec3{right_m, down_m, 0.2} - pose.rotation * middle;
  return pose;
}

}  // namespace kasumi

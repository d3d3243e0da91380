// The expected picture of the scene without passers, in the light of each picture.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/clock.hpp"
#include "base/image.hpp"
#include "estimator/passers/light_mix.hpp"
#include "estimator/passers/picture_part.hpp"
#include "estimator/passers/scene_memory.hpp"
#include "estimator/passers/tone.hpp"

namespace kasumi {

// People who stand still for so long become part of the scene.
constexpr Duration kUnchanged = std::chrono::minutes(12);

class ExpectedScene {
 public:
  ExpectedScene() = default;
  ExpectedScene(const PartPlace& place, const Tone& tone);

  bool known() const;
  double known_share() const;
  Duration until_known() const;  // at least

  // How a picture differs from what is expected: of each cell the difference in its own standard deviations; < 0 while
  // nothing is known.
  const Image<float>& compare(const PicturePart& picture, Duration since);
  // For how long a cell that differs has differed in the same way.
  float still_s(int column, int row) const { return cells_.at(column, row).still_s; }
  // After compare(): pixel() is valid in these cells and within `kMargin` of them.
  static constexpr int kMargin = 3;
  void expect_pixels(const Image<std::uint8_t>& cells);
  // 0..255: luma, Cb, Cr of a pixel of the part, where expect_pixels() was asked for it.
  glm::vec3 pixel(int x, int y) const;
  bool knows(int column, int row) const { return made_.at(column, row) == turn_; }
  // After expect_pixels() with the same `in_front`. `settled`: what is not in front is the scene as it should be; else
  // all of it is learnt, and soon.
  void learn(const PicturePart& picture, const Image<std::uint8_t>& in_front, Instant at, Duration since, bool settled);

  double median_luma() const { return median_luma_; }
  double detail_noise() const { return detail_noise_; }  // of the mean luma of 3 x 3 pixels, steps of 255
  double pixel_noise() const { return pixel_noise_; }    // of a pixel's

 private:
  struct Cell {
    glm::vec2 variance{1, 1};  // of what the light does not explain: luma, colour
    glm::vec3 off{0};          // its mean of late
    glm::vec3 of_late{0};      // its difference, while there is one
    float still_s = 0.0F;
    float covered_s = 0.0F;
  };
  void make_pixels(int column, int row);
  void measure_noise(const PicturePart& picture, const Image<std::uint8_t>& in_front);

  PartPlace place_;
  Tone tone_;
  SceneMemory memory_;
  LightMix mix_;
  Image<Cell> cells_;
  Image<glm::vec3> light_, expected_, rest_;  // expected, rest: Y, Cb - 128, Cr - 128
  Image<float> sigma_, score_;
  Image<float> luma_;                   // of each pixel
  Image<glm::vec2> colour_;             // of 2 x 2 pixels
  Image<std::uint32_t> made_;           // in which turn a cell's pixels were
  std::vector<float> light_sums_;       // of a cell's pixels, while they are made
  std::vector<glm::vec2> colour_sums_;  // of its 2 x 2 pixels
  std::uint32_t turn_ = 1;
  double median_luma_ = 0.0, detail_noise_ = 2.0, pixel_noise_ = 4.0;
};

}  // namespace kasumi

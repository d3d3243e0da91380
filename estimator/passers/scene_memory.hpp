// Pictures of the scene without passers, some tens in as many kinds of light as there were lately. Each is the median
// of five taken some seconds apart, which removes passers. In memory only.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "base/clock.hpp"
#include "base/image.hpp"
#include "estimator/passers/picture_part.hpp"
#include "estimator/passers/tone.hpp"

namespace kasumi {

struct RememberedFrame {
  Instant at{};
  Image<std::uint8_t> luma, blue, red;
  Image<glm::vec3> light;  // of each cell, linear: R, G, B
};

class SceneMemory {
 public:
  static constexpr std::size_t kMost = 24;  // two dozen: enough kinds of light for a mixture, and bounded memory
  static constexpr Duration kBetween = std::chrono::milliseconds(750);  // of the five

  // Whether a picture of that time is wanted for the next median. A driver's time may go backwards.
  bool wants(Instant at) const {
    return recent_.empty() || at < recent_.back().at || at - recent_.back().at >= kBetween;
  }
  // `picture`: a wanted one, free of people. True when five have come and the last median is at least `apart` old: the
  // new median is remembered. Of too many an outdated one is forgotten, else the older of the two most similar.
  bool add(RememberedFrame picture, Duration apart, const PicturePart& part, const Tone& tone);

  const std::vector<RememberedFrame>& pictures() const { return pictures_; }

 private:
  void make_room(Instant now);
  std::vector<RememberedFrame> recent_, pictures_;
};

// The means of a part's cells as linear light.
glm::vec3 light_of_cell(const glm::vec3& yuv, const YuvToRgb& conversion, const Tone& tone);

}  // namespace kasumi

// Whether what a camera delivers is a picture at all: not frozen, not covered, not saturated. A few thousand samples of
// it tell.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "base/clock.hpp"
#include "base/picture.hpp"

namespace kasumi {

// frozen: not one bit changes, not even by noise. covered: dark everywhere. white_out: saturated nearly everywhere.
enum class PictureCondition { normal, frozen, covered, white_out };
std::string_view name_of(PictureCondition condition);

// What one look at a picture finds.
struct PictureSample {
  std::uint64_t fingerprint = 0;  // of every bit of 64 of its rows
  int brightest = 0;              // 0..255, the brightest and ..
  int dim = 0;                    // .. the twentieth part from below of 32 x 24 places, each the mean of 16 samples
};
PictureSample sample_picture(const PictureView& picture);

// Follows the looks. A camera's picture always has noise, so bit for bit the same means that no picture comes; darkness
// and saturation are judged by means, in which noise does not count. Black with lamps in it is a night, not a cover;
// without any nobody can tell.
class ConditionWatch {
 public:
  explicit ConditionWatch(Duration deadline) : deadline_(deadline) {}
  PictureCondition look(const PictureSample& sample, Instant now);
  void reopened();  // what was frozen is not any more; what was covered still is

 private:
  Duration deadline_;
  std::optional<PictureSample> last_;
  PictureCondition seen_ = PictureCondition::normal;  // not yet for long enough to be said
  Instant since_{};
  Instant looked_at_{};
};

}  // namespace kasumi

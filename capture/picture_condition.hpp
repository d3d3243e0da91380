// Detects frozen, covered and saturated camera pictures from a few thousand samples.
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

// What is measured in one picture.
struct ConditionSample {
  std::uint64_t fingerprint = 0;  // hash of 64 of its rows
  int brightest = 0;              // 0..255, maximum and ..
  int dim = 0;                    // .. 5 % quantile of 32 x 24 cells, each the mean of 16 samples
};
ConditionSample sample_picture(const PictureView& picture);

// Follows the samples over time. A camera's picture always has noise, so identical bits mean that it is frozen.
// Darkness and saturation are judged by means, to be independent of noise. Black with lamps in it is night, not a
// cover; without lamps the two look the same.
class ConditionWatch {
 public:
  explicit ConditionWatch(Duration deadline) : deadline_(deadline) {}
  PictureCondition observe(const ConditionSample& sample, Instant now);
  void reopened();  // a frozen picture no longer counts as frozen; a covered one still counts as covered

 private:
  Duration deadline_;
  std::optional<ConditionSample> last_;
  PictureCondition seen_ =
      PictureCondition::normal;  // of the last sample; reported once it has lasted until the deadline
  Instant since_{};
  Instant sampled_at_{};
};

}  // namespace kasumi

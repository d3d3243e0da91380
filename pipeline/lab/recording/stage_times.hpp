// Where the time of a replay goes: what each of its stages took, which run side by side.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace kasumi {

// layers: all of a picture for which the building was drawn anew; drawing: of the others.
enum class ReplayStage { decoding, air, layers, drawing, writing };
constexpr std::array<std::string_view, 5> kReplayStageNames{"decoding", "air", "layers", "drawing", "writing"};

using StageSeconds = std::array<double, kReplayStageNames.size()>;  // in the order of ReplayStage

// "31.2 ms a picture: decoding 4.1 (13 %), air ..."; the stages add up, the run may take less.
std::string text_of(const StageSeconds& seconds, std::size_t pictures);

// Any thread may add.
class StageTimes {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static Time now() { return std::chrono::steady_clock::now(); }
  // From `started` to now.
  void add(ReplayStage stage, Time started) {
    nanoseconds_[static_cast<std::size_t>(stage)] +=
        std::chrono::duration_cast<std::chrono::nanoseconds>(now() - started).count();
  }
  StageSeconds seconds() const;

 private:
  std::array<std::atomic<std::int64_t>, kReplayStageNames.size()> nanoseconds_{};
};

}  // namespace kasumi

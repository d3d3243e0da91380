#include "pipeline/lab/recording/stage_times.hpp"

#include <numeric>

#include <fmt/format.h>

namespace kasumi {

std::string text_of(const StageSeconds& seconds, std::size_t pictures) {
  const double all = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  if (pictures == 0 || all <= 0.0) return "no picture";
  const double to_ms = 1e3 / static_cast<double>(pictures);
  std::string text = fmt::format("{:.1f} ms a picture:", to_ms * all);
  for (std::size_t i = 0; i < seconds.size(); ++i)
    text += fmt::format("{} {} {:.1f} ({:.0f} %)", i > 0 ? "," : "", kReplayStageNames[i], to_ms * seconds[i],
                        100.0 * seconds[i] / all);
  return text;
}

StageSeconds StageTimes::seconds() const {
  StageSeconds seconds{};
  for (std::size_t i = 0; i < seconds.size(); ++i) seconds[i] = 1e-9 * static_cast<double>(nanoseconds_[i].load());
  return seconds;
}

}  // namespace kasumi

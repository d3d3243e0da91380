#include "pipeline/machine/mode_log.hpp"

#include <spdlog/spdlog.h>

namespace kasumi {
namespace {

std::vector<std::string> mode_lines(const std::string& name, const CameraMode& mode) {
  std::vector<std::string> lines{fmt::format("{}: {} ({}) at {}: {}x{} {} {:.3g} /s", name, mode.card, mode.driver,
                                             mode.place, mode.width, mode.height, mode.format.text(),
                                             mode.frames_per_second)};
  for (const auto& note : mode.notes) lines.push_back(fmt::format("{}: {}", name, note));
  return lines;
}

}  // namespace

Result<std::unique_ptr<FrameSource>> ModeLog::operator()(Result<std::unique_ptr<CameraSource>> opened) {
  if (!opened) return fail(opened.error());
  auto lines = mode_lines(name_, (*opened)->mode());
  if (lines != said_)
    for (const auto& line : lines) spdlog::info("{}", line);
  said_ = std::move(lines);
  return std::move(*opened);
}

}  // namespace kasumi

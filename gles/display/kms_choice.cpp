#include "gles/display/kms_choice.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace kasumi {
namespace {

constexpr double kRateTolerance_hz = 0.6;
constexpr std::size_t kModesInWords = 24;

std::string all_in_words(const std::vector<KmsConnector>& connectors) {
  if (connectors.empty()) return "the card has no connectors";
  std::string words;
  for (const KmsConnector& connector : connectors) words += (words.empty() ? "" : "; ") + in_words(connector);
  return words;
}

bool has_display(const KmsConnector& connector) {
  return connector.connection != KmsConnection::disconnected;
}

std::string asked_in_words(int width, int height, double refresh_hz) {
  std::string words = width > 0 ? fmt::format("{}x{}", width, height) : "a mode";
  if (refresh_hz > 0) words += fmt::format(" at {:g} Hz", refresh_hz);
  return words;
}

// Whether a suits the requested rate (0: the highest) better than b.
bool better(const KmsMode& a, const KmsMode& b, double refresh_hz) {
  if (a.interlaced != b.interlaced) return b.interlaced;
  if (refresh_hz <= 0) return a.refresh_hz > b.refresh_hz;
  return std::abs(a.refresh_hz - refresh_hz) < std::abs(b.refresh_hz - refresh_hz);
}

const KmsMode& preferred_mode(const std::vector<KmsMode>& modes) {
  const auto preferred = std::ranges::find_if(modes, &KmsMode::preferred);
  return preferred == modes.end() ? modes.front() : *preferred;  // the kernel lists the best one first
}

std::optional<KmsMode> best_mode(const std::vector<KmsMode>& modes, int width, int height, double refresh_hz) {
  std::optional<KmsMode> best;
  for (const KmsMode& mode : modes) {
    if (mode.width != width || mode.height != height) continue;
    if (refresh_hz > 0 && std::abs(mode.refresh_hz - refresh_hz) > kRateTolerance_hz) continue;
    if (!best || better(mode, *best, refresh_hz)) best = mode;
  }
  return best;
}

}  // namespace

std::string in_words(const KmsConnector& connector) {
  if (connector.connection == KmsConnection::disconnected) return fmt::format("{}: disconnected", connector.name);
  std::string words = fmt::format("{}:", connector.name);
  if (!connector.display.empty()) words += fmt::format(" {},", connector.display);
  if (connector.connection == KmsConnection::unknown) words += " connection unknown,";
  if (connector.modes.empty()) return words + " lists no modes";
  for (std::size_t i = 0; i < std::min(connector.modes.size(), kModesInWords); ++i)
    words += fmt::format("{}{}{}", i == 0 ? " " : ", ", connector.modes[i].text(),
                         connector.modes[i].preferred ? " (preferred)" : "");
  if (connector.modes.size() > kModesInWords)
    words += fmt::format(" and {} more", connector.modes.size() - kModesInWords);
  return words;
}

Result<KmsConnector> choose_connector(const std::vector<KmsConnector>& connectors, const std::string& name) {
  if (!name.empty()) {
    const auto named = std::ranges::find(connectors, name, &KmsConnector::name);
    if (named == connectors.end())
      return fail(FaultKind::bad_input, "there is no connector \"{}\"; {}", name, all_in_words(connectors));
    if (!has_display(*named))
      return fail(FaultKind::disconnected, "no display is connected to {}; {}", name, all_in_words(connectors));
    if (named->modes.empty())
      return fail(FaultKind::disconnected, "the display at {} lists no modes (is it off?)", name);
    return *named;
  }
  for (const auto wanted : {KmsConnection::connected, KmsConnection::unknown})
    for (const KmsConnector& connector : connectors)
      if (connector.connection == wanted && !connector.modes.empty()) return connector;
  return fail(FaultKind::disconnected, "no display is connected; {}", all_in_words(connectors));
}

Result<KmsMode> choose_mode(const KmsConnector& connector, const KmsDisplayOptions& options) {
  if (connector.modes.empty())
    return fail(FaultKind::disconnected, "the display at {} lists no modes (is it off?)", connector.name);
  if ((options.width > 0) != (options.height > 0))
    return fail(FaultKind::bad_input, "a mode of {} x {} pixels: expected both or none", options.width, options.height);
  const KmsMode& preferred = preferred_mode(connector.modes);
  if (options.width <= 0 && options.refresh_hz <= 0) return preferred;
  const int width = options.width > 0 ? options.width : preferred.width;
  const int height = options.width > 0 ? options.height : preferred.height;
  if (const auto mode = best_mode(connector.modes, width, height, options.refresh_hz)) return *mode;
  if (options.preferred_instead) return preferred;
  return fail(FaultKind::bad_input, "the display does not offer {}; {}",
              asked_in_words(width, height, options.refresh_hz), in_words(connector));
}

}  // namespace kasumi

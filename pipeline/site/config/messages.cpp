#include "pipeline/site/config/messages.hpp"

#include "base/words/texts.hpp"

namespace kasumi {
namespace {

// In the order of kMessages.
constexpr std::string_view kMessageTexts[] = {
    "screen.starting",
    "screen.scene_camera_missing",
    "screen.scene_camera_frozen",
    "screen.scene_camera_covered",
    "screen.scene_camera_blinded",
    "screen.sky_camera_missing",
    "screen.no_clock",
    "screen.closed",
    "screen.recording",
    "screen.sharp_snapshot",
    "screen.page_picture",
    "screen.safe_mode",
    "screen.earlier_content",
};
static_assert(std::size(kMessageTexts) == std::size(kMessages));

}  // namespace

std::string_view message_text(Message message, Language language) {
  return text_of(kMessageTexts[static_cast<std::size_t>(message)], language);
}

}  // namespace kasumi

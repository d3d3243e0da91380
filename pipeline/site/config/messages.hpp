// Messages shown on the picture, in the visitors' language.
#pragma once

#include <string_view>

#include "base/words/language.hpp"

namespace kasumi {

enum class Message {
  starting,              // no picture has come yet since the start
  scene_camera_missing,  // unplugged, or it sends nothing
  scene_camera_frozen,   // always the same picture
  scene_camera_covered,  // something lies over the lens
  scene_camera_blinded,  // overexposed: all white
  sky_camera_missing,    // the last known air is used
  no_clock,              // the sun's position is unknown, so no building is drawn
  closed,                // outside opening hours
  recording,
  sharp_snapshot,   // a picture in which people may be recognised is about to leave the kiosk
  page_picture,     // a blurred one leaves it
  safe_mode,        // only the still picture is shown until somebody has looked after it
  earlier_content,  // for whoever has just changed it: the new content was refused
};
inline constexpr Message kMessages[] = {
    Message::starting,
    Message::scene_camera_missing,
    Message::scene_camera_frozen,
    Message::scene_camera_covered,
    Message::scene_camera_blinded,
    Message::sky_camera_missing,
    Message::no_clock,
    Message::closed,
    Message::recording,
    Message::sharp_snapshot,
    Message::page_picture,
    Message::safe_mode,
    Message::earlier_content,
};

// One or two sentences in UTF-8, each on its own line. Never empty.
std::string_view message_text(Message message, Language language);

}  // namespace kasumi

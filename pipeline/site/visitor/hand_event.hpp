// What a visitor does with buttons, knobs and touch screens, whatever the devices are.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace kasumi {

enum class HandKey {
  then_and_now,  // held: the camera's picture alone
  era,           // the next one
  language,      // the next one
  large_print,   // on, or off again
  story,         // the next one; after the last none
  view,          // the next one of BuildingView; after the last the live one
};
constexpr std::array<std::string_view, 6> kHandKeyNames{"then_and_now", "era",   "language",
                                                        "large_print",  "story", "view"};
constexpr std::size_t kHandKeys = kHandKeyNames.size();

struct HandEvent {
  enum class Kind {
    down,       // of `key`
    up,         // of `key`
    touch,      // a finger at `value`, 0..1 of the screen's width
    touch_end,  // no finger any more
    turn,       // a knob, by `value` notches
    all_up,     // the device is gone: nothing of it is held
  };
  Kind kind = Kind::all_up;
  HandKey key = HandKey::then_and_now;
  double value = 0.0;
  friend bool operator==(const HandEvent&, const HandEvent&) = default;
};

}  // namespace kasumi

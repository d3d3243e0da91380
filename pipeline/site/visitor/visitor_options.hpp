// [visitor] of kasumi.toml: what visitors may choose themselves, and by which devices.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "base/clock.hpp"
#include "base/table/config_table.hpp"
#include "base/words/language.hpp"
#include "pipeline/site/visitor/hand_event.hpp"

namespace kasumi {

struct VisitorOptions {
  std::vector<std::filesystem::path> devices;      // below /dev/input
  std::array<std::vector<int>, kHandKeys> keys{};  // of each HandKey: codes of the kernel's input events
  double notch = 0.05;                             // of the picture's width that a knob's notch wipes
  std::vector<Language> languages;                 // to choose from; empty: all
  std::vector<HandKey> hints;                      // written on the picture, in the buttons' order; empty: none
  Duration idle = std::chrono::seconds(45);        // without a visitor, until everything is as it was
  bool left_handed = false, seated = false;        // where stories are laid out, as PanelReader has it
  double pixels_per_degree = 24.0;                 // of the screen, from where it is read
  friend bool operator==(const VisitorOptions&, const VisitorOptions&) = default;
};

// The kernel's code of a key: "KEY_SPACE", "BTN_TRIGGER", or the number that evtest shows. Empty: none.
std::optional<int> input_key(std::string_view name);
std::string input_key_name(int code);  // the reverse

// Problems are collected in the root's file. Empty: there is no such table.
std::optional<VisitorOptions> read_visitor(const ConfigTable& root);

}  // namespace kasumi

// A history as a person asks for it: spells of one state, and minutes as a table.
#pragma once

#include <string>
#include <vector>

#include "history/history_line.hpp"

namespace kasumi {

using UtcMinute = std::chrono::sys_time<std::chrono::minutes>;

// Minutes in a row with the same rung and the same trouble.
struct Spell {
  UtcMinute from{}, to{};  // its first and its last minute
  bool told = false;       // false: nothing was written: off, or not running
  Shown shown = Shown::live;
  Trouble trouble = Trouble::none;
  std::optional<double> turbidity, aod_550;  // means
  std::optional<double> celsius;             // the highest
};

// Of lines in the order in which they were written. Two missing minutes in a row are a spell of their own.
std::vector<Spell> spells_of(const std::vector<HistoryLine>& lines);
// "still, scene-lost"
std::string spell_state(const Spell& spell);

// With a head; empty fields for what is not known.
std::string history_csv(const std::vector<HistoryLine>& lines);

}  // namespace kasumi

#include "history/history_spells.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/utc_text.hpp"

namespace kasumi {

namespace {

using std::chrono::minutes;

struct Mean {
  double sum = 0.0;
  int count = 0;
  void add(const std::optional<double>& value) {
    if (!value) return;
    sum += *value;
    ++count;
  }
  std::optional<double> value() const { return count > 0 ? std::optional(sum / count) : std::nullopt; }
};

}  // namespace

std::vector<Spell> spells_of(const std::vector<HistoryLine>& lines) {
  std::vector<Spell> spells;
  Mean turbidity, aod;
  for (const auto& line : lines) {
    const bool goes_on = !spells.empty() && spells.back().shown == line.shown && spells.back().trouble == line.trouble;
    const auto gap = spells.empty() ? minutes{1} : line.utc - spells.back().to;
    if (gap > minutes{2})
      spells.push_back({spells.back().to + minutes{1}, line.utc - minutes{1}, false, {}, {}, {}, {}, {}});
    // Where the clock was set back, what follows is another spell.
    if (!goes_on || gap > minutes{2} || gap <= minutes{0}) {
      spells.push_back({line.utc, line.utc, true, line.shown, line.trouble, {}, {}, {}});
      turbidity = aod = {};
    }
    auto& spell = spells.back();
    spell.to = line.utc;
    turbidity.add(line.turbidity);
    aod.add(line.aod_550);
    spell.turbidity = turbidity.value();
    spell.aod_550 = aod.value();
    if (line.celsius) spell.celsius = std::max(spell.celsius.value_or(*line.celsius), *line.celsius);
  }
  return spells;
}

std::string spell_state(const Spell& spell) {
  if (!spell.told) return "not running";
  const auto shown = name_of(spell.shown);
  return spell.trouble == Trouble::none ? std::string(shown) : fmt::format("{}, {}", shown, code_of(spell.trouble));
}

std::string history_csv(const std::vector<HistoryLine>& lines) {
  std::string text = "utc,shown,trouble,hidden_s";
  for (const auto& column : kHistoryColumns) text += fmt::format(",{}", column.name);
  for (const auto& flag : kHistoryFlags) text += fmt::format(",{}", flag.name);
  for (const auto& line : lines) {
    text += fmt::format("\n{},{},{},{}", utc_text(line.utc), name_of(line.shown), code_of(line.trouble), line.hidden_s);
    for (const auto& column : kHistoryColumns) {
      const auto& value = line.*column.value;
      text += value ? fmt::format(",{}", *value) : ",";
    }
    for (const auto& flag : kHistoryFlags) text += fmt::format(",{:d}", line.*flag.value);
  }
  return text + "\n";
}

}  // namespace kasumi

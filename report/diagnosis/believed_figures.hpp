// What was believed of a table of base/status/status_figures.hpp, by its keys: values["heat.celsius"].
#pragma once

#include <array>
#include <iterator>
#include <optional>

#include "base/status/status_figures.hpp"

namespace kasumi::report {

template <const auto& kFigures>
class BelievedFigures {
 public:
  using Key = FigureKey<kFigures>;
  // Flags are 0 or 1. Empty: missing, of another type or impossible.
  std::optional<double> operator[](Key key) const { return values_[key.index]; }
  bool is(Key key) const { return values_[key.index] == 1.0; }
  bool is_not(Key key) const { return values_[key.index] == 0.0; }

  // By place in the table.
  std::optional<double>& at(std::size_t index) { return values_.at(index); }
  std::optional<double> at(std::size_t index) const { return values_.at(index); }
  // By a key that the table itself names; empty: none.
  std::optional<double> of(std::string_view key) const {
    for (std::size_t i = 0; i < values_.size(); ++i)
      if (kFigures[i].key == key) return values_[i];
    return std::nullopt;
  }

 private:
  std::array<std::optional<double>, std::size(kFigures)> values_{};
};

}  // namespace kasumi::report

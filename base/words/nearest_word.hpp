// "Did you mean": what a mistyped word may have been meant for.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kasumi {

// Letters added, left out, replaced, or swapped with a neighbour.
int edit_distance(std::string_view a, std::string_view b);

// The nearest of `words`, if no more than a third of the typed word's letters are wrong, or it is the beginning of one
// word only; empty: none. Capitals do not count.
std::string nearest_word(std::string_view typed, const std::vector<std::string>& words);

// "; did you mean scene.width?", or nothing.
std::string did_you_mean(std::string_view typed, const std::vector<std::string>& words);

}  // namespace kasumi

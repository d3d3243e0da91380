#include "base/words/nearest_word.hpp"

#include <algorithm>
#include <cctype>

namespace kasumi {

namespace {

constexpr std::size_t kLongestWord = 64;

std::string small_letters(std::string_view text) {
  std::string small(text);
  std::ranges::transform(small, small.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return small;
}

}  // namespace

int edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<int>> cost(a.size() + 1, std::vector<int>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j) {
      int& here = cost[i][j];
      if (i == 0 || j == 0) {
        here = static_cast<int>(std::max(i, j));
        continue;
      }
      here = std::min({cost[i - 1][j] + 1, cost[i][j - 1] + 1, cost[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) here = std::min(here, cost[i - 2][j - 2] + 1);
    }
  return cost[a.size()][b.size()];
}

std::string nearest_word(std::string_view typed, const std::vector<std::string>& words) {
  if (typed.size() < 3 || typed.size() > kLongestWord) return {};
  const auto small = small_letters(typed);
  const int most = std::max(1, static_cast<int>(typed.size()) / 3);
  std::string best;
  int least = most + 1, begun = 0;
  std::string beginning;
  for (const auto& word : words) {
    if (word.size() > kLongestWord) continue;
    const auto other = small_letters(word);
    if (const int distance = edit_distance(small, other); distance < least) {
      least = distance;
      best = word;
    }
    if (other.starts_with(small)) {
      ++begun;
      beginning = word;
    }
  }
  return best.empty() && begun == 1 ? beginning : best;
}

std::string did_you_mean(std::string_view typed, const std::vector<std::string>& words) {
  const auto nearest = nearest_word(typed, words);
  return nearest.empty() ? std::string() : "; did you mean " + nearest + "?";
}

}  // namespace kasumi

#include "tests/fuzz/changed_input.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>

namespace kasumi {
namespace {

constexpr std::size_t kLongest = 16384;
// What readers of numbers, texts and sizes stumble over.
constexpr std::string_view kWords[] = {"nan",
                                       "-inf",
                                       "1e999",
                                       "-1",
                                       "0",
                                       "4294967296",
                                       "9223372036854775808",
                                       "0.1e-320",
                                       "\"",
                                       "\\u0000",
                                       "[",
                                       "{",
                                       "\n",
                                       "=",
                                       "../",
                                       "\xff\xff\xff\xff",
                                       {"\0\0\0\0", 4},
                                       "\x7f\xff\xff\xff",
                                       "\x80",
                                       "\xf4\x90\x80\x80"};

std::size_t up_to(std::size_t most, std::mt19937_64& random) {
  return std::uniform_int_distribution<std::size_t>(0, most)(random);
}

struct Range {
  std::ptrdiff_t first, last;
};

// Mostly short; anywhere.
Range range_in(const FuzzInput& input, std::mt19937_64& random) {
  const auto first = up_to(input.size(), random);
  const auto longest = input.size() - first;
  const auto length = up_to(up_to(2, random) == 0 ? longest : std::min<std::size_t>(longest, 16), random);
  return {static_cast<std::ptrdiff_t>(first), static_cast<std::ptrdiff_t>(first + length)};
}

void insert(FuzzInput& input, std::size_t at, const auto& bytes) {
  input.insert(input.begin() + static_cast<std::ptrdiff_t>(at), bytes.begin(), bytes.end());
}

void change(FuzzInput& input, const std::vector<FuzzInput>& known, std::mt19937_64& random) {
  const auto range = range_in(input, random);
  const auto from = input.begin() + range.first, to = input.begin() + range.last;
  switch (up_to(6, random)) {
    case 0:  // a bit
      if (from != input.end()) *from ^= static_cast<std::uint8_t>(1u << up_to(7, random));
      break;
    case 1:  // noise
      std::generate(from, to, [&] { return static_cast<std::uint8_t>(up_to(255, random)); });
      break;
    case 2: input.erase(from, to); break;
    case 3: {  // what stands there, elsewhere once more
      const FuzzInput copied(from, to);
      insert(input, up_to(input.size(), random), copied);
      break;
    }
    case 4: {  // a word instead
      const auto word = kWords[up_to(std::size(kWords) - 1, random)];
      const auto at = static_cast<std::size_t>(range.first);
      input.erase(from, to);
      insert(input, at, word);
      break;
    }
    case 5: input.resize(static_cast<std::size_t>(range.last)); break;  // cut off
    case 6: {                                                           // goes on as another
      const auto& other = known[up_to(known.size() - 1, random)];
      const auto part = range_in(other, random);
      input.resize(static_cast<std::size_t>(range.first));
      input.insert(input.end(), other.begin() + part.first, other.end());
      break;
    }
  }
}

}  // namespace

FuzzInput changed_input(const std::vector<FuzzInput>& known, std::mt19937_64& random) {
  auto input = known[up_to(known.size() - 1, random)];
  for (auto changes = 1 + up_to(3, random); changes > 0; --changes) change(input, known, random);
  if (input.size() > kLongest) input.resize(kLongest);
  return input;
}

}  // namespace kasumi

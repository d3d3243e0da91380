// A fault's problems: its message has a line for each, and of one that another file explains a second.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kasumi {

// A file may have tens of thousands of problems, and a status that lists them all would be refused by its readers.
constexpr std::size_t kMostProblems = 50, kMostProblemBytes = 400;

// What a line announces (it ends in a colon) stays with it: it is one problem. Of more than kMostProblems the last line
// says how many; longer ones are cut; control characters are spaces.
std::vector<std::string> lines_of(std::string_view text);

}  // namespace kasumi

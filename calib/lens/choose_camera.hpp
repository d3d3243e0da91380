// Which of the cameras in another program's file is meant.
#pragma once

#include <string>
#include <vector>

#include "base/result.hpp"

namespace kasumi {

struct ListedLens {
  std::vector<std::string> names;  // any of them will do; the first is the one to list
  std::string words;               // "pinhole, 1600 x 1500"
};

// Its index: the one of that name, or the only one where none is named. Errors (bad_input): several and none is named, or
// none of that name; both list the cameras.
Result<std::size_t> choose_camera(const std::vector<ListedLens>& cameras, const std::string& wanted);

}  // namespace kasumi

// kasumi calibrate as called by a user.
#pragma once

#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {

inline Outcome run(const std::string& arguments) {
  return run_kasumi("calibrate " + arguments);
}

inline std::filesystem::path fresh_folder(const std::string& name) {
  const auto folder = test_folder(name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

}  // namespace kasumi

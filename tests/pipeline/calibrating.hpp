// kasumi calibrate as a person calls it.
#pragma once

#include <array>
#include <cstdio>

#include <sys/wait.h>

#include "base/files.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {

struct Outcome {
  int code = -1;
  std::string out, err;
};

inline Outcome run(const std::string& arguments) {
  const auto errors = test_folder("calibrate-stderr.txt");
  Outcome outcome;
  FILE* pipe = ::popen(fmt::format("{} calibrate {} 2>{}", KASUMI_BINARY, arguments, errors.string()).c_str(), "r");
  if (!pipe) return outcome;
  std::array<char, 4096> buffer;
  for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    outcome.out.append(buffer.data(), n);
  outcome.code = WEXITSTATUS(::pclose(pipe));
  outcome.err = read_text_file(errors).value_or("");
  return outcome;
}

inline std::filesystem::path fresh_folder(const std::string& name) {
  const auto folder = test_folder(name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

}  // namespace kasumi

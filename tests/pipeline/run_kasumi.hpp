// Runs the program as a user or a script does.
#pragma once

#include <array>
#include <cstdio>
#include <string>

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/files.hpp"
#include "tests/pipeline/recorded.hpp"
#include "tests/places.hpp"

namespace kasumi {

struct Outcome {
  int code = -1;
  std::string out, err;
};

// Runs `ENVIRONMENT kasumi ARGUMENTS` through a shell.
inline Outcome run_kasumi(const std::string& arguments, const std::string& environment = "") {
  const auto errors = test_folder(fmt::format("stderr-{}.txt", ::getpid()));  // test programs run side by side
  Outcome outcome;
  const auto command = fmt::format("{} {} {} 2>{}", environment, kasumi_program().string(), arguments, errors.string());
  FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) return outcome;
  std::array<char, 4096> buffer;
  for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    outcome.out.append(buffer.data(), n);
  outcome.code = WEXITSTATUS(::pclose(pipe));
  outcome.err = read_text_file(errors).value_or("");
  std::filesystem::remove(errors);
  return outcome;
}

}  // namespace kasumi

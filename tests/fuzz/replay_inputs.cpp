// Replaces libFuzzer's main: runs the given inputs (files or folders) once, so that seeds and past findings are tested
// in every build.
#include <cstdio>

#include "base/files.hpp"
#include "tests/fuzz/scratch.hpp"

namespace {

void run(const std::filesystem::path& path) {
  const auto input = kasumi::read_file(path).value();
  LLVMFuzzerTestOneInput(input.data(), input.size());
}

}  // namespace

int main(int count, char** names) {
  int inputs = 0;
  for (int i = 1; i < count; ++i) {
    const std::filesystem::path path = names[i];
    if (!std::filesystem::exists(path)) continue;
    if (!std::filesystem::is_directory(path)) {
      run(path);
      ++inputs;
      continue;
    }
    for (const auto& entry : std::filesystem::directory_iterator(path)) {
      run(entry.path());
      ++inputs;
    }
  }
  std::printf("%d inputs, each a value or a message\n", inputs);
  return inputs > 0 ? 0 : 1;
}

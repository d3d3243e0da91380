// Replaces libFuzzer's main: runs the given inputs (files or folders) once, so that seeds and past findings are tested in
// every build. KASUMI_FUZZ_CHANGED_S=SECONDS: then, for so long, the same inputs changed at random. Where that finds
// something, KASUMI_FUZZ_SEED=SEED, with the seed it prints first, finds it again.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "base/files.hpp"
#include "tests/fuzz/changed_input.hpp"
#include "tests/fuzz/scratch.hpp"

namespace {

namespace fs = std::filesystem;

std::vector<kasumi::FuzzInput> read_inputs(int count, char** names) {
  std::vector<fs::path> files;
  for (int i = 1; i < count; ++i) {
    const fs::path path = names[i];
    if (fs::is_regular_file(path)) files.push_back(path);
    if (!fs::is_directory(path)) continue;
    for (const auto& entry : fs::directory_iterator(path)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());  // a seed means the same everywhere
  std::vector<kasumi::FuzzInput> inputs;
  for (const auto& file : files) inputs.push_back(kasumi::read_file(file).value());
  return inputs;
}

int run_changed(const std::vector<kasumi::FuzzInput>& known, double seconds) {
  const char* given = std::getenv("KASUMI_FUZZ_SEED");
  const std::uint64_t seed = given ? std::stoull(given) : std::random_device()();
  std::printf("changed at random, KASUMI_FUZZ_SEED=%llu\n", static_cast<unsigned long long>(seed));
  std::fflush(stdout);
  std::mt19937_64 random(seed);
  int changed = 0;
  const auto began = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - began < std::chrono::duration<double>(seconds)) {
    const auto input = kasumi::changed_input(known, random);
    LLVMFuzzerTestOneInput(input.data(), input.size());
    ++changed;
  }
  return changed;
}

}  // namespace

int main(int count, char** names) {
  const auto inputs = read_inputs(count, names);
  for (const auto& input : inputs) LLVMFuzzerTestOneInput(input.data(), input.size());
  std::printf("%zu inputs, each a value or a message\n", inputs.size());
  if (inputs.empty()) return 1;
  if (const char* seconds = std::getenv("KASUMI_FUZZ_CHANGED_S"))
    std::printf("%d changed inputs, each a value or a message\n", run_changed(inputs, std::stod(seconds)));
}

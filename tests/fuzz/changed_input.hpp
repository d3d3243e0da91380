// Inputs that nobody has written yet: known ones, changed at random. Where libFuzzer follows what an input reaches, this
// knows nothing of the reader; it needs no compiler of its own.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace kasumi {

using FuzzInput = std::vector<std::uint8_t>;

// One of `known`, which must not be empty, with one to four changes; 16 KiB at most.
FuzzInput changed_input(const std::vector<FuzzInput>& known, std::mt19937_64& random);

}  // namespace kasumi

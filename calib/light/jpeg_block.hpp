// A block of 8 x 8 samples and its coefficients (ITU-T T.81 A.3.3), levels of 255, row by row.
#pragma once

#include <array>
#include <cstdint>

namespace kasumi {

constexpr int kBlockSide = 8;
using JpegBlock = std::array<double, kBlockSide * kBlockSide>;
using BlockSteps = std::array<std::uint16_t, kBlockSide * kBlockSide>;

// Of samples less 128.
JpegBlock coefficients_of(const JpegBlock& samples);
JpegBlock samples_of(const JpegBlock& coefficients);
// The step to which coefficient `i` is rounded; never 0.
double step_of(const BlockSteps& steps, std::size_t i);

}  // namespace kasumi

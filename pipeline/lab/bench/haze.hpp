// What haze that blurs costs, side by side (docs/performance.md).
#pragma once

#include <vector>

#include "base/result.hpp"
#include "pipeline/lab/bench/bench.hpp"

namespace kasumi {

// The scheme of matched steps against the explicit one (H Fig 7) and against a Gaussian of one width, on the CPU and on
// the GPU. Takes half a minute. Errors: unsupported (no GL here), device.
Result<std::vector<BenchRow>> bench_haze();

}  // namespace kasumi

// What drawing costs, side by side (docs/performance.md).
#pragma once

#include <vector>

#include "base/result.hpp"
#include "pipeline/lab/bench/bench.hpp"

namespace kasumi {

// Opens a headless context of its own; full HD. Errors: unsupported (no GL here), device.
Result<std::vector<BenchRow>> bench_gles();
// The same of the layer: light, shadow, reflection, the camera's quality, a model of a million triangles.
Result<std::vector<BenchRow>> bench_layer();
// Of the surroundings: leaves that sway before the building, and the ground that is looked at.
Result<std::vector<BenchRow>> bench_surroundings();
// A picture in which people stay in front of the building. Errors as well: unsupported (they are not found).
Result<std::vector<BenchRow>> bench_people();
// The wipe and the views that visitors may choose.
Result<std::vector<BenchRow>> bench_visitor();
// The sky dome next to earlier sky models.
struct DomeBenchSize {
  int width = 1920, height = 1080;
  int pairs = 31;
};
Result<std::vector<BenchRow>> bench_dome(const DomeBenchSize& size = {});

}  // namespace kasumi

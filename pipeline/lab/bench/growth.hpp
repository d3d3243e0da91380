// How the cost of a picture grows with what is drawn (`kasumi bench --growth`).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "pipeline/lab/bench/gles_scene.hpp"

namespace kasumi {

// With software GL times are the processor's, of all threads; with a GPU the clock's.
struct GrowthCost {
  double picture_ms = 0.0;  // NV12 upload and cached composite, the quickest of several
  double over_blit = 0.0;   // cached composite of an RGBA picture / plain blit of it, in turn
  double redraw_ms = 0.0;   // the layer, shadows included
  double model_mib = 0.0;   // on the GPU
  double peak_mib = 0.0;    // of the process: with software GL the GPU's memory is in it
};

struct GrowthPoint {
  double at = 0.0;
  BenchSize size;
  GrowthCost cost;
};

struct GrowthCurve {
  std::string over;  // "triangles"
  std::vector<GrowthPoint> points;
};

// What is varied: triangles 10 k .. 10 M, a texture's side, megapixels 720p .. 4k, 1 .. 8 buildings; the rest stays as
// BenchSize has it. Nothing measured yet.
std::vector<GrowthCurve> growth_curves();

// Draws in a process of its own, so that memory is this size's alone: call it before this process has threads or GL.
// Errors: unsupported, device; io (no process).
Result<GrowthCost> growth_cost(const BenchSize& size);

// growth.csv and growth.svg in the folder. Errors: io.
Result<> write_growth(const std::filesystem::path& folder, const std::vector<GrowthCurve>& curves);
std::string growth_markdown(const std::vector<GrowthCurve>& curves);

}  // namespace kasumi

// What a visitor's wipe and views cost beside the plain picture.
#include "capture/codec/dimmed_picture.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/lab/bench/gles.hpp"
#include "pipeline/lab/bench/gles_scene.hpp"
#include "pipeline/lab/bench/gles_stopwatch.hpp"

namespace kasumi {
namespace {

constexpr int kViewPairs = 31;
constexpr double kViewGoal = 1.15;  // of the plain picture

}  // namespace

Result<std::vector<BenchRow>> bench_visitor() {
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  const BenchScene scene = make_bench_scene();
  auto offscreen = Offscreen::create((*context)->info(), scene.view.width, scene.view.height);
  if (!offscreen) return fail(offscreen.error());
  auto renderer = drawn_by_renderer(**context, scene);
  if (!renderer) return fail(renderer.error());
  DimmedPicture dimmed;
  const auto draw = [&](bool dims, double bare) {
    return [&, dims, bare]() -> Result<> {
      const PictureView plain = scene.frame.nv12();
      if (auto loaded = renderer->upload(dims ? dimmed.dim(plain) : plain); !loaded) return loaded;
      renderer->set_bare(bare);
      return renderer->draw(scene.measured, offscreen->target());
    };
  };
  Stopwatch watch;
  const double wipe = watch.ratio(draw(false, 0.5), draw(false, 0.0), kViewPairs);
  const double alone = watch.ratio(draw(true, 0.0), draw(false, 0.0), kViewPairs);
  if (!watch.result()) return fail(watch.result().error());
  // In clear air another layer is drawn in the same way: it costs what the plain picture costs.
  return std::vector<BenchRow>{
      {.name = "picture (NV12) that a visitor wipes by half / plain", .value = wipe, .goal = kViewGoal},
      {.name = "  the building alone, or this evening / plain", .value = alone, .goal = kViewGoal}};
}

}  // namespace kasumi

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
  BenchScene clear = scene;
  clear.appearance.haze = bench_haze(Turbidity{2.0});
  auto in_clear_air = drawn_by_renderer(**context, clear);
  if (!in_clear_air) return fail(in_clear_air.error());
  const auto draw = [&](Renderer& by, bool dims, double bare) {
    return [&, dims, bare]() -> Result<> {
      const PictureView plain = scene.frame.nv12();
      if (auto loaded = by.upload(dims ? dimmed.dim(plain) : plain); !loaded) return loaded;
      by.set_bare(bare);
      return by.draw(scene.measured, offscreen->target());
    };
  };
  Stopwatch watch;
  const auto plain = draw(*renderer, false, 0.0);
  const double wipe = watch.ratio(draw(*renderer, false, 0.5), plain, kViewPairs);
  const double alone = watch.ratio(draw(*renderer, true, 0.0), plain, kViewPairs);
  const double clear_air = watch.ratio(draw(*in_clear_air, false, 0.0), plain, kViewPairs);
  if (!watch.result()) return fail(watch.result().error());
  return std::vector<BenchRow>{
      {.name = "picture (NV12) that a visitor wipes by half / plain", .value = wipe, .goal = kViewGoal},
      {.name = "  the building alone, or at another hour / plain", .value = alone, .goal = kViewGoal},
      {.name = "  the building in clear air / plain", .value = clear_air, .goal = kViewGoal}};
}

}  // namespace kasumi

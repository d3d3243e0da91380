#include "pipeline/lab/bench/growth.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>

#include "gles/gl/context.hpp"
#include "gles/gl/offscreen.hpp"
#include "gles/object/renderer.hpp"
#include "pipeline/lab/bench/gles_papers.hpp"
#include "pipeline/lab/bench/gles_stopwatch.hpp"

namespace kasumi {
namespace {

constexpr int kPairs = 15;

Result<GrowthCost> measured_here(const BenchSize& size) {
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  const BenchScene scene = make_bench_scene(size);
  auto offscreen = Offscreen::create((*context)->info(), size.width, size.height);
  if (!offscreen) return fail(offscreen.error());
  auto renderer = Renderer::create(**context);
  if (!renderer) return fail(renderer.error());
  if (auto set = renderer->set_model(scene.facade); !set) return fail(set.error());
  if (auto set = renderer->set_view(scene.view, scene.model_to_world); !set) return fail(set.error());
  const GlTexture picture = make_picture_texture(size.width, size.height, scene.frame.pixels.elements().data());
  const auto blit = ScreenPass::blit(picture.name());
  if (!blit) return fail(blit.error());

  const DrawTarget target = offscreen->target();
  Stopwatch watch;
  const auto redraw = [&] { return renderer->redraw_layer(scene.appearance); };
  const auto composite = [&] { return renderer->draw(scene.measured, target); };
  const auto whole_picture = [&]() -> Result<> {
    if (auto loaded = renderer->upload(scene.frame.nv12()); !loaded) return loaded;
    return composite();
  };
  const bool software = (*context)->info().software;
  GrowthCost cost;
  cost.redraw_ms = 1e3 * watch.least_seconds(redraw, 2, software);
  if (auto loaded = renderer->upload(scene.frame.rgba()); !loaded) return fail(loaded.error());
  cost.over_blit = watch.ratio(
      composite, [&] { return blit->draw(target); }, kPairs);
  cost.picture_ms = 1e3 * watch.least_seconds(whole_picture, kPairs, software);
  cost.model_mib = static_cast<double>(renderer->model_bytes()) / (1 << 20);
  if (!watch.result()) return fail(watch.result().error());
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  cost.peak_mib = static_cast<double>(used.ru_maxrss) / 1024.0;
  return cost;
}

// What the child tells: its cost, or a fault's kind and words.
struct Told {
  bool well = false;
  GrowthCost cost;
  FaultKind kind = FaultKind::device;
  std::array<char, 400> words{};
};

}  // namespace

std::vector<GrowthCurve> growth_curves() {
  std::vector<GrowthCurve> curves(4);
  curves[0].over = "triangles";
  for (const int n : {10'000, 100'000, 1'000'000, 10'000'000})
    curves[0].points.push_back({static_cast<double>(n), {.triangles = n}, {}});
  curves[1].over = "pixels along a texture";
  for (const int side : {256, 512, 1024, 2048, 4096})
    curves[1].points.push_back({static_cast<double>(side), {.texture_side = side}, {}});
  curves[2].over = "megapixels of the picture";
  for (const auto& [width, height] : {std::pair{1280, 720}, {1920, 1080}, {2560, 1440}, {3840, 2160}})
    curves[2].points.push_back({1e-6 * width * height, {.width = width, .height = height}, {}});
  curves[3].over = "buildings";
  for (const int n : {1, 2, 4, 8}) curves[3].points.push_back({static_cast<double>(n), {.buildings = n}, {}});
  return curves;
}

Result<GrowthCost> growth_cost(const BenchSize& size) {
  int ends[2];
  if (::pipe(ends) != 0) return fail(FaultKind::io, "no pipe to a process that measures");
  const pid_t child = ::fork();
  if (child < 0) {
    ::close(ends[0]);
    ::close(ends[1]);
    return fail(FaultKind::io, "no process that measures");
  }
  Told told;
  if (child == 0) {
    ::close(ends[0]);
    const auto cost = measured_here(size);
    told.well = cost.has_value();
    if (cost)
      told.cost = *cost;
    else {
      told.kind = cost.error().kind;
      cost.error().message.copy(told.words.data(), told.words.size() - 1);
    }
    const auto written = ::write(ends[1], &told, sizeof told);  // smaller than a pipe holds: whole or not at all
    ::_exit(written == sizeof told ? 0 : 1);
  }
  ::close(ends[1]);
  const auto got = ::read(ends[0], &told, sizeof told);
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  if (got != sizeof told)
    return fail(FaultKind::device, "the process that drew {} triangles at {} x {} ended without a result",
                size.triangles, size.width, size.height);
  if (!told.well) return fail(Fault{told.kind, told.words.data()});
  return told.cost;
}

}  // namespace kasumi

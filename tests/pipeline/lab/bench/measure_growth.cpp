// build/measure_growth: what a picture of a given size costs, as JSON. docs/measure runs it once for each size, so that
// peak_mib is that size's alone. With software GL times are the processor's, of all threads; with a GPU the clock's.
#include <sys/resource.h>

#include <cstdio>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "gles/composite/renderer.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/lab/bench/gles_papers.hpp"
#include "pipeline/lab/bench/gles_scene.hpp"
#include "pipeline/lab/bench/gles_stopwatch.hpp"

namespace {

using namespace kasumi;

constexpr int kPairs = 15;

Result<nlohmann::json> cost_of(const BenchSize& size) {
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
  nlohmann::json cost;
  cost["redraw_ms"] = 1e3 * watch.least_seconds(redraw, 2, software);  // shadows included
  if (auto loaded = renderer->upload(scene.frame.rgba()); !loaded) return fail(loaded.error());
  cost["over_blit"] = watch.ratio(
      composite, [&] { return blit->draw(target); }, kPairs);
  cost["picture_ms"] = 1e3 * watch.least_seconds(whole_picture, kPairs, software);  // NV12 upload, cached composite
  cost["model_mib"] = static_cast<double>(renderer->model_bytes()) / (1 << 20);     // on the GPU
  if (!watch.result()) return fail(watch.result().error());
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  cost["peak_mib"] = static_cast<double>(used.ru_maxrss) / 1024.0;  // with software GL the GPU's memory is in it
  return cost;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Cost of a picture of this size"};
  BenchSize size;
  app.add_option("--width", size.width, "Of the picture")->check(CLI::Range(16, 8192));
  app.add_option("--height", size.height, "Of the picture")->check(CLI::Range(16, 8192));
  app.add_option("--triangles", size.triangles, "Of all buildings")->check(CLI::PositiveNumber);
  app.add_option("--buildings", size.buildings, "Side by side")->check(CLI::PositiveNumber);
  app.add_option("--texture-side", size.texture_side, "Pixels")->check(CLI::Range(1, 8192));
  CLI11_PARSE(app, argc, argv);
  const auto cost = cost_of(size);
  if (!cost) {
    std::fprintf(stderr, "measure_growth: %s\n", cost.error().message.c_str());
    return 1;
  }
  std::printf("%s\n", cost->dump().c_str());
  return 0;
}

// The cost of the sky: Kasumi's next to a plain blit and to earlier sky models.
#include <algorithm>
#include <array>

#include "gles/air/dome_renderer.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/lab/bench/gles.hpp"
#include "pipeline/lab/bench/gles_papers.hpp"
#include "pipeline/lab/bench/gles_passes.hpp"
#include "pipeline/lab/bench/gles_scene.hpp"
#include "pipeline/lab/bench/gles_stopwatch.hpp"
#include "pipeline/lab/sky/dome_drawing.hpp"

namespace kasumi {
namespace {

constexpr std::array kKinds{SkyKind::dome, SkyKind::preetham1999, SkyKind::hoffman_preetham2002, SkyKind::nielsen2003};

Viewpoint bench_camera(const DomeBenchSize& size) {
  Viewpoint camera;
  camera.width = size.width;
  camera.height = size.height;
  camera.pitch_deg = 20.0;
  return camera;
}

DomeScene bench_sky(SkyKind kind) {
  DomeRequest request;
  request.kind = kind;
  request.sun = direction_from(from_degrees(55.0), from_degrees(10.0));
  return sky_scene(request);
}

// As the bench's other full-screen passes: a picture of its size on the screen.
Result<ScreenPass> make_blit(GlTexture& picture, const DomeBenchSize& size) {
  const Image<glm::u8vec4> pixels(size.width, size.height, glm::u8vec4(120, 150, 200, 255));
  picture = make_picture_texture(size.width, size.height, pixels.elements().data());
  return ScreenPass::blit(picture.name());
}

}  // namespace

Result<std::vector<BenchRow>> bench_dome(const DomeBenchSize& size) {
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  auto offscreen = Offscreen::create((*context)->info(), size.width, size.height);
  if (!offscreen) return fail(offscreen.error());
  GlTexture picture;
  const auto blit_pass = make_blit(picture, size);
  if (!blit_pass) return fail(blit_pass.error());
  const DrawTarget target = offscreen->target();
  const PanoramaView view = view_of(bench_camera(size));

  std::vector<DomeRenderer> skies;
  for (const SkyKind kind : kKinds) {
    auto sky = DomeRenderer::create(**context);
    if (!sky) return fail(sky.error());
    if (auto set = sky->set(view, bench_sky(kind)); !set) return fail(set.error());
    skies.push_back(std::move(*sky));
  }
  const auto draw = [&](std::size_t kind, DomeDetail detail) {
    return [&skies, &target, kind, detail] { return skies[kind].draw(target, detail); };
  };
  const auto blit = [&] { return blit_pass->draw(target); };
  const DomeScene scene = bench_sky(SkyKind::dome);
  const auto rebuilt = [&]() -> Result<> {
    if (auto set = skies[0].set(view, scene); !set) return set;
    return skies[0].draw(target);
  };
  const auto ours = draw(0, DomeDetail::per_vertex);

  Stopwatch watch;
  std::vector<BenchRow> rows;
  const auto add = [&](std::string name, double value, std::optional<double> goal = {}, bool less_is_better = true) {
    rows.push_back({.name = std::move(name), .value = value, .goal = goal, .less_is_better = less_is_better});
  };
  const auto mesh = skies[0].mesh_size();
  add(fmt::format("the sky's dome, full HD, {} x {} places / plain blit", mesh.columns, mesh.rows),
      watch.ratio(ours, blit, size.pairs), 1.5);
  add("  the same while the sun moves: mesh rebuilt each time / plain blit", watch.ratio(rebuilt, blit, size.pairs));
  const int few_pairs = std::min(size.pairs, 7);
  for (std::size_t i = 1; i < kKinds.size(); ++i) {
    add(fmt::format("{} in each pixel, as published / our dome", name_of(kKinds[i])),
        watch.ratio(draw(i, DomeDetail::per_fragment), ours, few_pairs), 1.0, false);
    add(fmt::format("  {} on a mesh as ours is drawn / our dome", name_of(kKinds[i])),
        watch.ratio(draw(i, DomeDetail::per_vertex), ours, few_pairs), {}, false);
    add(fmt::format("  {} in each pixel / our dome in each pixel", name_of(kKinds[i])),
        watch.ratio(draw(i, DomeDetail::per_fragment), draw(0, DomeDetail::per_fragment), few_pairs), {}, false);
  }
  if (!watch.result()) return fail(watch.result().error());
  return rows;
}

}  // namespace kasumi

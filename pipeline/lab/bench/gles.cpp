#include "pipeline/lab/bench/gles.hpp"

#include <algorithm>

#include "gles/composite/renderer.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/lab/bench/gles_papers.hpp"
#include "pipeline/lab/bench/gles_scene.hpp"
#include "pipeline/lab/bench/gles_stopwatch.hpp"

namespace kasumi {
namespace {

constexpr int kSpectralPairs = 5;  // with sums over wavelengths

// Shares of the picture in percent: the object's box, and what the object covers in it.
struct Shares {
  double box = 0.0;
  double covered = 0.0;
};

Result<Shares> shares_of(Renderer& renderer, const SceneView& view) {
  const auto layer = renderer.read_layer();
  if (!layer) return fail(layer.error());
  const double pixels = static_cast<double>(view.width) * view.height;
  const auto covered = std::ranges::count_if(layer->elements(), [](const glm::vec4& texel) { return texel.a > 0.0f; });
  return Shares{100.0 * static_cast<double>(layer->elements().size()) / pixels,
                100.0 * static_cast<double>(covered) / pixels};
}

Result<Renderer> make_renderer(GlContext& context, const BenchScene& scene) {
  auto renderer = drawn_by_renderer(context, scene);
  if (!renderer) return renderer;
  if (auto loaded = renderer->upload(scene.frame.rgba()); !loaded) return fail(loaded.error());
  return renderer;
}

}  // namespace

Result<std::vector<BenchRow>> bench_gles() {
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  const GlInfo& info = (*context)->info();
  const BenchScene scene = make_bench_scene();
  auto offscreen = Offscreen::create(info, scene.view.width, scene.view.height, Offscreen::Depth::buffer);
  if (!offscreen) return fail(offscreen.error());
  auto renderer = make_renderer(**context, scene);
  if (!renderer) return fail(renderer.error());
  const auto shares = shares_of(*renderer, scene.view);
  if (!shares) return fail(shares.error());

  const DrawTarget target = offscreen->target();
  const GlTexture picture =
      make_picture_texture(scene.view.width, scene.view.height, scene.frame.pixels.elements().data());
  const auto blit_pass = ScreenPass::blit(picture.name());
  const auto two_nodes = ScreenPass::under_air(picture.name(), scene, GammaBy::two_nodes);
  const auto sum_of_41 = ScreenPass::under_air(picture.name(), scene, GammaBy::wavelengths_41);
  const auto sum_of_81 = ScreenPass::under_air(picture.name(), scene, GammaBy::wavelengths_81);
  for (const auto* pass : {&blit_pass, &two_nodes, &sum_of_41, &sum_of_81})
    if (!*pass) return fail(pass->error());
  auto papers = TwoBufferLayout::create(info, picture.name(), scene, GammaBy::two_nodes);
  auto papers_81 = TwoBufferLayout::create(info, picture.name(), scene, GammaBy::wavelengths_81);
  for (const auto* layout : {&papers, &papers_81})
    if (!*layout) return fail(layout->error());

  const PixelBox box = renderer->object_box();
  auto plane = Offscreen::create(info, box.right - box.left, box.bottom - box.top);
  if (!plane) return fail(plane.error());

  ObjectAppearance airless = scene.appearance;
  airless.aerial_perspective = false;
  const auto pass = [&](const Result<ScreenPass>& which) { return [&] { return which->draw(target); }; };
  const auto moving = [&](const ObjectAppearance& appearance, HazeDetail detail) {
    return [&, detail] { return renderer->draw_moving(appearance, scene.measured, target, detail); };
  };
  const auto uploaded = [&](const PictureView& frame) {
    return [&, frame]() -> Result<> {
      if (auto loaded = renderer->upload(frame); !loaded) return loaded;
      return renderer->draw_background(target);
    };
  };
  const auto blit = pass(blit_pass);
  const auto cached = [&] { return renderer->draw(scene.measured, target); };
  const auto background = [&] { return renderer->draw_background(target); };
  const auto for_plane = [&] { return renderer->draw_for_plane(scene.measured, plane->target()); };
  const auto by_vertex = moving(scene.appearance, HazeDetail::per_vertex);
  const auto by_fragment = moving(scene.appearance, HazeDetail::per_fragment);
  const auto without_air = moving(airless, HazeDetail::per_vertex);
  const auto layout = [&] { return papers->draw(target); };
  const auto layout_81 = [&] { return papers_81->draw(target); };

  Stopwatch watch;
  std::vector<BenchRow> rows;
  const auto add = [&](std::string name, double value, std::optional<double> goal = {}, bool less_is_better = true) {
    rows.push_back({.name = std::move(name), .value = value, .goal = goal, .less_is_better = less_is_better});
  };
  add(fmt::format("cached composite (box {:.0f} %, object {:.0f} % of full HD) / plain blit", shares->box,
                  shares->covered),
      watch.ratio(cached, blit), 1.20);
  add("  the camera's picture alone / plain blit", watch.ratio(background, blit));
  add("  the building drawn for a plane of the display's / plain blit", watch.ratio(for_plane, blit));
  add("one pass, aerial perspective per vertex / without", watch.ratio(by_vertex, without_air), 1.08);
  add("one pass, aerial perspective per fragment / without", watch.ratio(by_fragment, without_air), 1.20);
  add("  one pass per vertex / plain blit", watch.ratio(by_vertex, blit));
  add("whole screen under air, sum over 81 wavelengths / K = 2",
      watch.ratio(pass(sum_of_81), pass(two_nodes), kSpectralPairs), 25.0, false);
  add("  sum over 41 wavelengths / K = 2", watch.ratio(pass(sum_of_41), pass(two_nodes), kSpectralPairs), {}, false);
  add("  K = 2 / plain blit", watch.ratio(pass(two_nodes), blit));
  add("the papers' two buffers (K = 2) / cached composite", watch.ratio(layout, cached), 2.5, false);
  add("  the papers' two buffers (K = 2) / one pass per vertex", watch.ratio(layout, by_vertex), {}, false);
  add("  the papers' two buffers with 81 wavelengths / cached composite",
      watch.ratio(layout_81, cached, kSpectralPairs), {}, false);
  add("  upload of an NV12 frame and its conversion / plain blit", watch.ratio(uploaded(scene.frame.nv12()), blit));
  add("  upload of an RGBA frame and its picture / plain blit", watch.ratio(uploaded(scene.frame.rgba()), blit));
  if (!watch.result()) return fail(watch.result().error());
  return rows;
}

}  // namespace kasumi

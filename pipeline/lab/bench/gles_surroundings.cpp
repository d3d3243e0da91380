// The cost of the building's surroundings: leaves that sway before it, and the shadow on the real ground.
#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "gles/gl/context.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/lab/bench/gles.hpp"
#include "pipeline/lab/bench/gles_scene.hpp"
#include "pipeline/lab/bench/gles_showing.hpp"
#include "pipeline/lab/bench/gles_stopwatch.hpp"
#include "pipeline/show/scene/ground_watch.hpp"

namespace kasumi {
namespace {

constexpr int kSurroundedPairs = 31;  // of frames
constexpr int kRedrawnPairs = 3;      // of redrawn layers

// Tufts of leaves that sway before the left half of the box: some of it always covered, some never.
Image<std::uint8_t> swaying(const SceneView& view, const PixelBox& box) {
  Image<std::uint8_t> mask(view.width, view.height, 255);
  for (int y = box.top; y < box.bottom; ++y)
    for (int x = box.left; x < (box.left + box.right) / 2; ++x) {
      const double covered = 0.5 + 0.9 * std::sin(0.21 * x + std::sin(0.05 * y)) * std::sin(0.17 * y);
      mask.at(x, y) = static_cast<std::uint8_t>(std::lround(255.0 * (1.0 - std::clamp(covered, 0.0, 1.0))));
    }
  return mask;
}

Image<std::uint8_t> hard(Image<std::uint8_t> mask) {
  for (std::uint8_t& share : mask.elements()) share = share < 128 ? 0 : 255;
  return mask;
}

// In percent of the box.
double mixed_share(const Image<std::uint8_t>& mask, const PixelBox& box) {
  const auto mixed = std::ranges::count_if(mask.elements(), [](auto share) { return share != 0 && share != 255; });
  return 100.0 * static_cast<double>(mixed) / ((box.right - box.left) * (box.bottom - box.top));
}

// The facade on the top of a slope that falls towards the camera.
Model on_a_slope(Model model) {
  constexpr float kHalf_m = 100.0f, kDeep_m = 80.0f, kFall_m = 25.0f;
  model.materials.push_back({.name = "ground", .base_colour = {0.1f, 0.12f, 0.07f, 1.0f}});
  ModelPart slope;
  slope.material = static_cast<int>(model.materials.size()) - 1;
  const glm::vec3 normal = glm::normalize(glm::vec3{0.0f, kDeep_m, kFall_m});
  for (const glm::vec3& at : {glm::vec3{-kHalf_m, -kFall_m, kDeep_m},
                              {kHalf_m, -kFall_m, kDeep_m},
                              {kHalf_m, 0.0f, 0.0f},
                              {-kHalf_m, 0.0f, 0.0f}})
    slope.vertices.push_back({.position = at, .normal = normal});
  slope.indices = {0, 1, 2, 0, 2, 3};
  model.ground = {slope};
  return model;
}

Camera camera_of(const SceneView& view) {
  Camera camera;
  camera.name = "scene";
  camera.width = view.width;
  camera.height = view.height;
  camera.lens = pinhole_lens({.focal_px = view.focal_px, .centre = view.centre_px});
  camera.to_world = glm::transpose(glm::dmat3(view.world_to_camera));
  return camera;
}

}  // namespace

Result<std::vector<BenchRow>> bench_surroundings() {
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  const BenchScene scene = make_bench_scene();
  auto offscreen = Offscreen::create((*context)->info(), scene.view.width, scene.view.height);
  if (!offscreen) return fail(offscreen.error());
  const DrawTarget target = offscreen->target();

  const Model slope = on_a_slope(scene.facade);
  auto open = showing(**context, scene, scene.facade), cut = showing(**context, scene, scene.facade);
  auto leaves = showing(**context, scene, scene.facade);
  auto ground = showing(**context, scene, slope), known_ground = showing(**context, scene, slope);
  for (const auto* renderer : {&open, &cut, &leaves, &ground, &known_ground})
    if (!*renderer) return fail(renderer->error());
  const PixelBox box = open->object_box();
  const auto mask = swaying(scene.view, box);
  for (const auto& [renderer, what] : {std::pair{&cut, hard(mask)}, {&leaves, mask}}) {
    if (auto set = (*renderer)->set_foreground(what, 0.0); !set) return fail(set.error());
    if (auto drawn = (*renderer)->redraw_layer(scene.appearance); !drawn) return fail(drawn.error());
  }

  ObjectAppearance lit = scene.appearance;
  lit.shadows = true;
  ObjectAppearance looked_at = lit;
  const glm::dvec3 place(scene.model_to_world[3]);
  GroundWatch ground_watch(camera_of(scene.view), slope, {.east_m = place.x, .north_m = place.y, .up_m = place.z});
  FrameMetadata metadata;
  const PictureView picture = scene.frame.rgba();
  const auto look = [&]() -> Result<> {
    metadata.captured_at += std::chrono::seconds(1);
    ground_watch.see(picture, metadata, lit, scene.measured);
    return {};
  };
  look();
  ground_watch.shade_foot(true);
  light_ground(looked_at, ground_watch.look());
  for (const auto& [renderer, appearance] : {std::pair{&ground, &lit}, {&known_ground, &looked_at}})
    if (auto drawn = (*renderer)->redraw_layer(*appearance); !drawn) return fail(drawn.error());

  const auto frame_of = [&](Renderer& renderer) { return [&] { return renderer.draw(scene.measured, target); }; };
  Stopwatch watch;
  std::vector<BenchRow> rows;
  const auto add = [&](std::string name, double value) {
    rows.push_back({.name = std::move(name), .value = value, .goal = {}});
  };
  add("cached composite behind a hard mask / without a mask",
      watch.ratio(frame_of(*cut), frame_of(*open), kSurroundedPairs));
  add(fmt::format("cached composite behind leaves that sway (matte of {:.0f} % of the box) / behind a hard mask",
                  mixed_share(mask, box)),
      watch.ratio(frame_of(*leaves), frame_of(*cut), kSurroundedPairs));
  add("cached composite over ground that is looked at / that is taken as lit",
      watch.ratio(frame_of(*known_ground), frame_of(*ground), kSurroundedPairs));
  add(fmt::format("  a look at {} places of it, once a second beside the drawing / cached composite",
                  ground_watch.places()),
      watch.ratio(look, frame_of(*ground), kSurroundedPairs));
  add("layer redrawn over ground that is looked at / that is taken as lit",
      watch.ratio(MovingSun(*known_ground, looked_at, true), MovingSun(*ground, lit, true), kRedrawnPairs));
  auto cut_on_processor = showing(**context, scene, scene.facade, {}, Mixing::processor);
  auto leaves_on_processor = showing(**context, scene, scene.facade, {}, Mixing::processor);
  for (const auto& [renderer, what] : {std::pair{&cut_on_processor, hard(mask)}, {&leaves_on_processor, mask}}) {
    if (!*renderer) return fail(renderer->error());
    if (auto set = (*renderer)->set_foreground(what, 0.0); !set) return fail(set.error());
    if (auto drawn = (*renderer)->redraw_layer(scene.appearance); !drawn) return fail(drawn.error());
  }
  const auto mixed = [&](Renderer& renderer) {
    return [&]() -> Result<> {
      const auto made = renderer.mix(scene.measured);
      return made ? Result<>{} : fail(made.error());
    };
  };
  add("mixed by the processor behind leaves that sway / behind a hard mask",
      watch.ratio(mixed(*leaves_on_processor), mixed(*cut_on_processor), kSurroundedPairs));
  if (!watch.result()) return fail(watch.result().error());
  return rows;
}

}  // namespace kasumi

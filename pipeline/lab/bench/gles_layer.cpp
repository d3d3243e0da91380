// What the object's light, its size and the camera's quality cost: in the layer, which is redrawn when air or sun
// change, and in every frame.
#include "capture/codec/encode.hpp"
#include "capture/codec/jpeg.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/lab/bench/gles.hpp"
#include "pipeline/lab/bench/gles_papers.hpp"
#include "pipeline/lab/bench/gles_scene.hpp"
#include "pipeline/lab/bench/gles_showing.hpp"
#include "pipeline/lab/bench/gles_stopwatch.hpp"

#include <algorithm>
#include <memory>

namespace kasumi {
namespace {

constexpr int kFramePairs = 31;      // of frames
constexpr int kLayerPairs = 3;       // of redrawn layers
constexpr int kLargeModelPairs = 1;  // of redrawn layers of the large model

Model glazed(Model model) {
  ModelMaterial& material = model.materials.front();
  material.roughness = 0.4f;
  material.reflectance = glm::vec3(0.04f);
  material.edge_reflectance = 1.0f;
  return model;
}

}  // namespace

Result<std::vector<BenchRow>> bench_layer() {
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  const BenchScene scene = make_bench_scene();
  auto offscreen = Offscreen::create((*context)->info(), scene.view.width, scene.view.height);
  if (!offscreen) return fail(offscreen.error());
  const DrawTarget target = offscreen->target();

  const Model large = make_bench_facade({.triangles = 930'000});
  auto plain = showing(**context, scene, scene.facade);
  auto glossy = showing(**context, scene, glazed(scene.facade));
  auto spread =
      showing(**context, scene, scene.facade, {.point_spread_px = 1.0, .chroma_columns = 2, .chroma_rows = 2});
  auto million = showing(**context, scene, large);
  auto decoded =
      showing(**context, scene, scene.facade, {.point_spread_px = 1.0, .chroma_columns = 2, .chroma_rows = 2});
  auto processed =
      showing(**context, scene, scene.facade,
              {.point_spread_px = 1.0, .chroma_columns = 2, .chroma_rows = 2, .sharpening = 0.8, .jpeg_blocks = true});
  for (const auto* renderer : {&plain, &glossy, &spread, &million, &decoded, &processed})
    if (!*renderer) return fail(renderer->error());
  auto by_processor = showing(**context, scene, scene.facade,
                              {.point_spread_px = 1.0, .chroma_columns = 2, .chroma_rows = 2}, Mixing::processor);
  auto processed_by_processor =
      showing(**context, scene, scene.facade,
              {.point_spread_px = 1.0, .chroma_columns = 2, .chroma_rows = 2, .sharpening = 0.8, .jpeg_blocks = true},
              Mixing::processor);
  for (const auto* renderer : {&by_processor, &processed_by_processor})
    if (!*renderer) return fail(renderer->error());
  Image<Rgb8> seen(scene.view.width, scene.view.height);
  std::ranges::transform(scene.frame.pixels.elements(), seen.elements().begin(),
                         [](const glm::u8vec4& pixel) { return Rgb8(pixel); });
  const auto jpeg = encode_jpeg(seen, 85, ChromaSubsampling::s420);
  if (!jpeg) return fail(jpeg.error());
  for (auto* renderer : {&decoded, &processed, &by_processor, &processed_by_processor})
    if (auto loaded = (*renderer)->upload(scene.frame.i420(), steps_of_jpeg()); !loaded) return fail(loaded.error());
  const GlTexture picture =
      make_picture_texture(scene.view.width, scene.view.height, scene.frame.pixels.elements().data());
  const auto blit = ScreenPass::blit(picture.name());
  if (!blit) return fail(blit.error());

  const auto plain_blit = [&] { return blit->draw(target); };
  const auto frame_of = [&](Renderer& renderer, const SensorNoise& noise = {}) {
    return [&, noise] { return renderer.draw(scene.measured, target, noise); };
  };
  const SensorNoise noise{glm::dvec3{1.0 / 2000.0}, glm::dvec3{0.003}, 1};
  const auto redraw = [&](Renderer& renderer, bool shadows) { return MovingSun(renderer, scene.appearance, shadows); };

  Stopwatch watch;
  std::vector<BenchRow> rows;
  const auto add = [&](std::string name, double value, std::optional<double> goal = {}) {
    rows.push_back({.name = std::move(name), .value = value, .goal = goal});
  };
  add("cached composite with the camera's noise / plain blit",
      watch.ratio(frame_of(*plain, noise), plain_blit, kFramePairs), 1.30);
  add("  with noise / without", watch.ratio(frame_of(*plain, noise), frame_of(*plain), kFramePairs));
  add("cached composite with point spread and shared colour / without",
      watch.ratio(frame_of(*spread), frame_of(*plain), kFramePairs), 1.10);
  add("cached composite sharpened and rounded as its camera's JPEG / without",
      watch.ratio(frame_of(*processed), frame_of(*decoded), kFramePairs));
  // With the upload, which the processor does not need.
  const auto by_shaders = [&]() -> Result<> {
    if (auto loaded = decoded->upload(scene.frame.i420(), nullptr); !loaded) return loaded;
    return decoded->draw(scene.measured, target);
  };
  const auto mixed = [&]() -> Result<> {
    if (auto loaded = by_processor->upload(scene.frame.i420(), nullptr); !loaded) return loaded;
    const auto made = by_processor->mix(scene.measured);
    return made ? Result<>{} : fail(made.error());
  };
  const auto decode = [&]() -> Result<> {
    const auto planes = decode_jpeg(*jpeg, scene.view.width, scene.view.height);
    return planes ? Result<>{} : fail(planes.error());
  };
  add("an I420 frame by the shaders / mixed by the processor", watch.ratio(by_shaders, mixed, kFramePairs));
  add("  mixed by the processor / decoding it from JPEG", watch.ratio(mixed, decode, kFramePairs));
  add("  mixed by the processor and on the screen's buffer / mixed",
      watch.ratio(
          [&]() -> Result<> {
            if (auto loaded = by_processor->upload(scene.frame.i420(), nullptr); !loaded) return loaded;
            return by_processor->draw(scene.measured, target);
          },
          mixed, kFramePairs));
  const auto mixed_by = [&](Renderer& renderer) {
    return [&]() -> Result<> {
      const auto made = renderer.mix(scene.measured);
      return made ? Result<>{} : fail(made.error());
    };
  };
  add("  mixed by the processor, sharpened and rounded as its camera's JPEG / without",
      watch.ratio(mixed_by(*processed_by_processor), mixed_by(*by_processor), kFramePairs), 1.15);
  add(fmt::format("cached composite of {:.2f} M triangles / of {:.3f} M",
                  1e-6 * static_cast<double>(large.triangle_count()),
                  1e-6 * static_cast<double>(scene.facade.triangle_count())),
      watch.ratio(frame_of(*million), frame_of(*plain), kFramePairs), 1.05);
  add("layer redrawn with the sun's 16 maps / without shadow",
      watch.ratio(redraw(*plain, true), redraw(*plain, false), kLayerPairs), 2.0);
  add("layer redrawn, glossy / matt", watch.ratio(redraw(*glossy, false), redraw(*plain, false), kLayerPairs), 1.5);
  add("layer redrawn with point spread and shared colour / without",
      watch.ratio(redraw(*spread, false), redraw(*plain, false), kLayerPairs), 2.0);
  add("layer of the large model redrawn / of the small",
      watch.ratio(redraw(*million, false), redraw(*plain, false), kLargeModelPairs));
  add("  with the sun's 16 maps / without",
      watch.ratio(redraw(*million, true), redraw(*million, false), kLargeModelPairs));
  rows.push_back({.name = "the large model on the GPU",
                  .value = static_cast<double>(million->model_bytes()) / (1 << 20),
                  .unit = "MiB",
                  .goal = {}});
  if (!watch.result()) return fail(watch.result().error());
  return rows;
}

}  // namespace kasumi

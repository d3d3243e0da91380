// A picture of full HD by every path, for `kasumi bench --board`: one round after the other, so that what slows a
// machine down (heat, others' work) falls on all alike.
#include <chrono>

#include "base/statistics.hpp"
#include "capture/codec/encode.hpp"
#include "capture/codec/jpeg.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/lab/bench/gles_papers.hpp"
#include "pipeline/lab/bench/gles_scene.hpp"
#include "pipeline/lab/bench/gles_showing.hpp"
#include "pipeline/lab/bench/gles_stopwatch.hpp"
#include "pipeline/lab/bench/machine_board.hpp"

namespace kasumi {
namespace {

using std::chrono::steady_clock;

constexpr int kRounds = 21, kLayerRounds = 3;
constexpr auto kLongest = std::chrono::seconds(45);  // of what is repeated

struct Task {
  const char* name;
  std::function<Result<>()> work;
  std::vector<double> seconds{};
};

// At least one round.
Result<> measure(std::vector<Task>& tasks, int rounds, steady_clock::time_point end) {
  for (int round = 0; round < rounds && (round == 0 || steady_clock::now() < end); ++round)
    for (Task& task : tasks) {
      Result<> done;
      const double seconds = seconds_of([&] {
        done = task.work();
        glFinish();
      });
      if (!done) return done;
      task.seconds.push_back(seconds);
    }
  return {};
}

std::string abilities_of(const GlInfo& info) {
  const bool half = info.has("GL_EXT_color_buffer_half_float") || info.has("GL_EXT_color_buffer_float");
  return fmt::format(
      "{}, {}; textures to {}; layer in {}; camera buffers are {}; {} precision in shaders", info.renderer,
      info.version, info.max_texture_size, half ? "half floats" : "bytes",
      info.has("GL_OES_EGL_image_external") && !info.software ? "imported if the driver takes them" : "copied",
      info.highp_fragments ? "high" : "medium");
}

Result<std::vector<std::uint8_t>> frame_as_jpeg(const BenchScene& scene) {
  Image<Rgb8> seen(scene.view.width, scene.view.height);
  std::ranges::transform(scene.frame.pixels.elements(), seen.elements().begin(),
                         [](const glm::u8vec4& pixel) { return Rgb8(pixel); });
  return encode_jpeg(seen, 85, ChromaSubsampling::s420);
}

}  // namespace

Result<BoardDrawing> draw_for_board() {
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  const GlInfo& info = (*context)->info();
  const BenchScene scene = make_bench_scene();
  auto offscreen = Offscreen::create(info, scene.view.width, scene.view.height);
  if (!offscreen) return fail(offscreen.error());
  const DrawTarget target = offscreen->target();
  const GlTexture picture =
      make_picture_texture(scene.view.width, scene.view.height, scene.frame.pixels.elements().data());
  const auto blit = ScreenPass::blit(picture.name());
  if (!blit) return fail(blit.error());
  const ObjectDetail camera{.point_spread_px = 1.0, .chroma_columns = 2, .chroma_rows = 2};
  ObjectDetail sharpened = camera;
  sharpened.sharpening = 0.8;
  sharpened.jpeg_blocks = true;
  auto gpu = showing(**context, scene, scene.facade, camera);
  auto gpu_sharpened = showing(**context, scene, scene.facade, sharpened);
  auto processor = showing(**context, scene, scene.facade, camera, Mixing::processor);
  auto processor_sharpened = showing(**context, scene, scene.facade, sharpened, Mixing::processor);
  for (const auto* renderer : {&gpu, &gpu_sharpened, &processor, &processor_sharpened})
    if (!*renderer) return fail(renderer->error());
  const auto jpeg = frame_as_jpeg(scene);
  if (!jpeg) return fail(jpeg.error());
  const PixelBox box = gpu->object_box();
  auto plane = Offscreen::create(info, box.right - box.left, box.bottom - box.top);
  if (!plane) return fail(plane.error());

  const auto steps = steps_of_jpeg();
  const auto drawn = [&](Renderer& renderer) {
    return [&]() -> Result<> {
      if (auto loaded = renderer.upload(scene.frame.i420(), steps); !loaded) return loaded;
      return renderer.draw(scene.measured, target);
    };
  };
  const auto mixed = [&](Renderer& renderer) {
    return [&]() -> Result<> {
      if (auto loaded = renderer.upload(scene.frame.i420(), steps); !loaded) return loaded;
      const auto made = renderer.mix(scene.measured);
      return made ? Result<>{} : fail(made.error());
    };
  };
  std::vector<Task> tasks{
      {"plain blit of full HD", [&] { return blit->draw(target); }},
      {"decoding it from JPEG",
       [&]() -> Result<> {
         const auto planes = decode_jpeg(*jpeg, scene.view.width, scene.view.height);
         return planes ? Result<>{} : fail(planes.error());
       }},
      {"upload and composite by GL", drawn(*gpu)},
      {"... sharpened and rounded as its camera's JPEG", drawn(*gpu_sharpened)},
      {"mixed by the processor, without GL", mixed(*processor)},
      {"... sharpened and rounded as its camera's JPEG", mixed(*processor_sharpened)},
      {"mixed by the processor, and on the screen's buffer", drawn(*processor)},
      {"the building drawn for a plane of the display's",
       [&] { return gpu->draw_for_plane(scene.measured, plane->target()); }},
  };
  std::vector<Task> layers{
      {"the building's layer redrawn, with the sun's 16 maps", MovingSun(*gpu, scene.appearance, true)}};
  const auto end = steady_clock::now() + kLongest;
  if (auto done = measure(tasks, 1, end); !done) return fail(done.error());
  for (Task& task : tasks) task.seconds.clear();  // the first picture of each compiles and allocates
  if (auto done = measure(tasks, kRounds, end); !done) return fail(done.error());
  if (auto done = measure(layers, kLayerRounds, end); !done) return fail(done.error());

  BoardDrawing drawing{abilities_of(info), info.software ? "the processor, since GL is software" : "the GPU", {}};
  for (auto* each : {&tasks, &layers})
    for (const Task& task : *each) {
      std::vector<double> ratios;
      for (std::size_t i = 0; i < std::min(task.seconds.size(), tasks[0].seconds.size()); ++i)
        ratios.push_back(task.seconds[i] / tasks[0].seconds[i]);
      drawing.rows.push_back({.name = task.name, .value = 1e3 * median(task.seconds), .unit = "ms", .goal = {}});
      if (each == &tasks && &task != &tasks[0])
        drawing.rows.push_back({.name = "  / plain blit", .value = median(ratios), .goal = {}});
    }
  return drawing;
}

}  // namespace kasumi

// What `kasumi bench` draws: a facade 3.5 km away before a full-HD camera, under air of turbidity 3. Made in memory,
// the same on every machine.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "estimator/atmosphere.hpp"
#include "gles/composite/renderer.hpp"
#include "gles/model/model.hpp"
#include "gles/scene.hpp"

namespace kasumi {

constexpr Turbidity kBenchTurbidity{3.0};

// The camera's frame, once in each layout.
struct BenchFrame {
  Image<glm::u8vec4> pixels;
  std::vector<std::uint8_t> luma;    // as many as pixels
  std::vector<std::uint8_t> chroma;  // U V at half width and half height, grey
  PictureView rgba() const;
  PictureView nv12() const;
  PictureView i420() const;
};

struct BenchScene {
  Model facade;  // arched openings and a gable: its edge is as long as a building's
  glm::dmat4 model_to_world{1.0};
  SceneView view;
  ObjectAppearance appearance;
  AirlightGrid measured;
  BenchFrame frame;
};

struct BenchSize {
  int width = 1920, height = 1080;
  int triangles = 19'000;  // about as many, of all buildings together
  int buildings = 1;       // side by side, each with a texture of its own
  int texture_side = 512;  // pixels
};

BenchScene make_bench_scene(const BenchSize& size = {});
// The haze before it in another air.
Haze bench_haze(Turbidity air);
// Its building's layer drawn, as before each picture.
Result<Renderer> drawn_by_renderer(GlContext& context, const BenchScene& scene);
// The same facade alone.
Model make_bench_facade(const BenchSize& size);

}  // namespace kasumi

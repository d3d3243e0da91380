#include "pipeline/lab/bench/gles_scene.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>

#include "base/units.hpp"
#include "calib/colour/spectral_sensitivity.hpp"
#include "estimator/air/attenuation.hpp"
#include "estimator/air/scattering.hpp"
#include "pipeline/show/scene/for_gles.hpp"

namespace kasumi {
namespace {

constexpr double kDistance_m = 3500.0;
constexpr double kSeenWidth_m = 240.0, kSeenHeight_m = 135.0;  // by the camera, there
constexpr double kFacadeWidth_m = 0.5 * kSeenWidth_m, kFacadeHeight_m = 0.5 * kSeenHeight_m;

std::uint8_t byte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

ModelTexture masonry(int side, std::mt19937_64& random) {
  constexpr int kCourse = 32;
  ModelTexture texture{.pixels = Image<glm::u8vec4>(side, side)};
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const int shifted = x + (y / kCourse % 2) * kCourse;
      const bool joint = y % kCourse < 2 || shifted % (2 * kCourse) < 2;
      const double grain = 24.0 * (static_cast<double>(random() % 1024) / 1024.0 - 0.5);
      const double level = (joint ? 120.0 : 190.0) + grain;
      texture.pixels.at(x, y) = {byte(level), byte(0.93 * level), byte(0.8 * level), 255};
    }
  return texture;
}

// A facade in the x-y plane facing +z, from x = left_m: a grid of cells, left out where the openings are and above the
// gable.
ModelPart make_facade(double left_m, double width_m, double height_m, int triangles) {
  constexpr int kColumns = 150, kRows = 80, kTriangles = 19'000;  // the openings are drawn on this grid
  const double finer = std::sqrt(static_cast<double>(triangles) / kTriangles);
  const int columns = std::max(1, static_cast<int>(std::lround(kColumns * finer)));
  const int rows = std::max(1, static_cast<int>(std::lround(kRows * finer)));
  ModelPart part;
  const auto place = [&](int i, int j) {
    const double x = left_m + width_m * i / columns, y = height_m * j / rows;
    return glm::dvec3{x, y, 0.4 * std::sin(0.9 * x) * std::cos(0.7 * y)};
  };
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const auto here = place(i, j);
      const auto normal = glm::normalize(glm::cross(place(i + 1, j) - here, place(i, j + 1) - here));
      part.vertices.push_back({glm::vec3(here), glm::vec3(normal), glm::vec2(here.x, -here.y) / 16.0f, glm::vec4(1)});
    }
  const auto at = [=](int i, int j) { return static_cast<std::uint32_t>(j * (columns + 1) + i); };
  const auto stands = [=](int i, int j) {
    const double gable = rows - 0.27 * std::abs(i + 0.5 - 0.5 * columns);
    const int across = i * kColumns / columns % 25, up = j * kRows / rows % 27;
    const bool opening = across >= 9 && across < 16 && up >= 6 && up < 18 - std::abs(across - 12);
    return j < gable && !opening;
  };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      if (stands(i, j))
        part.indices.insert(part.indices.end(),
                            {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)});
  return part;
}

// All facades together are as wide and high as one alone.
Model make_facades(const BenchSize& size, std::mt19937_64& random) {
  Model model;
  model.name = "facade";
  const double width_m = kFacadeWidth_m / size.buildings;
  for (int i = 0; i < size.buildings; ++i) {
    model.materials.push_back({.name = "masonry", .texture = i});
    model.textures.push_back(masonry(size.texture_side, random));
    model.parts.push_back(
        make_facade(width_m * i - 0.5 * kFacadeWidth_m, width_m, kFacadeHeight_m, size.triangles / size.buildings));
    model.parts.back().material = i;
  }
  return model;
}

// Camera looks north, level.
SceneView view_north(int width, int height) {
  SceneView view;
  view.width = width;
  view.height = height;
  view.focal_px = glm::dvec2{kDistance_m / kSeenWidth_m * width};
  view.centre_px = {0.5 * (width - 1), 0.5 * (height - 1)};
  view.world_to_camera = glm::dmat4{{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}, {0, 0, 0, 1}};
  view.near_m = 0.5 * kDistance_m;
  view.far_m = 2.0 * kDistance_m;
  return view;
}

AirlightGrid airlight(const glm::dvec3& level, const BenchSize& size) {
  AirlightGrid grid{.first_px = {-0.5, -0.5}, .last_px = {size.width - 0.5, size.height - 0.5}};
  for (std::size_t i = 0; i < grid.light.size(); ++i)
    grid.light[i] = level * (1.0 + 0.01 * double(i % AirlightGrid::kColumns));
  return grid;
}

BenchFrame make_frame(int width, int height, std::mt19937_64& random) {
  BenchFrame frame;
  frame.pixels = Image<glm::u8vec4>(width, height);
  frame.luma.reserve(static_cast<std::size_t>(width) * height);
  frame.chroma.assign(static_cast<std::size_t>(width) * height / 2, 128);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double level = 210.0 - 86.4 * y / height + 6.0 * (static_cast<double>(random() % 1024) / 1024.0 - 0.5);
      frame.pixels.at(x, y) = glm::u8vec4{glm::u8vec3{byte(level)}, 255};
      frame.luma.push_back(byte(level));
    }
  return frame;
}

}  // namespace

PictureView BenchFrame::rgba() const {
  return {.layout = PixelLayout::rgba8,
          .width = pixels.width(),
          .height = pixels.height(),
          .planes = {Plane{&pixels.elements().data()->x, 4 * static_cast<std::size_t>(pixels.width())}}};
}

PictureView BenchFrame::nv12() const {
  return {.layout = PixelLayout::nv12,
          .width = pixels.width(),
          .height = pixels.height(),
          .planes = {Plane{luma.data(), static_cast<std::size_t>(pixels.width())},
                     Plane{chroma.data(), static_cast<std::size_t>(pixels.width())}}};
}

PictureView BenchFrame::i420() const {
  const auto half = static_cast<std::size_t>(pixels.width() / 2);
  return {.layout = PixelLayout::i420,
          .width = pixels.width(),
          .height = pixels.height(),
          .planes = {Plane{luma.data(), 2 * half}, Plane{chroma.data(), half},
                     Plane{chroma.data() + chroma.size() / 2, half}}};
}

Haze bench_haze(Turbidity air) {
  const auto nodes = attenuation_nodes(spectral_measure(generic_sensitivity()));
  return haze_for_gles(haze_coefficients(nodes, ScatteringModel::morales2017, air), 50.0);
}

BenchScene make_bench_scene(const BenchSize& size) {
  std::mt19937_64 random(1);
  BenchScene scene;
  scene.facade = make_facades(size, random);
  scene.model_to_world = model_to_world({.north_m = kDistance_m, .up_m = -0.5 * kFacadeHeight_m});
  scene.view = view_north(size.width, size.height);

  scene.appearance.haze = bench_haze(kBenchTurbidity);
  scene.appearance.light.sun_direction = glm::normalize(glm::dvec3{0.4, -0.6, 0.7});
  scene.appearance.light.sun_irradiance = {0.9, 0.85, 0.75};
  scene.appearance.light.around = light_around_of([](const Direction& d) {
    return glm::dvec3{0.048, 0.058, 0.084} + d.z * glm::dvec3{0.047, 0.058, 0.082};
  });
  scene.appearance.horizon = airlight({0.3, 0.32, 0.36}, size);
  scene.measured = airlight({0.55, 0.6, 0.68}, size);
  scene.frame = make_frame(size.width, size.height, random);
  return scene;
}

Model make_bench_facade(const BenchSize& size) {
  std::mt19937_64 random(1);
  return make_facades(size, random);
}

Result<Renderer> drawn_by_renderer(GlContext& context, const BenchScene& scene) {
  auto renderer = Renderer::create(context);
  if (!renderer) return renderer;
  if (auto set = renderer->set_model(scene.facade); !set) return fail(set.error());
  if (auto set = renderer->set_view(scene.view, scene.model_to_world); !set) return fail(set.error());
  if (auto drawn = renderer->redraw_layer(scene.appearance); !drawn) return fail(drawn.error());
  return renderer;
}

}  // namespace kasumi

#include "pipeline/bench/gles_scene.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>

#include "base/units.hpp"
#include "calib/colour/spectral_sensitivity.hpp"
#include "estimator/air/attenuation.hpp"
#include "estimator/air/scattering.hpp"
#include "pipeline/scene/for_gles.hpp"

namespace kasumi {
namespace {

constexpr int kWidth = 1920, kHeight = 1080;
constexpr double kDistance_m = 3500.0;
constexpr double kMetresPerPixel = 0.125;
constexpr double kFacadeWidth_m = 0.5 * kWidth * kMetresPerPixel, kFacadeHeight_m = 0.5 * kHeight * kMetresPerPixel;

std::uint8_t byte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

ModelTexture masonry(std::mt19937_64& random) {
  constexpr int kSize = 512, kCourse = 32;
  ModelTexture texture{.pixels = Image<glm::u8vec4>(kSize, kSize)};
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const int shifted = x + (y / kCourse % 2) * kCourse;
      const bool joint = y % kCourse < 2 || shifted % (2 * kCourse) < 2;
      const double grain = 24.0 * (static_cast<double>(random() % 1024) / 1024.0 - 0.5);
      const double level = (joint ? 120.0 : 190.0) + grain;
      texture.pixels.at(x, y) = {byte(level), byte(0.93 * level), byte(0.8 * level), 255};
    }
  return texture;
}

// A facade in the x-y plane facing +z, its bottom centre at the origin: a grid of cells, left out where the
// openings are and above the gable.
Model make_facade(double width_m, double height_m, int finer, std::mt19937_64& random) {
  const int columns = 150 * finer, rows = 80 * finer;
  ModelPart part;
  const auto place = [&](int i, int j) {
    const double x = width_m * (double(i) / columns - 0.5), y = height_m * j / rows;
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
    const int across = i / finer % 25, up = j / finer % 27;
    const bool opening = across >= 9 && across < 16 && up >= 6 && up < 18 - std::abs(across - 12);
    return j < gable && !opening;
  };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      if (stands(i, j))
        part.indices.insert(part.indices.end(),
                            {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)});
  Model model;
  model.name = "facade";
  model.materials.push_back({.name = "masonry", .texture = 0});
  model.textures.push_back(masonry(random));
  model.parts.push_back(std::move(part));
  return model;
}

// Camera looks north, level.
SceneView view_north() {
  SceneView view;
  view.width = kWidth;
  view.height = kHeight;
  view.focal_px = glm::dvec2{kDistance_m / kMetresPerPixel};
  view.centre_px = {0.5 * (kWidth - 1), 0.5 * (kHeight - 1)};
  view.world_to_camera = glm::dmat4{{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}, {0, 0, 0, 1}};
  view.near_m = 0.5 * kDistance_m;
  view.far_m = 2.0 * kDistance_m;
  return view;
}

AirlightGrid airlight(const glm::dvec3& level) {
  AirlightGrid grid{.first_px = {-0.5, -0.5}, .last_px = {kWidth - 0.5, kHeight - 0.5}};
  for (std::size_t i = 0; i < grid.light.size(); ++i)
    grid.light[i] = level * (1.0 + 0.01 * double(i % AirlightGrid::kColumns));
  return grid;
}

BenchFrame make_frame(std::mt19937_64& random) {
  BenchFrame frame;
  frame.pixels = Image<glm::u8vec4>(kWidth, kHeight);
  frame.luma.resize(std::size_t{kWidth} * kHeight);
  frame.chroma.assign(std::size_t{kWidth} * kHeight / 2, 128);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const double level = 210.0 - 0.08 * y + 6.0 * (static_cast<double>(random() % 1024) / 1024.0 - 0.5);
      frame.pixels.at(x, y) = glm::u8vec4{glm::u8vec3{byte(level)}, 255};
      frame.luma[static_cast<std::size_t>(y * kWidth + x)] = byte(level);
    }
  return frame;
}

}  // namespace

PictureView BenchFrame::rgba() const {
  return {.layout = PixelLayout::rgba8,
          .width = kWidth,
          .height = kHeight,
          .planes = {Plane{&pixels.elements().data()->x, 4 * std::size_t{kWidth}}}};
}

PictureView BenchFrame::nv12() const {
  return {.layout = PixelLayout::nv12,
          .width = kWidth,
          .height = kHeight,
          .planes = {Plane{luma.data(), kWidth}, Plane{chroma.data(), kWidth}}};
}

BenchScene make_bench_scene() {
  std::mt19937_64 random(1);
  BenchScene scene;
  scene.facade = make_facade(kFacadeWidth_m, kFacadeHeight_m, 1, random);
  scene.model_to_world = model_to_world({.north_m = kDistance_m, .up_m = -0.5 * kFacadeHeight_m});
  scene.view = view_north();

  const auto nodes = attenuation_nodes(spectral_measure(generic_sensitivity()));
  scene.appearance.haze = haze_for_gles(haze_coefficients(nodes, ScatteringModel::morales2017, kBenchTurbidity), 50.0);
  scene.appearance.light.sun_direction = glm::normalize(glm::dvec3{0.4, -0.6, 0.7});
  scene.appearance.light.sun_irradiance = {0.9, 0.85, 0.75};
  scene.appearance.light.around = light_around_of([](const Direction& d) {
    return glm::dvec3{0.048, 0.058, 0.084} + d.z * glm::dvec3{0.047, 0.058, 0.082};
  });
  scene.appearance.horizon = airlight({0.3, 0.32, 0.36});
  scene.measured = airlight({0.55, 0.6, 0.68});
  scene.frame = make_frame(random);
  return scene;
}

Model make_bench_facade(int finer) {
  std::mt19937_64 random(1);
  return make_facade(kFacadeWidth_m, kFacadeHeight_m, finer, random);
}

}  // namespace kasumi

#include "tests/gles/scenes.hpp"
#include "tests/places.hpp"

#include <cmath>

#include <glm/geometric.hpp>
#include <opencv2/imgcodecs.hpp>

namespace kasumi {
namespace {

void add_face(ModelPart& part, glm::dvec3 corner, glm::dvec3 along, glm::dvec3 up, int cells) {
  const auto first = static_cast<std::uint32_t>(part.vertices.size());
  const glm::vec3 normal(glm::normalize(glm::cross(along, up)));
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const double s = double(i) / cells, t = double(j) / cells;
      part.vertices.push_back({.position = glm::vec3(corner + s * along + t * up),
                               .normal = normal,
                               .texture = glm::vec2(s, 1.0 - t),
                               .colour = glm::vec4(1.0f),
                               .texture_2 = glm::vec2(0.7 * s + 0.2 * t, 0.8 * t),
                               .tangent = glm::vec4(glm::normalize(glm::vec3(along)), 1.0f)});
    }
  const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(j * (cells + 1) + i); };
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i)
      part.indices.insert(part.indices.end(),
                          {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)});
}

std::uint8_t byte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

// A texture of u and v in 0 .. 2 pi.
ModelTexture waves(int size, bool data, const std::function<glm::dvec3(double, double)>& of) {
  ModelTexture texture;
  texture.data = data;
  texture.pixels = Image<glm::u8vec4>(size, size);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const glm::dvec3 value = of(2.0 * kPi * x / size, 2.0 * kPi * y / size);
      texture.pixels.at(x, y) = {byte(value.x), byte(value.y), byte(value.z), 255};
    }
  return texture;
}

}  // namespace

ModelPart box_part(glm::dvec3 a, glm::dvec3 b, int cells, int material) {
  ModelPart part;
  part.material = material;
  const glm::dvec3 x{b.x - a.x, 0, 0}, y{0, b.y - a.y, 0}, z{0, 0, b.z - a.z};
  add_face(part, {a.x, a.y, b.z}, x, y, cells);
  add_face(part, {b.x, a.y, a.z}, -x, y, cells);
  add_face(part, {b.x, a.y, b.z}, -z, y, cells);
  add_face(part, {a.x, a.y, a.z}, z, y, cells);
  add_face(part, {a.x, b.y, b.z}, x, -z, cells);
  add_face(part, {a.x, a.y, a.z}, x, z, cells);
  return part;
}

Model box_model(double width_m, double height_m, double depth_m, int cells) {
  Model model;
  model.name = "box";
  model.materials.push_back({.name = "plaster", .base_colour = {0.7f, 0.6f, 0.45f, 1.0f}});
  model.parts.push_back(box_part({-width_m / 2, 0, -depth_m / 2}, {width_m / 2, height_m, depth_m / 2}, cells));
  return model;
}

Model columns_model(int count, double thickness_m, double spacing_m, double height_m) {
  Model model;
  model.name = "columns";
  model.materials.push_back({.name = "marble", .base_colour = {0.8f, 0.8f, 0.75f, 1.0f}});
  const double first = -0.5 * (count - 1) * spacing_m;
  for (int i = 0; i < count; ++i) {
    const double x = first + i * spacing_m;
    model.parts.push_back(
        box_part({x - thickness_m / 2, 2, -thickness_m / 2}, {x + thickness_m / 2, height_m, thickness_m / 2}, 1));
  }
  model.parts.push_back(box_part({first - spacing_m, 0, -spacing_m}, {-first + spacing_m, 2, spacing_m}, 2));
  return model;
}

ModelTexture soft_texture(int size) {
  return waves(size, false, [](double u, double v) {
    return glm::dvec3{150 + 60 * std::sin(u), 140 + 50 * std::cos(v), 120 + 50 * std::sin(u + v)};
  });
}

ModelTexture soft_normals(int size) {
  return waves(size, true, [](double u, double v) {
    return 127.5 * glm::normalize(glm::dvec3{0.5 * std::sin(u), 0.35 * std::cos(u + v), 1.0}) + 127.5;
  });
}

ModelTexture soft_data(int size) {
  return waves(size, true, [](double u, double v) {
    return 160.0 + 80.0 * glm::dvec3{std::sin(u + v), std::cos(u), std::sin(v)};
  });
}

ModelPart ball_part(glm::dvec3 centre, double radius, int steps, int material) {
  ModelPart part;
  part.material = material;
  for (int j = 0; j <= steps; ++j)
    for (int i = 0; i <= 2 * steps; ++i) {
      const double down = kPi * j / steps, around = kPi * i / steps;
      const glm::dvec3 n{std::sin(down) * std::sin(around), std::cos(down), std::sin(down) * std::cos(around)};
      part.vertices.push_back({.position = glm::vec3(centre + radius * n),
                               .normal = glm::vec3(n),
                               .texture = glm::vec2(0.5 * i / steps, double(j) / steps),
                               .colour = glm::vec4(1.0f),
                               .texture_2 = glm::vec2(0.0f),
                               .tangent = glm::vec4(std::cos(around), 0.0, -std::sin(around), 1.0)});
    }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * (2 * steps + 1) + i); };
  for (int j = 0; j < steps; ++j)
    for (int i = 0; i < 2 * steps; ++i)
      part.indices.insert(part.indices.end(),
                          {at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i + 1, j)});
  return part;
}

ObjectAppearance furnace(double radiance) {
  ObjectAppearance look;
  look.aerial_perspective = false;
  look.light.around = light_around_of([&](const Direction&) { return glm::dvec3{radiance}; });
  look.horizon.last_px = {1.0, 1.0};
  look.horizon.light.fill(glm::dvec3{radiance});
  return look;
}

SceneView view_north(int width, int height, double focal_px) {
  SceneView view;
  view.width = width;
  view.height = height;
  view.focal_px = {focal_px, focal_px};
  view.centre_px = {(width - 1) / 2.0, (height - 1) / 2.0};
  view.world_to_camera = glm::dmat4({1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}, {0, 0, 0, 1});
  return view;
}

ObjectAppearance afternoon(const SceneView& view) {
  ObjectAppearance look;
  const std::array<double, 3> nm{600, 540, 450};
  for (std::size_t k = 0; k < kHazeNodes; ++k)
    for (int c = 0; c < 3; ++c) {
      const double relative = 550.0 / (nm[static_cast<std::size_t>(c)] * (k == 0 ? 0.96 : 1.04));
      look.haze.weight[k][c] = k == 0 ? 0.4 : 0.6;
      look.haze.rayleigh_per_m[k][c] = 1.41e-5 * std::pow(relative, 4);
      look.haze.mie_per_m[k][c] = 2.1e-4 * std::pow(relative, 2);
    }
  look.haze.observer_altitude_m = 250.0;
  look.light.sun_direction = glm::normalize(glm::dvec3{-0.6, -0.7, 0.55});
  look.light.sun_irradiance = {2.0, 1.9, 1.7};
  // Of order 2, which the reference represents completely.
  look.light.around = light_around_of([](const Direction& d) {
    return glm::dvec3{0.16, 0.18, 0.216} + d.z * glm::dvec3{0.117, 0.14, 0.187} +
           glm::dvec3{0.023, 0.023, 0.023} * d.y - glm::dvec3{0.023, 0.023, 0.012} * d.x +
           0.07 * d.x * glm::dvec3{d.y - d.z, d.y + 0.75 * d.z, d.y + 0.5 * d.z} +
           (3.0 * d.z * d.z - 1.0) * glm::dvec3{0.024, 0.024, 0.04} + d.y * d.z * glm::dvec3{0.028, 0.042, 0.056} +
           (d.x * d.x - d.y * d.y) * glm::dvec3{0.021, -0.014, 0.007};
  });
  look.horizon = measured_airlight(view, 1.6);
  for (std::size_t i = 0; i < look.horizon.light.size(); ++i)
    look.horizon.light[i] *= 1.0 + 0.05 * std::sin(1.7 * double(i));
  return look;
}

AirlightGrid measured_airlight(const SceneView& view, double exposure) {
  AirlightGrid grid;
  grid.first_px = {0.1 * view.width, 0.2 * view.height};
  grid.last_px = {0.9 * view.width, 0.8 * view.height};
  for (int row = 0; row < AirlightGrid::kRows; ++row)
    for (int column = 0; column < AirlightGrid::kColumns; ++column)
      grid.light[static_cast<std::size_t>(row * AirlightGrid::kColumns + column)] =
          exposure * (1.0 + 0.25 * column / 7.0 - 0.08 * row) * glm::dvec3{0.42, 0.47, 0.52};
  return grid;
}

Image<Rgb8> landscape(int width, int height) {
  Image<Rgb8> picture(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double t = double(y) / height;
      if (t < 0.6)
        picture.at(x, y) = {byte(110 + 120 * t), byte(140 + 100 * t), byte(190 + 40 * t)};
      else
        picture.at(x, y) = {byte(90 + 30 * std::sin(0.3 * x + 0.2 * y)), byte(100 + 25 * std::sin(0.21 * x)),
                            byte(60 + (x * 7 + y * 3) % 17)};
    }
  return picture;
}

ReferenceScene box_scene() {
  ReferenceScene scene;
  scene.model = box_model(60, 40, 60);
  scene.view = view_north(160, 120, 6000);
  scene.model_to_world = model_to_world({5, 3500, -12, from_degrees(30), 1.0});
  scene.appearance = afternoon(scene.view);
  scene.measured = measured_airlight(scene.view);
  return scene;
}

void GlesTest::SetUp() {
  auto context = open_headless_context();
  if (!context) GTEST_SKIP() << context.error().message;
  context_ = std::move(*context);
}

Renderer GlesTest::make_renderer(const RendererOptions& options) {
  auto renderer = Renderer::create(*context_, options);
  if (!renderer) throw std::runtime_error(renderer.error().message);
  return std::move(*renderer);
}

Offscreen GlesTest::make_target(int width, int height, int samples) {
  auto target = Offscreen::create(info(), width, height, Offscreen::Depth::buffer, samples);
  if (!target) throw std::runtime_error(target.error().message);
  return std::move(*target);
}

void GlesTest::load(Renderer& renderer, const ReferenceScene& scene) {
  ASSERT_OK(renderer.set_model(scene.model));
  ASSERT_OK(renderer.set_view(scene.view, scene.model_to_world));
  ASSERT_OK(renderer.set_response(scene.response));
  ASSERT_OK(renderer.set_foreground(scene.mask));
  ASSERT_OK(renderer.set_scene_depth(scene.depth_m));
  ASSERT_OK(renderer.redraw_layer(scene.appearance));
}

Renderer GlesTest::loaded(const ReferenceScene& scene, const RendererOptions& options) {
  Renderer renderer = make_renderer(options);
  load(renderer, scene);
  return renderer;
}

Image<Rgb8> GlesTest::draw(Renderer& renderer, const AirlightGrid& measured, const PictureView& frame) {
  Offscreen target = make_target(frame.width, frame.height);
  const auto done = renderer.upload(frame).and_then([&] { return renderer.draw(measured, target.target()); });
  if (!done) throw std::runtime_error(done.error().message);
  auto picture = target.read();
  if (!picture) throw std::runtime_error(picture.error().message);
  return std::move(*picture);
}

Image<Rgb8> GlesTest::draw_moving(Renderer& renderer, const ReferenceScene& scene, const PictureView& frame,
                                  HazeDetail detail, int samples) {
  Offscreen target = make_target(frame.width, frame.height, samples);
  const auto done = renderer.upload(frame).and_then(
      [&] { return renderer.draw_moving(scene.appearance, scene.measured, target.target(), detail); });
  if (!done) throw std::runtime_error(done.error().message);
  auto picture = target.read();
  if (!picture) throw std::runtime_error(picture.error().message);
  return std::move(*picture);
}

void GlesTest::expect_like(const Image<Rgb8>& picture, const ReferencePicture& reference, double least_db) {
  const double db = psnr(picture, reference);
  RecordProperty("psnr_db", fmt::format("{:.2f}", db));
  EXPECT_GE(db, least_db) << "dB";
  if (db >= least_db) return;
  Image<Rgb8> expected(picture.width(), picture.height());
  for (std::size_t i = 0; i < expected.elements().size(); ++i)
    for (int c = 0; c < 3; ++c) expected.elements()[i][c] = byte(reference.encoded.elements()[i][c]);
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder = test_output_folder() / "gles";
  save_png(picture, folder / fmt::format("{}-gpu.png", test->name()));
  save_png(expected, folder / fmt::format("{}-cpu.png", test->name()));
}

void GlesTest::expect_same(const ReferenceScene& scene, const std::vector<RendererOptions>& ways, double least_db) {
  const Image<Rgb8> camera = landscape(scene.view.width, scene.view.height);
  const auto reference = render_reference(scene, camera, turned_lattice());
  for (const RendererOptions& options : ways) {
    Renderer renderer = loaded(scene, options);
    expect_like(draw(renderer, scene.measured, view_of(camera)), reference, least_db);
  }
}

void save_png(const Image<Rgb8>& picture, const std::filesystem::path& path) {
  std::filesystem::create_directories(path.parent_path());
  cv::Mat bgr(picture.height(), picture.width(), CV_8UC3);
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const Rgb8 p = picture.at(x, y);
      bgr.at<cv::Vec3b>(y, x) = {p.b, p.g, p.r};
    }
  cv::imwrite(path.string(), bgr);
}

}  // namespace kasumi

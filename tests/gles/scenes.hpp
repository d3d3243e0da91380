// Small scenes of known shape for the tests.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gles/composite/renderer.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/offscreen.hpp"
#include "tests/gles/object/reference_renderer.hpp"

namespace kasumi {

// A box standing on up = 0 (model axes: y up), each face cut into cells x cells squares, texture (0, 0) .. (1, 1) a
// face.
ModelPart box_part(glm::dvec3 lowest, glm::dvec3 highest, int cells, int material = 0);
Model box_model(double width_m, double height_m, double depth_m, int cells = 4);
// A row of thin columns, `count` of them, `spacing_m` apart, over a flat base.
Model columns_model(int count, double thickness_m, double spacing_m, double height_m);
// A ball of `steps` by 2 `steps` faces with smooth normals.
ModelPart ball_part(glm::dvec3 centre, double radius, int steps, int material = 0);
// Light of the same radiance from everywhere, no sun, no air: an object that reflects all of it is invisible.
ObjectAppearance furnace(double radiance);
// A smooth texture of soft waves, so that texel edges hide no error.
ModelTexture soft_texture(int size);
// The same as data: normals that lean up to about 30 degrees; otherwise waves between 0.3 and 0.95.
ModelTexture soft_normals(int size);
ModelTexture soft_data(int size);

// A camera that looks north, level, with its horizon at the middle row.
SceneView view_north(int width, int height, double focal_px);
// Clear air of turbidity about 3, afternoon sun from the south-west, a bright horizon that varies across the picture.
ObjectAppearance afternoon(const SceneView& view);
AirlightGrid measured_airlight(const SceneView& view, double exposure = 1.0);
// A sky that darkens upwards over a ground of soft texture.
Image<Rgb8> landscape(int width, int height);
// A box of 60 x 40 x 60 m, 3.5 km north, turned by 30 degrees: fills a good part of a 160 x 120 picture.
ReferenceScene box_scene();

// A test with a headless context, or a visible skip where there is none.
class GlesTest : public testing::Test {
 protected:
  void SetUp() override;
  const GlInfo& info() const { return context_->info(); }
  Renderer make_renderer(const RendererOptions& options = {});
  Offscreen make_target(int width, int height, int samples = 1);
  // Model, view, response, mask and layer of a scene.
  void load(Renderer& renderer, const ReferenceScene& scene);
  Renderer loaded(const ReferenceScene& scene, const RendererOptions& options = {});
  Image<Rgb8> draw(Renderer& renderer, const AirlightGrid& measured, const PictureView& frame);
  Image<Rgb8> draw_moving(Renderer& renderer, const ReferenceScene& scene, const PictureView& frame, HazeDetail detail,
                          int samples = 1);
  // PSNR over the object's pixels; both pictures are saved when it is too low.
  void expect_like(const Image<Rgb8>& picture, const ReferencePicture& reference, double least_db = 50.0);
  // What the GPU draws in each of these ways. The rays are cast only once because they take most of the time.
  void expect_same(const ReferenceScene& scene, const std::vector<RendererOptions>& ways = {{}},
                   double least_db = 50.0);

  std::unique_ptr<GlContext> context_;
};

#define ASSERT_OK(result)                                                                       \
  do {                                                                                          \
    auto&& kasumi_result = (result);                                                            \
    ASSERT_TRUE(kasumi_result.has_value()) << #result << ": " << kasumi_result.error().message; \
  } while (false)

void save_png(const Image<Rgb8>& picture, const std::filesystem::path& path);

}  // namespace kasumi

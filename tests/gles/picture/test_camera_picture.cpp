// The camera's picture without an object, in every layout that drivers deliver.
#include <random>

#include "tests/gles/picture/all_layouts.hpp"
#include "tests/gles/scenes.hpp"
#include "tests/picture_difference.hpp"

namespace kasumi {
namespace {

bool is_rgb(PixelLayout layout) {
  return layout == PixelLayout::rgb8 || layout == PixelLayout::bgr8 || layout == PixelLayout::rgba8 ||
         layout == PixelLayout::bgra8 || layout == PixelLayout::grey8;
}

// Noise in every plane, rows `gap` bytes longer than necessary.
struct NoisePicture {
  std::array<std::vector<std::uint8_t>, 3> planes;
  PictureView view;

  NoisePicture(PixelLayout layout, YuvEncoding encoding, int width, int height, std::size_t gap) {
    std::mt19937_64 random(7);
    view = {layout, encoding, width, height, {}};
    for (int i = 0; i < plane_count(layout); ++i) {
      const PlaneSize size = plane_size(layout, width, height, i);
      const std::size_t stride = size.row_bytes + gap;
      auto& bytes = planes[static_cast<std::size_t>(i)];
      bytes.resize(stride * static_cast<std::size_t>(size.rows));
      for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random() >> 56);
      view.planes[static_cast<std::size_t>(i)] = {bytes.data(), stride};
    }
  }
};

class CameraPicture : public GlesTest {};

TEST_F(CameraPicture, PassesUnchangedInEveryLayout) {
  Renderer renderer = make_renderer();
  const AirlightGrid measured = measured_airlight(view_north(64, 48, 100));
  for (const PixelLayout layout : kLayouts)
    for (const auto& [width, height] : {std::pair{64, 48}, {63, 47}, {1, 1}})
      for (const std::size_t gap : {0u, 1u, 12u}) {
        const NoisePicture noise(layout, YuvEncoding::bt601_full, width, height, gap);
        const Image<Rgb8> picture = draw(renderer, measured, noise.view);
        EXPECT_LE(difference(picture, to_rgb(noise.view)).largest, is_rgb(layout) ? 0 : 1)
            << name_of(layout) << " " << width << " x " << height << ", rows " << gap << " bytes longer";
      }
}

TEST_F(CameraPicture, FollowsEachYuvEncoding) {
  Renderer renderer = make_renderer();
  for (const auto encoding :
       {YuvEncoding::bt601_full, YuvEncoding::bt601_limited, YuvEncoding::bt709_full, YuvEncoding::bt709_limited}) {
    const NoisePicture noise(PixelLayout::nv12, encoding, 62, 46, 2);
    EXPECT_LE(difference(draw(renderer, {}, noise.view), to_rgb(noise.view)).largest, 1) << name_of(encoding);
  }
}

TEST_F(CameraPicture, PassesUnchangedWhereTheObjectIsNot) {
  ReferenceScene scene = box_scene();
  const auto reference = render_reference(scene, landscape(160, 120), turned_lattice());
  for (const bool force_rgba8 : {false, true}) {
    Renderer renderer = loaded(scene, {.force_rgba8 = force_rgba8});
    for (const PixelLayout layout : kLayouts) {
      const NoisePicture noise(layout, YuvEncoding::bt601_full, 160, 120, 4);
      const Image<Rgb8> expected = to_rgb(noise.view);
      const Image<Rgb8> cached = draw(renderer, scene.measured, noise.view);
      const Image<Rgb8> moving = draw_moving(renderer, scene, noise.view, HazeDetail::per_vertex);
      int worst = 0, object = 0;
      for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x) {
          const bool clear = reference.layer.at(x, y).a == 0.0;
          for (int c = 0; c < 3; ++c) {
            const int in_cached = std::abs(int(cached.at(x, y)[c]) - int(expected.at(x, y)[c]));
            const int in_moving = std::abs(int(moving.at(x, y)[c]) - int(expected.at(x, y)[c]));
            if (clear) worst = std::max({worst, in_cached, in_moving});
            if (!clear) object = std::max(object, in_cached);
          }
        }
      EXPECT_LE(worst, is_rgb(layout) ? 0 : 1) << name_of(layout);
      EXPECT_GT(object, 20) << name_of(layout) << ": the object is not there";
    }
  }
}

TEST_F(CameraPicture, CompositesOverEveryLayoutAlike) {
  ReferenceScene scene = box_scene();
  Renderer renderer = loaded(scene);
  for (const PixelLayout layout : kLayouts) {
    const NoisePicture noise(layout, YuvEncoding::bt709_limited, 160, 120, 4);
    expect_like(draw(renderer, scene.measured, noise.view),
                render_reference(scene, to_rgb(noise.view), turned_lattice()));
  }
}

TEST_F(CameraPicture, FillsAWindowOfAnotherShapeBetweenBlackBars) {
  Renderer renderer = make_renderer();
  const Image<Rgb8> white(40, 30, Rgb8{255, 255, 255});
  ASSERT_OK(renderer.upload(view_of(white)));
  Offscreen wide = make_target(100, 30), tall = make_target(40, 90);
  ASSERT_OK(renderer.draw_background(wide.target()));
  const auto in_wide = wide.read();
  ASSERT_OK(in_wide);
  EXPECT_EQ(in_wide->at(29, 15), Rgb8(0, 0, 0));
  EXPECT_EQ(in_wide->at(30, 15), Rgb8(255, 255, 255));
  EXPECT_EQ(in_wide->at(69, 0), Rgb8(255, 255, 255));
  EXPECT_EQ(in_wide->at(70, 15), Rgb8(0, 0, 0));
  ASSERT_OK(renderer.draw_background(tall.target()));
  const auto in_tall = tall.read();
  ASSERT_OK(in_tall);
  EXPECT_EQ(in_tall->at(20, 29), Rgb8(0, 0, 0));
  EXPECT_EQ(in_tall->at(20, 30), Rgb8(255, 255, 255));
  EXPECT_EQ(in_tall->at(20, 60), Rgb8(0, 0, 0));
}

TEST_F(CameraPicture, IsUprightInAWindowAsInAFile) {
  ReferenceScene scene = box_scene();
  Renderer renderer = loaded(scene);
  const Image<Rgb8> camera = landscape(160, 120);
  Offscreen file = make_target(160, 120), window = make_target(160, 120);
  ASSERT_OK(renderer.upload(view_of(camera)));
  DrawTarget bottom_first = window.target();
  bottom_first.top_row_first = false;
  for (const bool moving : {false, true}) {
    const auto both = [&](const DrawTarget& target) {
      return moving ? renderer.draw_moving(scene.appearance, scene.measured, target)
                    : renderer.draw(scene.measured, target);
    };
    ASSERT_OK(both(file.target()));
    ASSERT_OK(both(bottom_first));
    const auto in_file = file.read(), in_window = window.read();
    ASSERT_OK(in_file);
    ASSERT_OK(in_window);
    // The dither pattern belongs to the target's rows, and edges to its sample points: a step or a sample may differ.
    double sum = 0.0;
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 160; ++x) sum += std::abs(int(in_file->at(x, y).g) - int(in_window->at(x, 119 - y).g));
    EXPECT_LE(sum / (160 * 120), 0.4) << "steps of 255, on average";
  }
}

TEST_F(CameraPicture, RefusesInvalidPictures) {
  Renderer renderer = make_renderer();
  Offscreen target = make_target(8, 8);
  EXPECT_EQ(renderer.draw({}, target.target()).error().kind, FaultKind::bad_input);
  EXPECT_EQ(renderer.upload({}).error().kind, FaultKind::bad_input);
  PictureView no_planes{PixelLayout::nv12, YuvEncoding::bt601_full, 8, 8, {}};
  EXPECT_THAT(renderer.upload(no_planes).error().message, testing::HasSubstr("plane 1 is missing"));
  const Image<Rgb8> picture(8, 8);
  PictureView narrow = view_of(picture);
  narrow.planes[0].stride = 23;
  EXPECT_THAT(renderer.upload(narrow).error().message, testing::HasSubstr("expected at least 24"));
  ASSERT_OK(renderer.upload(view_of(picture)));
  DrawTarget nothing = target.target();
  nothing.height = 0;
  EXPECT_EQ(renderer.draw({}, nothing).error().kind, FaultKind::bad_input);
  EXPECT_EQ(Offscreen::create(info(), 0, 8).error().kind, FaultKind::bad_input);
  EXPECT_EQ(Offscreen::create(info(), 8, info().max_texture_size + 1).error().kind, FaultKind::bad_input);
}

}  // namespace
}  // namespace kasumi

// The processor's mix against the GPU's picture: within a step in the object's box, the camera's decoded pixels
// elsewhere. What a camera's processing does is held against references for both (test_camera_processing.cpp).
#include <random>

#include "tests/figures.hpp"
#include "tests/gles/picture/all_layouts.hpp"
#include "tests/gles/scenes.hpp"
#include "tests/picture_difference.hpp"

namespace kasumi {
namespace {

// A landscape in planes whose rows are `gap` bytes longer than necessary.
struct PlanesOfLandscape {
  std::array<std::vector<std::uint8_t>, 3> planes;
  PictureView view;

  PlanesOfLandscape(PixelLayout layout, YuvEncoding encoding, int width, int height, std::size_t gap) {
    const auto seen = landscape(width, height);
    view = {layout, encoding, width, height, {}};
    for (int i = 0; i < plane_count(layout); ++i) {
      const PlaneSize size = plane_size(layout, width, height, i);
      const std::size_t stride = size.row_bytes + gap;
      auto& bytes = planes[static_cast<std::size_t>(i)];
      bytes.resize(stride * static_cast<std::size_t>(size.rows), 77);
      for (std::size_t y = 0; y < static_cast<std::size_t>(size.rows); ++y)
        for (std::size_t x = 0; x < size.row_bytes; ++x) {
          const int column = static_cast<int>(x * static_cast<std::size_t>(width) / size.row_bytes);
          const int row = static_cast<int>(y) * height / size.rows;
          bytes[y * stride + x] = seen.at(column, row)[static_cast<int>(x % 3)];
        }
      view.planes[static_cast<std::size_t>(i)] = {bytes.data(), stride};
    }
  }
};

class ProcessorMixesPictures : public GlesTest {
 protected:
  static ReferenceScene scene_of(int width, int height) {
    ReferenceScene scene = box_scene();
    scene.view = view_north(width, height, scene.view.focal_px.x * width / 160.0);
    scene.measured = measured_airlight(scene.view);
    return scene;
  }
  Renderer loaded_with(const ReferenceScene& scene, Mixing mixing) {
    Renderer renderer = make_renderer({.mixing = mixing});
    load(renderer, scene);
    return renderer;
  }
  struct Both {
    Image<Rgb8> by_gpu, by_processor;
  };
  Both drawn(Renderer& gpu, Renderer& processor, const ReferenceScene& scene, const PictureView& frame,
             const SensorNoise& noise = {}) {
    Both both;
    for (auto* renderer : {&gpu, &processor}) {
      Offscreen target = make_target(frame.width, frame.height);
      EXPECT_TRUE(renderer->upload(frame));
      for (int i = 0; i < 2; ++i)  // the second time its light has settled
        EXPECT_TRUE(renderer->draw(scene.measured, target.target(), noise));
      (renderer == &gpu ? both.by_gpu : both.by_processor) = target.read().value();
    }
    return both;
  }
  // In the box; outside, the camera's own pixels.
  static void expect_alike(const Both& both, const Renderer& renderer, const PictureView& frame, int largest = 1) {
    const auto camera = to_rgb(frame);
    const PixelBox box = renderer.drawn_box();
    int outside = 0;
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x) {
        if (x >= box.left && x < box.right && y >= box.top && y < box.bottom) continue;
        ++outside;
        ASSERT_EQ(both.by_processor.at(x, y), camera.at(x, y)) << x << ", " << y;
      }
    EXPECT_GT(outside, 0);
    const auto off = difference(both.by_gpu, both.by_processor);
    EXPECT_LE(off.largest, largest);
    EXPECT_LE(off.mean, 0.1);
  }
};

TEST_F(ProcessorMixesPictures, InEverySizeStrideAndLayout) {
  for (const auto& [width, height] : {std::pair{160, 120}, {161, 119}, {97, 75}}) {
    const auto scene = scene_of(width, height);
    Renderer gpu = loaded_with(scene, Mixing::gpu), processor = loaded_with(scene, Mixing::processor);
    ASSERT_TRUE(processor.processor_mixes());
    ASSERT_FALSE(gpu.processor_mixes());
    for (const PixelLayout layout : kLayouts)
      for (const std::size_t gap : {0u, 5u}) {
        SCOPED_TRACE(fmt::format("{} {} x {}, rows {} bytes longer", name_of(layout), width, height, gap));
        const PlanesOfLandscape frame(layout, YuvEncoding::bt709_limited, width, height, gap);
        expect_alike(drawn(gpu, processor, scene, frame.view), processor, frame.view);
      }
  }
}

TEST_F(ProcessorMixesPictures, WithEachResponseNoiseAndSaturation) {
  for (const auto kind : {ResponseCurve::Kind::linear, ResponseCurve::Kind::srgb, ResponseCurve::Kind::table}) {
    auto scene = scene_of(160, 120);
    scene.response.kind = kind;
    for (auto& table : scene.response.light)
      for (int i = 0; i <= 64; ++i) table.push_back(std::pow(i / 64.0, 1.8));
    scene.measured.saturation = 1.3;
    Renderer gpu = loaded_with(scene, Mixing::gpu), processor = loaded_with(scene, Mixing::processor);
    const PlanesOfLandscape frame(PixelLayout::i420, YuvEncoding::bt601_full, 160, 120, 0);
    const SensorNoise noise{glm::dvec3{1.0 / 2000.0}, glm::dvec3{0.003}, 2};
    // Noise in the dark is steep: a step of a dark pixel's light is several of its code where the response is a power.
    expect_alike(drawn(gpu, processor, scene, frame.view, noise), processor, frame.view, 2);
  }
}

TEST_F(ProcessorMixesPictures, PixelsThatTheObjectCoversAreTheGpusOwn) {
  const auto scene = scene_of(160, 120);
  Renderer gpu = loaded_with(scene, Mixing::gpu), processor = loaded_with(scene, Mixing::processor);
  const PlanesOfLandscape frame(PixelLayout::nv12, YuvEncoding::bt601_full, 160, 120, 0);
  const auto both = drawn(gpu, processor, scene, frame.view);
  const auto layer = processor.read_layer().value();
  const PixelBox box = processor.object_box();
  int covered = 0, same = 0;
  for (int y = 0; y < layer.height(); ++y)
    for (int x = 0; x < layer.width(); ++x) {
      if (layer.at(x, y).a < 1.0F) continue;
      ++covered;
      const int px = box.left + x, py = box.top + y;
      same += both.by_gpu.at(px, py) == both.by_processor.at(px, py) ? 1 : 0;
    }
  EXPECT_GT(covered, 100);
  EXPECT_EQ(same, covered);
}

// Leaves unlike what is behind them, as dark as the mask says: where the two were alike, a leaf's place between them
// would be found by dividing small numbers, and the GPU's filter of the nodes (llvmpipe's rounds to 8 bits) would show.
TEST_F(ProcessorMixesPictures, BehindAMaskWithLeavesAndPassers) {
  auto scene = scene_of(160, 120);
  scene.mask = Image<std::uint8_t>(160, 120, 255);
  auto seen = landscape(160, 120);
  std::mt19937 random(3);
  for (int y = 60; y < 90; ++y)
    for (int x = 60; x < 110; ++x) {
      const int free = x < 70 ? 0 : x < 100 ? 64 * static_cast<int>(1 + random() % 3) : 255;
      scene.mask.at(x, y) = static_cast<std::uint8_t>(free);
      for (int c = 0; c < 3; ++c)
        seen.at(x, y)[c] =
            static_cast<std::uint8_t>((free * seen.at(x, y)[c] + (255 - free) * Rgb8(30, 45, 20)[c]) / 255);
    }
  Renderer gpu = loaded_with(scene, Mixing::gpu), processor = loaded_with(scene, Mixing::processor);
  ASSERT_TRUE(processor.has_matte());
  expect_alike(drawn(gpu, processor, scene, view_of(seen)), processor, view_of(seen), 3);

  InFront passer{75, 40, Image<glm::u8vec4>(20, 30, glm::u8vec4{90, 80, 70, 255})};
  for (int y = 1; y < 29; ++y)
    for (int x = 1; x < 19; ++x) passer.pixels.at(x, y).a = static_cast<std::uint8_t>(x * 13);
  for (auto* renderer : {&gpu, &processor}) ASSERT_OK(renderer->set_in_front(passer));
  expect_alike(drawn(gpu, processor, scene, view_of(seen)), processor, view_of(seen), 3);
}

// On a target of the picture's size, on one with bars, and where a visitor wipes: each pixel as it was mixed, nothing
// beside it.
TEST_F(ProcessorMixesPictures, WhatIsShownIsWhatWasMixed) {
  const ReferenceScene scene = scene_of(160, 120);
  const PlanesOfLandscape frame(PixelLayout::i420, YuvEncoding::bt601_full, 160, 120, 0);
  Renderer renderer = loaded_with(scene, Mixing::processor);
  ASSERT_TRUE(renderer.upload(frame.view));
  const auto mixed = renderer.mix(scene.measured);
  ASSERT_TRUE(mixed) << mixed.error().message;
  const Image<glm::u8vec4> whole = **mixed;
  const auto camera = to_rgb(frame.view);
  for (const double bare : {0.0, 0.25})
    for (const auto& [width, height] : {std::pair(160, 120), {200, 120}, {160, 151}}) {
      renderer.set_bare(bare);
      Offscreen target = make_target(width, height);
      ASSERT_TRUE(renderer.draw(scene.measured, target.target()));
      const auto seen = target.read().value();
      const int left = (width - 160) / 2, top = (height - 120) / 2;
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const bool inside = x >= left && x < left + 160 && y >= top && y < top + 120;
          const Rgb8 shown = !inside                         ? Rgb8(0)
                             : x < std::lround(bare * width) ? camera.at(x - left, y - top)
                                                             : Rgb8(whole.at(x - left, y - top));
          ASSERT_EQ(seen.at(x, y), shown) << bare << ": " << x << ", " << y << " of " << width << " x " << height;
        }
    }
}

TEST_F(ProcessorMixesPictures, AfterwardsTheGpuStillDrawsWhatIsItsOwn) {
  const auto scene = scene_of(160, 120);
  Renderer gpu = loaded_with(scene, Mixing::gpu), processor = loaded_with(scene, Mixing::processor);
  const PlanesOfLandscape frame(PixelLayout::yuyv, YuvEncoding::bt601_full, 160, 120, 0);
  const PixelBox box = processor.object_box();
  std::vector<Image<Rgb8>> planes;
  for (auto* renderer : {&gpu, &processor}) {
    Offscreen target = make_target(box.right - box.left, box.bottom - box.top);
    ASSERT_OK(renderer->upload(frame.view));
    ASSERT_OK(renderer->draw_for_plane(scene.measured, target.target()));
    planes.push_back(target.read().value());
  }
  EXPECT_EQ(planes[0].elements(), planes[1].elements());
  EXPECT_EQ(processor.frames().uploaded, 1u);
}

}  // namespace
}  // namespace kasumi

// The object's pixels go the way of the camera's own: against libjpeg, which decodes what it encoded of the very
// composite, and against sharpening by its formula.
#include <array>
#include <cmath>

#include "capture/codec/encode.hpp"
#include "capture/codec/jpeg.hpp"
#include "tests/figures.hpp"
#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

constexpr int kWide = 168, kTall = 120;  // no multiple of 16 either way

constexpr std::array<std::pair<Mixing, const char*>, 2> kMixers{
    {{Mixing::gpu, "the GPU"}, {Mixing::processor, "the processor"}}};

class CameraProcessingOfObject : public GlesTest {
 protected:
  static ReferenceScene scene() {
    ReferenceScene made = box_scene();
    made.view = view_north(kWide, kTall, made.view.focal_px.x);
    made.measured = measured_airlight(made.view);
    return made;
  }
  static JpegPlanes through_jpeg(const Image<Rgb8>& picture, int quality, ChromaSubsampling subsampling) {
    const auto bytes = encode_jpeg(picture, quality, subsampling).value();
    return decode_jpeg(bytes, picture.width(), picture.height()).value();
  }
  Image<Rgb8> composite(const JpegPlanes& camera, const ObjectDetail& detail, const RendererOptions& options = {}) {
    Renderer renderer = make_renderer(options);
    EXPECT_TRUE(renderer.set_detail(detail));
    load(renderer, scene());
    covered_ = renderer.read_layer().value();
    box_ = renderer.object_box();
    return drawn(renderer, camera);
  }
  Image<Rgb8> drawn(Renderer& renderer, const JpegPlanes& camera, const SensorNoise& noise = {}) {
    Offscreen target = make_target(kWide, kTall);
    EXPECT_TRUE(renderer.upload(camera.view, std::make_shared<const JpegSteps>(camera.steps)));
    EXPECT_TRUE(renderer.draw(scene().measured, target.target(), noise));
    return target.read().value();
  }
  float coverage(int x, int y) const {
    const bool inside = x >= box_.left && x < box_.right && y >= box_.top && y < box_.bottom;
    return inside ? covered_.at(x - box_.left, y - box_.top).a : 0.0F;
  }
  struct Off {
    double mean = 0.0;
    int worst = 0, pixels = 0;
  };
  // Over the object's pixels and channels, in steps.
  Off between(const Image<Rgb8>& one, const Image<Rgb8>& other) const {
    Off off;
    for (int y = 0; y < kTall; ++y)
      for (int x = 0; x < kWide; ++x) {
        if (coverage(x, y) <= 0.0F) continue;
        ++off.pixels;
        for (int c = 0; c < 3; ++c) {
          const int step = std::abs(one.at(x, y)[c] - other.at(x, y)[c]);
          off.mean += step / 3.0;
          off.worst = std::max(off.worst, step);
        }
      }
    off.mean /= std::max(off.pixels, 1);
    return off;
  }
  // `own`: drawn without processing, for the GPU's conversion to RGB may be a step off the CPU's. `rounded`: how many
  // values in a thousand two programs that convert may round apart.
  void expect_untouched_elsewhere(const Image<Rgb8>& picture, const Image<Rgb8>& own, int rounded = 0) const {
    int seen = 0, apart = 0;
    for (int y = 0; y < kTall; ++y)
      for (int x = 0; x < kWide; ++x) {
        if (coverage(x, y) > 0.0F) continue;
        ++seen;
        for (int c = 0; c < 3; ++c) {
          const int off = std::abs(picture.at(x, y)[c] - own.at(x, y)[c]);
          ASSERT_LE(off, rounded > 0 ? 1 : 0) << x << ", " << y;
          apart += off;
        }
      }
    EXPECT_GT(seen, 1000);
    EXPECT_LE(1000 * apart, 3 * seen * rounded);
  }

  Image<glm::vec4> covered_;
  PixelBox box_;
};

TEST_F(CameraProcessingOfObject, BlocksAreRoundedAsLibjpegRoundsThem) {
  for (const auto& [mixing, who] : kMixers)
    for (const double sharpening : {0.0, 0.8})
      for (const auto& [subsampling, name] : {std::pair{ChromaSubsampling::s420, "4:2:0"},
                                              {ChromaSubsampling::s422, "4:2:2"},
                                              {ChromaSubsampling::s444, "4:4:4"}})
        for (const int quality : {95, 85, 60, 30}) {
          const RendererOptions options{.mixing = mixing};
          const auto camera = through_jpeg(landscape(kWide, kTall), quality, subsampling);
          const auto plain = composite(camera, {.point_spread_px = 0.6, .sharpening = sharpening}, options);
          const auto expected = to_rgb(through_jpeg(plain, quality, subsampling).view);
          const auto blocks =
              composite(camera, {.point_spread_px = 0.6, .sharpening = sharpening, .jpeg_blocks = true}, options);
          const auto without = between(plain, expected), with = between(blocks, expected);
          fmt::print(
              "{}: JPEG {} {}, sharpened by {}: libjpeg's blocks missed by {:.2f} of 255 without, by {:.2f} (at worst "
              "{}) with\n",
              who, quality, name, sharpening, without.mean, with.mean, with.worst);
          EXPECT_GT(with.pixels, 1000);
          EXPECT_LE(with.mean, 0.35) << quality << " " << name;
          EXPECT_LE(with.mean, 0.5 * without.mean) << quality << " " << name;
          expect_untouched_elsewhere(blocks, plain);
        }
}

TEST_F(CameraProcessingOfObject, TheStepsAreThoseOfEachPicture) {
  Renderer renderer = make_renderer();
  ASSERT_OK(renderer.set_detail({.jpeg_blocks = true}));
  load(renderer, scene());
  covered_ = renderer.read_layer().value();
  box_ = renderer.object_box();
  for (const int quality : {90, 40, 90}) {
    const auto camera = through_jpeg(landscape(kWide, kTall), quality, ChromaSubsampling::s420);
    const auto changing = drawn(renderer, camera);
    const auto box = box_;
    EXPECT_EQ(changing.elements(), composite(camera, {.jpeg_blocks = true}).elements()) << quality;
    EXPECT_EQ(box_, box);
  }
}

TEST_F(CameraProcessingOfObject, APictureThatIsNoJpegHasNoBlocks) {
  const auto camera = landscape(kWide, kTall);
  Renderer plain = make_renderer(), asked = make_renderer();
  ASSERT_OK(asked.set_detail({.jpeg_blocks = true}));
  for (Renderer* renderer : {&plain, &asked}) load(*renderer, scene());
  EXPECT_EQ(draw(plain, scene().measured, view_of(camera)).elements(),
            draw(asked, scene().measured, view_of(camera)).elements());
}

// Of 255 in the mean: rectangles cut otherwise are interpolated with other roundings, and some coefficients that lie
// half-way between two steps fall to the other.
constexpr double kOtherRounding = 0.1;

// Blocks in which only the object is to be seen are kept, for each pattern of noise, while the picture around them moves.
TEST_F(CameraProcessingOfObject, PicturesInARowAreThoseProcessedAlone) {
  const ObjectDetail detail{.point_spread_px = 0.6, .sharpening = 0.8, .jpeg_blocks = true};
  const SensorNoise noise{glm::dvec3{1.0 / 2000.0}, glm::dvec3{0.003}};
  const auto sky = landscape(kWide, kTall);
  const auto picture_at = [&](int number) {
    Image<Rgb8> moved(kWide, kTall);
    for (int y = 0; y < kTall; ++y)
      for (int x = 0; x < kWide; ++x) moved.at(x, y) = sky.at((x + 3 * number) % kWide, y);
    return through_jpeg(moved, 85, ChromaSubsampling::s420);
  };
  const auto ready = [&] {
    Renderer renderer = make_renderer();
    EXPECT_TRUE(renderer.set_detail(detail));
    load(renderer, scene());
    return renderer;
  };
  for (const bool noisy : {false, true}) {
    Renderer in_a_row = ready();
    for (std::uint32_t number = 0; number < 2 * kNoisePatterns; ++number) {
      const auto camera = picture_at(static_cast<int>(number));
      SensorNoise own = noisy ? noise : SensorNoise{};
      own.pattern = number;
      Renderer alone = ready();
      covered_ = alone.read_layer().value();
      box_ = alone.object_box();
      const auto off = between(drawn(in_a_row, camera, own), drawn(alone, camera, own));
      EXPECT_LE(off.mean, kOtherRounding) << (noisy ? "with noise" : "without") << ", picture " << number;
      if (number == 0) {
        EXPECT_EQ(off.worst, 0);
      }
    }
  }
}

TEST_F(CameraProcessingOfObject, KeptBlocksGoWithTheLayerAndBehindWhoPasses) {
  const auto camera = through_jpeg(landscape(kWide, kTall), 85, ChromaSubsampling::s420);
  ReferenceScene other = scene();
  other.appearance.light.sun_irradiance *= 0.5;
  Renderer renderer = make_renderer(), anew = make_renderer();
  for (Renderer* each : {&renderer, &anew}) ASSERT_OK(each->set_detail({.sharpening = 0.8, .jpeg_blocks = true}));
  load(renderer, scene());
  load(anew, other);
  covered_ = renderer.read_layer().value();
  box_ = renderer.object_box();
  for (int picture = 0; picture < 3; ++picture) drawn(renderer, camera);
  const auto before = drawn(renderer, camera);
  const PixelBox box = renderer.drawn_box();
  const glm::ivec2 middle{(box.left + box.right) / 2, (box.top + box.bottom) / 2};
  InFront passer{.left = middle.x - 12, .top = middle.y - 12, .pixels = {24, 24, glm::u8vec4{90, 90, 90, 255}}};
  for (int y = 2; y < 22; ++y)
    for (int x = 2; x < 22; ++x) passer.pixels.at(x, y).a = 0;
  ASSERT_OK(renderer.set_in_front(passer));
  const auto with = drawn(renderer, camera);
  const auto seen = with.at(middle.x, middle.y), own = to_rgb(camera.view).at(middle.x, middle.y);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], own[c], 6);
  EXPECT_NE(before.at(middle.x, middle.y), seen);
  ASSERT_OK(renderer.set_in_front({}));
  EXPECT_LE(between(drawn(renderer, camera), before).mean, kOtherRounding);
  ASSERT_OK(renderer.redraw_layer(other.appearance));
  EXPECT_LE(between(drawn(renderer, camera), drawn(anew, camera)).mean, kOtherRounding);
  EXPECT_GE(between(drawn(renderer, camera), before).mean, 10.0 * kOtherRounding);
}

TEST_F(CameraProcessingOfObject, WhatIsSeenOfTheObjectIsSharpenedAndTheRestNotTwice) {
  constexpr double kAmount = 0.9;
  // Detail of its own, which must not show through the object.
  auto land = landscape(kWide, kTall);
  for (int y = 0; y < kTall; ++y)
    for (int x = 0; x < kWide; ++x)
      for (int c = 0; c < 3; ++c)
        land.at(x, y)[c] =
            static_cast<std::uint8_t>(std::clamp(land.at(x, y)[c] + ((x + y) % 2 == 0 ? 25 : -25), 0, 255));
  const auto camera = through_jpeg(land, 100, ChromaSubsampling::s444);
  const auto own = to_rgb(camera.view);
  for (const auto& [mixing, who] : kMixers) {
    const auto plain = composite(camera, {.point_spread_px = 0.6}, {.mixing = mixing});
    const auto sharp = composite(camera, {.point_spread_px = 0.6, .sharpening = kAmount}, {.mixing = mixing});
    const auto luma_of = [](const Image<Rgb8>& picture, int u, int v) {
      return glm::dot(glm::dvec3(0.299, 0.587, 0.114),
                      glm::dvec3(picture.at(std::clamp(u, 0, kWide - 1), std::clamp(v, 0, kTall - 1))));
    };
    const auto detail = [&](const Image<Rgb8>& picture, int x, int y) {
      double around = 0.0;
      for (int v = -1; v <= 1; ++v)
        for (int u = -1; u <= 1; ++u)
          around += (2 - std::abs(u)) * (2 - std::abs(v)) / 16.0 * luma_of(picture, x + u, y + v);
      return luma_of(picture, x, y) - around;
    };
    // Beyond the pixel and its four neighbours by no more than at a straight edge.
    const auto bounded = [&](double more, int x, int y) {
      const double here = luma_of(plain, x, y);
      const auto [least, most] = std::minmax({here, luma_of(plain, x - 1, y), luma_of(plain, x + 1, y),
                                              luma_of(plain, x, y - 1), luma_of(plain, x, y + 1)});
      const double over = 0.25 * kAmount * (most - least);
      return std::clamp(more, least - over - here, most + over - here);
    };
    double worst = 0.0, most = 0.0;
    for (int y = 0; y < kTall; ++y)
      for (int x = 0; x < kWide; ++x) {
        if (coverage(x, y) <= 0.0F) continue;
        const double more =
            bounded(kAmount * (detail(plain, x, y) - (1.0 - double{coverage(x, y)}) * detail(own, x, y)), x, y);
        most = std::max(most, std::abs(more));
        for (int c = 0; c < 3; ++c)
          worst = std::max(worst, std::abs(std::clamp(plain.at(x, y)[c] + more, 0.0, 255.0) - sharp.at(x, y)[c]));
      }
    fmt::print("{}: sharpened by {}: {:.2f} of 255 off at worst\n", who, kAmount, worst);
    // The processor rounds once, and the object's share of a pixel.
    EXPECT_LE(worst, mixing == Mixing::gpu ? 1.6 : 0.75) << "of 255: rounding";
    EXPECT_GT(most, 8.0) << "an edge must be seen";
    expect_untouched_elsewhere(sharp, plain);
  }
}

TEST_F(CameraProcessingOfObject, OnAPlaneOfTheDisplaysItIsTheSame) {
  const auto camera = through_jpeg(landscape(kWide, kTall), 70, ChromaSubsampling::s420);
  Renderer renderer = make_renderer();
  ASSERT_OK(renderer.set_detail({.point_spread_px = 0.6, .sharpening = 0.9, .jpeg_blocks = true}));
  load(renderer, scene());
  covered_ = renderer.read_layer().value();
  box_ = renderer.object_box();
  drawn(renderer, camera);  // afterwards the same blocks are kept for both
  const auto whole = drawn(renderer, camera);
  Offscreen target = make_target(box_.right - box_.left, box_.bottom - box_.top);
  ASSERT_OK(renderer.draw_for_plane(scene().measured, target.target()));
  const auto plane = target.read().value();
  int seen = 0;
  for (int y = 0; y < plane.height(); ++y)
    for (int x = 0; x < plane.width(); ++x) {
      if (coverage(box_.left + x, box_.top + y) < 1.0F) continue;
      ++seen;
      ASSERT_EQ(plane.at(x, y), whole.at(box_.left + x, box_.top + y)) << x << ", " << y;
    }
  EXPECT_GT(seen, 1000);
}

// Dark leaves before the middle, less and less of them; the mask leaves their pixels open.
TEST_F(CameraProcessingOfObject, WhatLeavesCoverIsFoundAlikeBeforeAndAfterIt) {
  ReferenceScene leafy = scene();
  leafy.mask = Image<std::uint8_t>(kWide, kTall, 255);
  auto land = landscape(kWide, kTall);
  for (int y = 0; y < kTall; ++y)
    for (int x = 0; x < kWide; ++x) {
      const int share = std::clamp(255 * (x - 64) / 40, 0, 255);  // free
      leafy.mask.at(x, y) = static_cast<std::uint8_t>(share);
      if ((x / 3 * 97 + y / 3 * 61) % 255 >= share) land.at(x, y) = {30, 45, 20};
    }
  const auto camera = through_jpeg(land, 80, ChromaSubsampling::s420);
  ReferenceScene tabled = leafy;  // no unit is left over beside table, noise and three planes
  tabled.response.kind = ResponseCurve::Kind::table;
  for (auto& channel : tabled.response.light)
    for (int i = 0; i <= 64; ++i) channel.push_back(std::pow(i / 64.0, 2.2));
  const SensorNoise hardly{glm::dvec3{0.0}, glm::dvec3{1e-7}, 1};
  struct Case {
    const char* what;
    const ReferenceScene& scene;
    RendererOptions options;
    SensorNoise noise;  // of the picture without processing, to take the same units
  };
  const RendererOptions promised{.force_promised_units = true};
  for (const Case& a_case : {Case{"as the driver is", leafy, {}, {}}, Case{"eight texture units", leafy, promised, {}},
                             Case{"eight texture units and a table", tabled, promised, hardly}}) {
    const auto with = [&](const ObjectDetail& detail, const SensorNoise& noise) {
      Renderer renderer = make_renderer(a_case.options);
      EXPECT_TRUE(renderer.set_detail(detail));
      load(renderer, a_case.scene);
      EXPECT_TRUE(renderer.has_matte());
      covered_ = renderer.read_layer().value();
      box_ = renderer.object_box();
      return drawn(renderer, camera, noise);
    };
    const auto plain = with({.point_spread_px = 0.6}, a_case.noise);
    const auto blocks = with({.point_spread_px = 0.6, .jpeg_blocks = true}, {});
    const auto expected = to_rgb(through_jpeg(plain, 80, ChromaSubsampling::s420).view);
    Renderer renderer = make_renderer();
    const auto own = drawn(renderer, camera);
    int open = 0, changed = 0;
    double missed = 0.0, without = 0.0;
    const auto apart = [](const Rgb8& one, const Rgb8& other) {
      double steps = 0.0;
      for (int c = 0; c < 3; ++c) steps += std::abs(one[c] - other[c]) / 3.0;
      return steps;
    };
    for (int y = 0; y < kTall; ++y)
      for (int x = 0; x < kWide; ++x) {
        const auto mask = leafy.mask.at(x, y);
        if (coverage(x, y) <= 0.0F || mask == 0 || mask == 255) continue;
        ++open;
        if (plain.at(x, y) == own.at(x, y)) continue;
        ++changed;
        missed += apart(blocks.at(x, y), expected.at(x, y));
        without += apart(plain.at(x, y), expected.at(x, y));
      }
    missed /= std::max(changed, 1);
    without /= std::max(changed, 1);
    fmt::print(
        "{}: the building in {} of {} open pixels; libjpeg's blocks missed by {:.2f} of 255 without, by {:.2f}\n",
        a_case.what, changed, open, without, missed);
    EXPECT_GT(open, 1000) << a_case.what;
    EXPECT_GT(changed, open / 4) << a_case.what;
    EXPECT_LE(missed, 0.3 * without) << a_case.what;
    expect_untouched_elsewhere(blocks, own, 5);
  }
}

TEST_F(CameraProcessingOfObject, ImpossibleSharpeningIsRefused) {
  Renderer renderer = make_renderer();
  for (const double amount : {-0.1, 3.1, std::nan("")}) EXPECT_FALSE(renderer.set_detail({.sharpening = amount}));
}

}  // namespace
}  // namespace kasumi

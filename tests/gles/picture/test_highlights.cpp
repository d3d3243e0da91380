// A white wall in the sun on cameras whose highlights roll off: it is as bright as such a camera shows it, and white
// only where the camera clips.
#include <cmath>
#include <random>

#include "capture/codec/encode.hpp"
#include "capture/codec/jpeg.hpp"
#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

constexpr int kWallWide = 192, kWallTall = 128;

class Highlights : public GlesTest {
 protected:
  // White, without air, over the whole picture: its light is the measured airlight's.
  static ReferenceScene wall() {
    ReferenceScene scene;
    scene.view = view_north(kWallWide, kWallTall, 6000);
    scene.model = box_model(4000, 4000, 0.01, 1);
    scene.model.materials[0].base_colour = {1.0f, 1.0f, 1.0f, 1.0f};
    scene.model_to_world = model_to_world({0, 3500, -2000, {}, 1.0});
    scene.appearance = furnace(1.0);
    scene.measured = measured_airlight(scene.view);
    return scene;
  }
};

// Values of light as cameras of this kind give them: straight up to `knee`, beyond it ever flatter (Reinhard's curve),
// 1 at 1; encoded by a power. The tables are the inverse, as calibrate response finds it.
struct Shoulder {
  const char* name;
  double knee, power;
  double code(double light) const {
    const double l = std::min(light, 1.0), rest = 1.0 - knee;
    if (l <= knee) return std::pow(0.72 * l / knee, power);
    const double over = (l - knee) / rest, steep = 0.72 / knee * rest / 0.28;  // as steep as below the knee
    return std::pow(0.72 + 0.28 * steep * over / (1.0 + (steep - 1.0) * over), power);
  }
  ResponseCurve curve() const {
    ResponseCurve curve;
    curve.kind = ResponseCurve::Kind::table;
    std::vector<double> light;
    for (int i = 0; i < 1024; ++i) {
      double low = 0.0, high = 1.0;
      for (int k = 0; k < 60; ++k) (code(0.5 * (low + high)) < i / 1023.0 ? low : high) = 0.5 * (low + high);
      light.push_back(i == 1023 ? 1.0 : 0.5 * (low + high));
    }
    light[0] = 0.0;
    curve.light.fill(light);
    return curve;
  }
};

struct Seen {
  double mean = 0.0, white = 0.0;  // green, of 255; share of pixels at 255
};

Seen seen_in(const Image<Rgb8>& picture) {
  Seen seen;
  for (const Rgb8& pixel : picture.elements()) {
    seen.mean += pixel.g;
    seen.white += pixel.g == 255 ? 1.0 : 0.0;
  }
  seen.mean /= static_cast<double>(picture.elements().size());
  seen.white /= static_cast<double>(picture.elements().size());
  return seen;
}

// The same light on that camera's sensor, with noise of that variance per light.
Seen seen_by_camera(const Shoulder& shoulder, double light, double shot) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  constexpr int kPixels = 40000;
  Seen seen;
  for (int i = 0; i < kPixels; ++i) {
    const double code = shoulder.code(std::max(light + std::sqrt(shot * light) * normal(random), 0.0));
    const double value = std::round(255.0 * code);
    seen.mean += value / kPixels;
    seen.white += value >= 255.0 ? 1.0 / kPixels : 0.0;
  }
  return seen;
}

TEST_F(Highlights, RollOffAsTheCamerasDo) {
  const auto bytes = encode_jpeg(landscape(kWallWide, kWallTall), 92, ChromaSubsampling::s420).value();
  const auto camera = decode_jpeg(bytes, kWallWide, kWallTall).value();
  const auto steps = std::make_shared<const JpegSteps>(camera.steps);
  for (const auto& shoulder :
       {Shoulder{"soft shoulder", 0.18, 0.6}, {"late shoulder", 0.5, 0.45}, {"hard knee", 0.7, 0.5}})
    for (const ObjectDetail& detail :
         {ObjectDetail{}, {.point_spread_px = 0.6, .sharpening = 0.8, .jpeg_blocks = true}})
      for (const double shot : {0.0, 1e-4}) {
        auto scene = wall();
        scene.response = shoulder.curve();
        Renderer renderer = make_renderer();
        ASSERT_OK(renderer.set_detail(detail));
        load(renderer, scene);
        ASSERT_OK(renderer.upload(camera.view, steps));
        Offscreen target = make_target(kWallWide, kWallTall);
        double before = 0.0;
        for (const double light : {0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.985, 1.0, 1.3}) {
          scene.measured.light.fill(glm::dvec3{light});
          ASSERT_OK(renderer.draw(scene.measured, target.target(), {glm::dvec3{shot}, glm::dvec3{0.0}, 5}));
          const Seen ours = seen_in(target.read().value()), theirs = seen_by_camera(shoulder, light, shot);
          const auto words = fmt::format("{}, light {}, shot {}, {}", shoulder.name, light, shot,
                                         detail.jpeg_blocks ? "processed" : "plain");
          EXPECT_NEAR(ours.mean, theirs.mean, detail.jpeg_blocks ? 1.1 : 0.55) << words;
          EXPECT_GE(ours.mean, before - 0.2) << words;
          if (shot == 0.0 && 255.0 * shoulder.code(light) < 253.9) {
            EXPECT_EQ(ours.white, 0.0) << words;
          }
          if (!detail.jpeg_blocks && shot > 0.0) {
            EXPECT_LE(ours.white, theirs.white + 0.02) << words;
          }
          before = ours.mean;
        }
      }
}

}  // namespace
}  // namespace kasumi

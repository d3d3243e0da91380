// Pixels that the object covers are kept from picture to picture: the same as drawn anew, and only as long as they are.
#include <cmath>

#include "tests/gles/scenes.hpp"
#include "tests/picture_difference.hpp"

namespace kasumi {
namespace {

class ObjectPixelsKept : public GlesTest {
 protected:
  ObjectPixelsKept() : scene_(box_scene()), camera_(landscape(scene_.view.width, scene_.view.height)) {}

  Image<Rgb8> drawn(Renderer& renderer, const DrawTarget& target, const AirlightGrid& measured,
                    const SensorNoise& noise = {}) {
    EXPECT_TRUE(renderer.upload(view_of(camera_)));
    EXPECT_TRUE(renderer.draw(measured, target, noise));
    return read_back(target).value();
  }
  // By a renderer that has kept nothing.
  Image<Rgb8> drawn_anew(const DrawTarget& target, const AirlightGrid& measured, const SensorNoise& noise = {}) {
    Renderer renderer = loaded(scene_);
    return drawn(renderer, target, measured, noise);
  }
  AirlightGrid brighter(double factor) const {
    AirlightGrid grid = scene_.measured;
    for (auto& light : grid.light) light *= factor;
    return grid;
  }

  ReferenceScene scene_;
  Image<Rgb8> camera_;
};

TEST_F(ObjectPixelsKept, AreThoseDrawnAnewOnEveryTarget) {
  Offscreen same = make_target(scene_.view.width, scene_.view.height);
  Offscreen larger = make_target(397, 241);  // bars beside the picture, and pixels between the picture's
  DrawTarget window = larger.target();
  window.top_row_first = false;
  const SensorNoise noise{glm::dvec3{1.0 / 900.0}, glm::dvec3{0.01}, 2};
  Renderer renderer = loaded(scene_);
  for (const DrawTarget& target : {same.target(), larger.target(), window, same.target()})
    for (const SensorNoise& with : {SensorNoise{}, noise}) {
      const auto anew = drawn_anew(target, scene_.measured, with);
      for (int picture = 0; picture < 4; ++picture) {
        const auto seen = drawn(renderer, target, scene_.measured, with);
        const bool same_size = target.width == scene_.view.width;
        EXPECT_LE(difference(seen, anew).largest, same_size ? 0 : 1)
            << target.width << (target.top_row_first ? "" : " upside down") << ", picture " << picture;
        EXPECT_LE(difference(seen, anew).changed, 0.01 * static_cast<double>(seen.elements().size()));
      }
    }
}

TEST_F(ObjectPixelsKept, AreLookedUpWhileNobodyCouldSeeTheDifference) {
  Offscreen target = make_target(scene_.view.width, scene_.view.height);
  Renderer renderer = loaded(scene_);
  for (int picture = 0; picture < 2; ++picture) drawn(renderer, target.target(), scene_.measured);
  const auto kept = drawn(renderer, target.target(), scene_.measured);
  const auto hardly_brighter = drawn(renderer, target.target(), brighter(1.003));
  const auto anew = drawn_anew(target.target(), brighter(1.003));
  const auto layer = renderer.read_layer().value();
  const PixelBox box = renderer.object_box();
  int covered = 0, kept_ones = 0, other = 0;
  for (int y = 0; y < layer.height(); ++y)
    for (int x = 0; x < layer.width(); ++x) {
      if (layer.at(x, y).a < 1.0f) continue;
      ++covered;
      const auto before = kept.at(box.left + x, box.top + y);
      kept_ones += hardly_brighter.at(box.left + x, box.top + y) == before ? 1 : 0;
      other += anew.at(box.left + x, box.top + y) != before ? 1 : 0;
    }
  EXPECT_GE(kept_ones, covered * 9 / 10);  // what is cut off with an edge is drawn with it
  EXPECT_GE(other, covered * 2 / 10) << "the difference is not even seen when drawn anew";
  EXPECT_GT(covered, 1000);
}

TEST_F(ObjectPixelsKept, FollowALightThatDriftsSlowly) {
  Offscreen target = make_target(scene_.view.width, scene_.view.height);
  Renderer renderer = loaded(scene_);
  const SensorNoise none;
  for (int picture = 0; picture < 60; ++picture) {
    const AirlightGrid now = brighter(1.0 - 0.001 * picture);
    const auto seen = drawn(renderer, target.target(), now, none);
    if (picture % 6 != 5) continue;
    EXPECT_LE(difference(seen, drawn_anew(target.target(), now)).largest, 1) << picture;
  }
}

TEST_F(ObjectPixelsKept, AreDrawnAnewWithOtherLightNoiseResponseAndLayer) {
  Offscreen target = make_target(scene_.view.width, scene_.view.height);
  const SensorNoise noise{glm::dvec3{1.0 / 900.0}, glm::dvec3{0.01}, 2};
  Renderer renderer = loaded(scene_);
  const auto keep = [&] {
    for (int picture = 0; picture < 3; ++picture) drawn(renderer, target.target(), scene_.measured, noise);
  };
  keep();
  EXPECT_EQ(drawn(renderer, target.target(), brighter(0.8), noise).elements(),
            drawn_anew(target.target(), brighter(0.8), noise).elements());
  keep();
  const SensorNoise stronger{glm::dvec3{1.0 / 200.0}, glm::dvec3{0.01}, 2};
  EXPECT_EQ(drawn(renderer, target.target(), scene_.measured, stronger).elements(),
            drawn_anew(target.target(), scene_.measured, stronger).elements());
  keep();
  scene_.response.kind = ResponseCurve::Kind::linear;
  ASSERT_OK(renderer.set_response(scene_.response));
  EXPECT_EQ(drawn(renderer, target.target(), scene_.measured, noise).elements(),
            drawn_anew(target.target(), scene_.measured, noise).elements());
  keep();
  scene_.appearance.light.sun_irradiance *= 0.5;
  ASSERT_OK(renderer.redraw_layer(scene_.appearance));
  EXPECT_EQ(drawn(renderer, target.target(), scene_.measured, noise).elements(),
            drawn_anew(target.target(), scene_.measured, noise).elements());
}

TEST_F(ObjectPixelsKept, StandBehindWhoPassesAndComeBackAfterwards) {
  Offscreen target = make_target(scene_.view.width, scene_.view.height);
  Renderer renderer = loaded(scene_);
  for (int picture = 0; picture < 2; ++picture) drawn(renderer, target.target(), scene_.measured);
  const auto before = drawn(renderer, target.target(), scene_.measured);
  InFront passer;
  const PixelBox box = renderer.drawn_box();
  passer.left = (box.left + box.right) / 2 - 8, passer.top = (box.top + box.bottom) / 2 - 8;
  passer.pixels = Image<glm::u8vec4>(16, 16, glm::u8vec4{90, 90, 90, 255});
  for (int y = 4; y < 12; ++y)
    for (int x = 4; x < 12; ++x) passer.pixels.at(x, y).a = 0;
  ASSERT_OK(renderer.set_in_front(passer));
  const auto with = drawn(renderer, target.target(), scene_.measured);
  EXPECT_EQ(with.at(passer.left + 8, passer.top + 8), camera_.at(passer.left + 8, passer.top + 8));
  ASSERT_OK(renderer.set_in_front({}));
  EXPECT_EQ(drawn(renderer, target.target(), scene_.measured).elements(), before.elements());
}

}  // namespace
}  // namespace kasumi

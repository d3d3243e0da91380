// Pictures of skies with and without the sun as cheap fisheyes take them: a lens that spreads light with wide skirts,
// flare and ghosts, clipped aureoles, unknown tone curves, JPEG. Where the sun is in them is known.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "tests/estimator/turbidity/sky_photographs.hpp"

namespace kasumi::test {

// Which skies, lenses and seeds: nothing of the second was looked at while the first was worked with.
enum class SunSet { development, held_out };

enum class SunScene {
  clear,          // no cloud
  thin_clouds,    // a veil before the sun, which shines through
  broken_clouds,  // clouds around the sun, it shines between them
  hidden,         // behind a thick cloud or something on the ground
  overcast,
  dusk,  // below the horizon
};
constexpr std::array kSunScenes{SunScene::clear,  SunScene::thin_clouds, SunScene::broken_clouds,
                                SunScene::hidden, SunScene::overcast,    SunScene::dusk};
const char* name_of(SunScene scene);

struct SunPicture {
  Camera camera;  // as the estimator believes it to be: its lens may be of another projection
  Image<Rgb8> pixels;
  glm::dvec2 sun_px{};
  bool visible = false;          // more than a tenth of the beam arrives
  Direction sun{0.0, 0.0, 1.0};  // where the believed camera sees it
  std::string remark;            // what is special about the picture
};

// Skies to draw from, made once.
class SunWorld {
 public:
  explicit SunWorld(SunSet set);
  SunPicture draw(SunScene scene, std::uint64_t seed) const;

 private:
  CloudlessSky sky_for(double elevation_deg, std::uint64_t seed) const;
  SunSet set_;
  std::vector<CloudlessSky> tabulated_;
};

}  // namespace kasumi::test

// One realistic lens of every model, with the size of its pictures.
#pragma once

#include <string>
#include <vector>

#include "calib/lens/lens.hpp"

namespace kasumi {

struct SampleLens {
  std::string what;
  LensPtr lens;
  int width;
  int height;
};

inline ScaramuzzaParameters sample_scaramuzza() {
  return {{-551.7655, 0.0, 8.372454e-4, -6.474789e-7, 1.235631e-9}, {505.48, 381.78}, 1.003, 1.5e-3, -8e-4, 1024, 768};
}
inline PinholeParameters sample_pinhole() {
  return {{1510.3, 1498.8}, {968.2, 531.7}, {-0.21, 0.085, 1.1e-3, -7e-4, -0.013}};
}
constexpr std::array kSampleFisheye{-0.013, 0.021, -0.0074, 0.0011};

inline std::vector<SampleLens> sample_lenses() {
  return {
      {"equidistant", equidistant_lens({251.3, 248.9}, 158.0, from_degrees(95.0)), 500, 500},
      {"equisolid", equisolid_lens({251.3, 248.9}, 175.0, from_degrees(100.0)), 500, 500},
      {"opencv_fisheye", opencv_fisheye_lens({336.8, 337.9}, {543.4, 377.7}, kSampleFisheye, from_degrees(110.0)), 1032,
       778},
      {"scaramuzza", scaramuzza_lens(sample_scaramuzza(), from_degrees(110.0)), 1024, 768},
      {"pinhole, barrel", pinhole_lens(sample_pinhole()), 1920, 1080},
      {"pinhole, pincushion", pinhole_lens({{1200.0, 1200.0}, {639.5, 359.5}, {0.3, 0.4, 2e-3, 1e-3, 0.2}}), 1280, 720},
      {"pinhole, plain", pinhole_lens({{800.0, 800.0}, {319.5, 239.5}, {}}), 640, 480},
  };
}

}  // namespace kasumi

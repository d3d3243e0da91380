// A day's pictures by a camera of which the program knows nothing. The sky is the generator's, seen again through another
// lens, mirrored and tilted, with another tone curve and rim loss.
#pragma once

#include <filesystem>
#include <vector>

#include "calib/lens/lens_description.hpp"
#include "calib/mask/image_circle.hpp"
#include "fixtures/generator/generator.hpp"

namespace kasumi {

struct StrangeCamera {
  int size = 480;
  LensDescription lens;  // mirrored or not
  glm::dmat3 to_world{1.0};
  double tone_exponent = 1.0;  // over sRGB
  double rim_loss = 0.0;       // of ln light at the circle's edge
  ImageCircle circle;
};

struct SeriesDay {
  Site site{"", 34.7, 135.8, 100.0};
  std::vector<std::string> times;  // UTC
  double turbidity = 2.5;
};

// Skies of that day as the generator's own camera sees them.
std::vector<fixtures::SkyPicture> skies_of(const SeriesDay& day);
// PNG files named by their times, like 20260505_000000.png.
void write_series(const std::filesystem::path& folder, const SeriesDay& day,
                  const std::vector<fixtures::SkyPicture>& skies, const StrangeCamera& camera);

}  // namespace kasumi

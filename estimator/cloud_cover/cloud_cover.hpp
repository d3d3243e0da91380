// How much of the sky in a photograph is cloud, and what kind of sky it is; needs neither turbidity nor a calibration.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "base/image.hpp"
#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

// few: up to about a third of the sky; overcast: from about 93 %.
enum class CoverClass { unknown, clear, few, broken, overcast, night };
std::string_view name_of(CoverClass sky);  // "few"

enum class CoverElement : std::uint8_t { not_sky, clear, cloud };

struct CloudCover {
  std::optional<double> fraction;  // of the picture's sky, 0..1; by elements, not by solid angle
  double sigma = 0.0;              // standard deviation of `fraction`; valid with it
  CoverClass sky = CoverClass::unknown;
  double confidence = 0.0;       // probability that `sky` is right; 0 where unknown
  std::string reason;            // why there is no fraction; empty with it
  Image<CoverElement> elements;  // as the picture's; empty where there is no fraction
};

// Looks at colour against the clear sky's own in the same picture (fit_clear_blue), with walls and trees left out
// (not_sky) and the sun's and the horizon's smooth glow counted as clear. `sun`: where it is known; else the largest
// white patch is taken for it. There is no fraction for a grey camera or one without a channel, by night, for a picture
// that shows almost no sky, or hardly anything but black or white.
CloudCover cloud_cover(const SkyPicture& picture, const Camera& camera,
                       const std::optional<SunDirection>& sun = std::nullopt);

// The same for many pictures of one camera: `kept` is filled at the first, and anew where a picture has another size.
// `samples`: elements from which the sky's blue is learnt, at most.
struct PixelDirections;
CloudCover cloud_cover(const SkyPicture& picture, const Camera& camera, const std::optional<SunDirection>& sun,
                       std::shared_ptr<const PixelDirections>& kept, int samples = 1500);

// 1 where an element shows clear air; as large as the picture's elements.
Image<std::uint8_t> clear_air_of(const CloudCover& cover);

}  // namespace kasumi

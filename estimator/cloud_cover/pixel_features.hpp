// The elements of a sky picture as the search for clouds takes them: colour, light and where each looks.
#pragma once

#include <optional>

#include <opencv2/core.hpp>

#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

// What stays the same from picture to picture of a camera. Maps have the picture's size.
struct PixelDirections {
  cv::Mat1b inside;      // 255: the lens reaches it, at least kLeastElevation high, not under the camera's mask
  cv::Mat3f direction;   // world frame; 0 outside
  cv::Mat1f zenith_deg;  // 90 outside
  double radius = 0.0;   // elements from the zenith to the horizon, about
  int count = 0;         // elements inside
  double step = 1.0;     // the picture's
  glm::dvec2 first{};    // the picture's
  bool fits(const SkyPicture& picture) const;
};
PixelDirections pixel_directions(const SkyPicture& picture, const Camera& camera);

// Maps have the picture's size. Values are encoded ones: neither the tone curve nor the white balance is known.
struct PixelFeatures {
  cv::Mat1b inside;      // of PixelDirections
  cv::Mat3f rgb;         // 0..1; the picture's own
  cv::Mat1f light;       // mean of R, G, B
  cv::Mat1f blueness;    // 1 - R/B of a 3 x 3 mean where B > R, else ln B/R: about 0 for grey, 0.1 to 0.6 for clear sky
  cv::Mat1f greenness;   // (2 G - R - B) / (R + G + B)
  cv::Mat1f zenith_deg;  // of PixelDirections
  cv::Mat3f direction;   // of the same
  cv::Mat1b clipped;     // 255: white, all channels at full scale
  cv::Mat1b partly;      // 255: a channel is at full scale
  double radius = 0.0;   // elements from the zenith to the horizon, about
  int count = 0;         // elements inside
};
constexpr double kLeastElevation = 2.25;  // degrees: the rim of a fisheye picture is soft

// `picture` must outlive what is returned.
PixelFeatures pixel_features(const SkyPicture& picture, const PixelDirections& directions);

// Angle from the sun in degrees.
cv::Mat1f sun_distance(const PixelFeatures& sky, const SunDirection& sun);

// Means over square windows, only of elements that count.
class InsideMeans {
 public:
  InsideMeans(const cv::Mat1b& counts, int side);
  cv::Mat1f of(const cv::Mat1f& values) const;

 private:
  int side_;
  cv::Mat1f weight_, total_;
};

// An odd number of elements, at least 3, for a window that spans `elements` where the horizon lies 190 elements from
// the zenith.
int scaled_side(const PixelFeatures& sky, double elements);

}  // namespace kasumi

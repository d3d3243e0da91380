#include "estimator/turbidity/sky_picture.hpp"

#include <algorithm>

namespace kasumi {

namespace {

// Takes element (x, y) from pixel (offset + step x, offset + step y).
template <class PixelAt>
Result<SkyPicture> pick(int width, int height, double quantum, const Camera& camera, int largest_side,
                        const PixelAt& pixel_at) {
  if (width != camera.width || height != camera.height || width <= 0 || height <= 0)
    return fail(FaultKind::bad_input, "{} picture is {} x {}, but the {} camera is calibrated for {} x {}", camera.name,
                width, height, camera.name, camera.width, camera.height);
  const int side = std::max(1, largest_side);
  const int step = (std::max(width, height) + side - 1) / side;
  const int offset = (step - 1) / 2;
  SkyPicture picture;
  picture.encoded = Image<glm::vec3>((width - offset + step - 1) / step, (height - offset + step - 1) / step);
  picture.step = step;
  picture.first = {offset, offset};
  picture.quantum = quantum;
  for (int y = 0; y < picture.encoded.height(); ++y)
    for (int x = 0; x < picture.encoded.width(); ++x)
      picture.encoded.at(x, y) = pixel_at(offset + x * step, offset + y * step);
  return picture;
}

}  // namespace

Result<SkyPicture> sky_picture(const PictureView& view, const Camera& camera, int largest_side) {
  return pick(view.width, view.height, 1.0 / 255.0, camera, largest_side,
              [&](int x, int y) { return glm::vec3(rgb_at(view, x, y)) / 255.0f; });
}

Result<SkyPicture> sky_picture(const Image<glm::vec3>& encoded, double quantum, const Camera& camera,
                               int largest_side) {
  return pick(encoded.width(), encoded.height(), quantum, camera, largest_side,
              [&](int x, int y) { return encoded.at(x, y); });
}

}  // namespace kasumi

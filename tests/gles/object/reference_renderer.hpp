// The reference picture: rays through sample points, double precision, no rasteriser, no shader and none of the
// renderer's code. Slow, and simple enough to be checked by reading.
#pragma once

#include <vector>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "gles/model/model.hpp"
#include "gles/scene.hpp"

namespace kasumi {

struct ReferenceScene {
  Model model;
  glm::dmat4 model_to_world{1.0};
  SceneView view;
  ObjectAppearance appearance;
  AirlightGrid measured;
  ResponseCurve response;
  Image<std::uint8_t> mask;  // empty: nothing in front
  bool by_mask = false;      // mix what the mask leaves open by its share, as a moving view does
  Image<float> depth_m;      // of the real scene, along the optical axis, 0 where there is none; empty: none anywhere
};

struct ReferencePicture {
  Image<glm::dvec3> encoded;  // 0 .. 255, not rounded
  Image<glm::dvec4> layer;    // premultiplied N, coverage; the whole picture, mask applied
  Image<glm::dvec3> taken;    // share of the camera's light that is gone, per channel: the coverage, or in the object's
                              // shadow on the ground what the shadow takes
};

// Sample points within a pixel, relative to its centre.
std::vector<glm::dvec2> turned_lattice();        // the 17 points ((4a - b) / 17, (a + 4b) / 17) within a pixel
std::vector<glm::dvec2> upright_grid(int side);  // side x side
std::vector<glm::dvec2> pixel_centre();

// `camera`: the encoded picture behind the object.
ReferencePicture render_reference(const ReferenceScene& scene, const Image<Rgb8>& camera,
                                  const std::vector<glm::dvec2>& samples);
// The same object and shadow over another picture.
ReferencePicture before_picture(ReferencePicture rendered, const ReferenceScene& scene, const Image<Rgb8>& camera);

// Exact response both ways, one channel.
double reference_light(const ResponseCurve& response, int channel, double code);
double reference_code(const ResponseCurve& response, int channel, double light);

// Over the pixels the object covers and those beside it that are not as they should be, in decibels of full scale; of the
// whole picture when there are none.
double psnr(const Image<Rgb8>& picture, const ReferencePicture& reference);

}  // namespace kasumi

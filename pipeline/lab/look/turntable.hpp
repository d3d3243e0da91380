// A model drawn for its owner to look at: from eight sides, and as the kiosk sees it.
#pragma once

#include <vector>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "gles/gl/context.hpp"
#include "pipeline/site/config/installation.hpp"

namespace kasumi {

// From the south, the south-east, the east, ... under a clear sky with the sun behind the viewer's left shoulder, 480 x
// 360 pixels each. All are exposed as a photographer would for the model: its brightest fiftieth is just below white.
// Errors: bad_input (the model), device.
struct Turntable {
  std::vector<Image<Rgb8>> views;
  double exposure = 1.0;  // times that for a landscape
};
Result<Turntable> turntable(GlContext& context, const Model& model, UpAxis up);

// The scene camera's picture with the model at its configured place in an ordinary clear afternoon, over sky and plain
// land; and the part of it that the model changes, enlarged by whole numbers (empty: it changes nothing). Errors: as
// turntable().
struct KioskView {
  Image<Rgb8> whole, enlarged;
};
Result<KioskView> seen_from_kiosk(GlContext& context, const Installation& installation, const Model& model);

}  // namespace kasumi

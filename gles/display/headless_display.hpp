// An offscreen display whose last shown picture can be read.
#pragma once

#include "base/image.hpp"
#include "base/picture.hpp"
#include "gles/display/display.hpp"

namespace kasumi {

class HeadlessDisplay : public Display {
 public:
  virtual Result<Image<Rgb8>> read() = 0;  // the picture shown last, rows from the top
};

}  // namespace kasumi

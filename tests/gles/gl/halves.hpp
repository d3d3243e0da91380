// Pictures that fragment shaders draw in 16 bits, beside the same in 32.
#pragma once

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

// Whether this driver computes in half floats what is not declared highp, as GLES 2 lets it: llvmpipe does where the
// processor converts them (F16C). A context is current.
bool computes_in_halves();

}  // namespace kasumi

// The most precise depth format the driver supports.
#pragma once

#include "gles/gl/context.hpp"

namespace kasumi {

unsigned depth_format(const GlInfo& info);

}  // namespace kasumi

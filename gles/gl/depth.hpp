// The finest depth buffer the driver draws into.
#pragma once

#include "gles/gl/context.hpp"

namespace kasumi {

unsigned depth_format(const GlInfo& info);

}  // namespace kasumi

// The GL headers, for this room's sources only.
#pragma once

#define GL_GLEXT_PROTOTYPES 0
#include <GLES2/gl2.h>
#include <GLES2/gl2ext.h>

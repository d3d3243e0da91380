// The renderer's shader programs, each variant compiled when it is first needed.
#pragma once

#include <map>
#include <utility>

#include "base/result.hpp"
#include "gles/program.hpp"

namespace kasumi {

// What the texture units hold, throughout the room. GLES 2 promises eight.
enum TextureUnit : int {
  kPlaneUnit = 0,  // .. 2
  kLayerUnit = 3,
  kForegroundUnit = 4,
  kResponseUnit = 5,
  kDitherUnit = 6,
  kSurfaceUnit = 7,
  kShadowUnit = 12,  // beyond what GLES 2 promises, like the surface's pictures beside the camera's
  kNoiseUnit = 7,    // with the camera's picture, where no surface is drawn
};

enum class ProgramKind { object, ground, sun_map, spread, resolve, picture };

class Programs {
 public:
  Result<const Program*> find(ProgramKind kind, const Defines& defines);

 private:
  std::map<std::pair<ProgramKind, Defines>, Program> built_;
};

}  // namespace kasumi

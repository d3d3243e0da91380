// The renderer's shader programs; each variant is compiled on first use.
#pragma once

#include <map>
#include <utility>

#include "base/result.hpp"
#include "gles/gl/program.hpp"

namespace kasumi {

enum class ProgramKind { object, ground, sun_map, spread, mean, resolve, matte, picture, sharpen, jpeg };

class Programs {
 public:
  Result<const Program*> find(ProgramKind kind, const Defines& defines);

 private:
  std::map<std::pair<ProgramKind, Defines>, Program> built_;
};

}  // namespace kasumi

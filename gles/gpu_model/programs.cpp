#include "gles/gpu_model/programs.hpp"

namespace kasumi {
namespace {

Result<Program> build(ProgramKind kind, const Defines& defines) {
  switch (kind) {
    case ProgramKind::object: return Program::build(defines, "object.vert", "object.frag");
    case ProgramKind::ground: return Program::build(defines, "object.vert", "ground.frag");
    case ProgramKind::sun_map: return Program::build(defines, "sun_map.vert", "sun_map.frag");
    case ProgramKind::spread: return Program::build(defines, "square.vert", "spread.frag");
    case ProgramKind::mean: return Program::build(defines, "resolve.vert", "mean.frag");
    case ProgramKind::resolve: return Program::build(defines, "resolve.vert", "resolve.frag");
    case ProgramKind::matte: return Program::build(defines, "square.vert", "matte.frag");
    case ProgramKind::sharpen: return Program::build(defines, "blocks.vert", "sharpen.frag");
    case ProgramKind::jpeg: return Program::build(defines, "blocks.vert", "jpeg.frag");
    case ProgramKind::picture: return Program::build(defines, "picture.vert", "picture.frag");
  }
  return fail(FaultKind::device, "no such program");
}

}  // namespace

Result<const Program*> Programs::find(ProgramKind kind, const Defines& defines) {
  const auto known = built_.find({kind, defines});
  if (known != built_.end()) return &known->second;
  auto made = build(kind, defines);
  if (!made) return fail(made.error());
  return &built_.emplace(std::pair(kind, defines), std::move(*made)).first->second;
}

}  // namespace kasumi

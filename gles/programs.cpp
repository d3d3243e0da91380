#include "gles/programs.hpp"

namespace kasumi {
namespace {

Result<Program> build(ProgramKind kind, const Defines& defines) {
  switch (kind) {
    case ProgramKind::object:
      // A file with uniforms goes to the one stage that uses them: precisions may differ between the stages.
      if (!defines.contains("FINAL_COLOUR"))
        return Program::build(defines, {"path.glsl", "lens.glsl", "object.vert"},
                              {"haze.glsl", "dither.glsl", "surface.glsl", "light.glsl", "object.frag"});
      if (defines.contains("HAZE_PER_FRAGMENT"))
        return Program::build(defines, {"airlight.glsl", "path.glsl", "lens.glsl", "object.vert"},
                              {"haze.glsl", "dither.glsl", "response.glsl", "camera_picture.glsl", "surface.glsl",
                               "light.glsl", "object.frag"});
      return Program::build(
          defines, {"airlight.glsl", "haze.glsl", "path.glsl", "lens.glsl", "object.vert"},
          {"dither.glsl", "response.glsl", "camera_picture.glsl", "surface.glsl", "light.glsl", "object.frag"});
    case ProgramKind::resolve:
      return Program::build(defines, {"resolve.vert"}, {"dither.glsl", "layer.glsl", "resolve.frag"});
    case ProgramKind::picture:
      return Program::build(defines, {"airlight.glsl", "picture.vert"},
                            {"dither.glsl", "layer.glsl", "response.glsl", "camera_picture.glsl", "picture.frag"});
  }
  return fail(FaultKind::device, "no such program");
}

}  // namespace

Result<const Program*> Programs::find(ProgramKind kind, const Defines& defines) {
  const auto known = built_.find({kind, defines});
  if (known != built_.end()) return &known->second;
  auto made = build(kind, defines);
  if (!made) return tl::unexpected(made.error());
  return &built_.emplace(std::pair(kind, defines), std::move(*made)).first->second;
}

}  // namespace kasumi

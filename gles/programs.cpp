#include "gles/programs.hpp"

namespace kasumi {
namespace {

Result<Program> build(ProgramKind kind, const Defines& defines) {
  switch (kind) {
    case ProgramKind::object:
      // A file with uniforms goes to the one stage that uses them: precisions may differ between the stages.
      if (!defines.contains("FINAL_COLOUR"))
        return Program::build(defines, {"path.glsl", "lens.glsl", "object.vert"},
                              {"haze.glsl", "dither.glsl", "scene_depth.glsl", "surface.glsl", "sun.glsl",
                               "sky_atlas.glsl", "sun_maps.glsl", "sun_shadow.glsl", "light.glsl", "object.frag"});
      if (defines.contains("HAZE_PER_FRAGMENT"))
        return Program::build(
            defines, {"airlight.glsl", "path.glsl", "lens.glsl", "object.vert"},
            {"haze.glsl", "dither.glsl", "response.glsl", "camera_picture.glsl", "surface.glsl", "sun.glsl",
             "sky_atlas.glsl", "sun_maps.glsl", "sun_shadow.glsl", "light.glsl", "object.frag"});
      return Program::build(defines, {"airlight.glsl", "haze.glsl", "path.glsl", "lens.glsl", "object.vert"},
                            {"dither.glsl", "response.glsl", "camera_picture.glsl", "surface.glsl", "sun.glsl",
                             "sky_atlas.glsl", "sun_maps.glsl", "sun_shadow.glsl", "light.glsl", "object.frag"});
    case ProgramKind::ground:
      if (!defines.contains("FINAL_COLOUR"))
        return Program::build(defines, {"path.glsl", "lens.glsl", "object.vert"},
                              {"haze.glsl", "dither.glsl", "scene_depth.glsl", "sun.glsl", "sky_atlas.glsl",
                               "sun_maps.glsl", "sun_shadow.glsl", "ground.frag"});
      if (defines.contains("HAZE_PER_FRAGMENT"))
        return Program::build(defines, {"airlight.glsl", "path.glsl", "lens.glsl", "object.vert"},
                              {"haze.glsl", "dither.glsl", "response.glsl", "camera_picture.glsl", "sun.glsl",
                               "sky_atlas.glsl", "sun_maps.glsl", "sun_shadow.glsl", "ground.frag"});
      return Program::build(defines, {"airlight.glsl", "haze.glsl", "path.glsl", "lens.glsl", "object.vert"},
                            {"dither.glsl", "response.glsl", "camera_picture.glsl", "sun.glsl", "sky_atlas.glsl",
                             "sun_maps.glsl", "sun_shadow.glsl", "ground.frag"});
    case ProgramKind::sun_map: return Program::build(defines, {"sun_maps.glsl", "sun_map.vert"}, {"sun_map.frag"});
    case ProgramKind::spread: return Program::build(defines, {"resolve.vert"}, {"dither.glsl", "spread.frag"});
    case ProgramKind::resolve:
      return Program::build(defines, {"resolve.vert"}, {"dither.glsl", "layer.glsl", "resolve.frag"});
    case ProgramKind::picture:
      return Program::build(
          defines, {"airlight.glsl", "picture.vert"},
          {"dither.glsl", "layer.glsl", "response.glsl", "camera_picture.glsl", "noise.glsl", "picture.frag"});
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

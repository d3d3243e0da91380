// A model's material on its way to the object program.
#pragma once

#include <array>
#include <span>

#include "gles/gl/program.hpp"
#include "gles/gl/surface_texture.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

// Texture units that a pass leaves to the surface's pictures; -1 where there is none, and the picture is left out.
struct SurfaceUnits {
  int base = -1;
  int normal = -1;
  int roughness = -1;
  int occlusion = -1;
  int emission = -1;
  int sky = -1;  // of SkyAtlas
};

// Into the layer: nothing of the camera's picture is in use meanwhile.
SurfaceUnits units_for_layer();
// In one pass with the camera's picture, on a driver of `available` units: what GLES 2 promises is too few for all.
SurfaceUnits units_beside_camera(int available);
// Whether all pictures of a material have a unit.
bool holds(const SurfaceUnits& units, const ModelMaterial& material);

// Which parts of surface.glsl and light.glsl the material needs.
Defines defines_of(const ModelMaterial& material, std::span<const SurfaceTexture> textures, const SurfaceUnits& units);

// Uniforms and pictures for the program in use.
void bind_material(const Program& program, const ModelMaterial& material, std::span<const SurfaceTexture> textures,
                   const SurfaceUnits& units);

}  // namespace kasumi

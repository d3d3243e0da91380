// Sets up the object program for a model's material.
#pragma once

#include <array>
#include <span>

#include "gles/gl/program.hpp"
#include "gles/gl/surface_texture.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

// Texture units that a pass leaves for the surface's pictures; -1: none, and the picture is left out.
struct SurfaceUnits {
  int base = -1;
  int normal = -1;
  int roughness = -1;
  int occlusion = -1;
  int emission = -1;
  int sky = -1;  // of RadianceAtlas
};

// For drawing the layer, when the camera's picture is not bound.
SurfaceUnits units_for_layer();
// For one pass with the camera's picture, on a driver with `available` units; GLES 2's guaranteed 8 are too few for
// all.
SurfaceUnits units_beside_camera(int available);
// Whether all pictures of a material have a unit.
bool holds(const SurfaceUnits& units, const ModelMaterial& material);

// The parts of surface.glsl and light.glsl that the material needs.
Defines defines_of(const ModelMaterial& material, std::span<const SurfaceTexture> textures, const SurfaceUnits& units);

// Sets uniforms and binds pictures for the program in use.
void bind_material(const Program& program, const ModelMaterial& material, std::span<const SurfaceTexture> textures,
                   const SurfaceUnits& units);

}  // namespace kasumi

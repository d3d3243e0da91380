// A model on the CPU: the parts of a glTF file that Kasumi uses. Axes as in glTF: y up, metres.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <glm/gtc/type_precision.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/result.hpp"
#include "base/units.hpp"

namespace kasumi {

struct ModelVertex {
  glm::vec3 position{};       // model frame, node transforms applied
  glm::vec3 normal{0, 1, 0};  // unit length
  glm::vec2 texture{};        // (0, 0) is the first texel of the first row
  glm::vec4 colour{1};        // linear; multiplies the material's base colour
  glm::vec2 texture_2{};      // a second set of texture coordinates
  glm::vec4 tangent{
      0};  // xyz: direction of growing texture x, unit length; w: -1 where the picture is mirrored, else 1
};

// A texture reference of a material.
struct MaterialMap {
  int texture = -1;     // index into Model::textures; -1: none
  bool second = false;  // uses ModelVertex::texture_2
  bool used() const { return texture >= 0; }
};

// A surface's material (glTF 2.0, 3.9): metallic-roughness with dielectric reflection. The defaults are diffuse like
// plaster, not glTF's, which apply to files.
struct ModelMaterial {
  enum class Alpha { opaque, mask, blend };
  std::string name;
  glm::vec4 base_colour{1};  // linear
  int texture = -1;          // base colour's: index into Model::textures, with ModelVertex::texture; -1: none
  Alpha alpha = Alpha::opaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = false;

  float metallic = 0.0f;
  float roughness = 1.0f;
  MaterialMap roughness_map{};    // green: roughness, blue: metallic
  glm::vec3 reflectance{0.0f};    // of dielectrics at normal incidence; glTF's default is 0.04
  float edge_reflectance = 0.0f;  // the same at grazing incidence; glTF's default is 1
  MaterialMap normal_map{};
  float normal_scale = 1.0f;
  MaterialMap occlusion_map{};  // red: visible share of the sky
  float occlusion_strength = 1.0f;
  glm::vec3 emission{0.0f};  // 1: as bright as a white card lying in sun and sky, as for unlit materials
  MaterialMap emission_map{};
  bool unlit = false;  // base colour is used as emission

  bool reflects() const {
    return !unlit && (metallic > 0.0f || edge_reflectance > 0.0f || reflectance != glm::vec3(0.0f));
  }
};

enum class TextureWrap { repeat, mirrored_repeat, clamp };
struct ModelTexture {
  Image<glm::u8vec4> pixels;  // sRGB encoded with linear alpha, not premultiplied; data: unchanged
  TextureWrap wrap_s = TextureWrap::repeat;
  TextureWrap wrap_t = TextureWrap::repeat;
  bool nearest = false;                       // no filtering when magnified
  bool data = false;                          // roughness, normals and the like, not colours
  std::vector<Image<glm::u8vec4>> smaller{};  // its levels (mip_levels.hpp); empty: made when they are needed
};

struct ModelPart {  // triangles of one material
  int material = 0;
  std::vector<ModelVertex> vertices;
  std::vector<std::uint32_t> indices;  // three per triangle, counter-clockwise as seen from the front
};

struct ModelBounds {
  glm::vec3 lowest{};
  glm::vec3 highest{};
};

// A place with a name, for what is told of it.
struct ModelNode {
  std::string name;
  ModelBounds bounds;  // of its meshes and those below it, model frame; without any both are its origin
};

struct Model {
  std::string name;
  std::vector<ModelPart> parts;
  std::vector<ModelPart> ground;  // the real ground: not drawn, but receives the object's shadow; its
                                  // material's base colour is the real ground's
  std::vector<ModelMaterial> materials;
  std::vector<ModelTexture> textures;
  std::vector<std::string> notes;            // what was left out or repaired, for the log
  std::vector<std::filesystem::path> files;  // it was read from these, its own first
  std::vector<std::string> scenes;           // names of all scenes in the file; "" where one has none
  std::vector<std::string> extensions;       // glTF's that it uses, sorted
  std::vector<ModelNode> nodes;              // those of the scene that have a name

  // Bounds of the object, without its ground.
  std::size_t triangle_count() const;
  ModelBounds bounds() const;
  ModelBounds bounds_with_ground() const;
};

// Limits that protect against malicious files, whose few bytes may name the same data any number of times: what is
// named counts as often as it is named.
struct ModelLimits {
  std::size_t file_bytes = std::size_t{512} << 20;  // each file of the model; all that is unpacked from it
  std::size_t all_bytes = std::size_t{2} << 30;     // of files and pictures, as they are read and as they are decoded
  std::size_t json_values = 10'000'000;
  std::size_t numbers = 600'000'000;  // taken out of accessors: what the most vertices and triangles may have
  std::size_t triangles = 10'000'000;
  std::size_t vertices = 30'000'000;
  std::size_t nodes = 1'000'000;  // and meshes' primitives, with their copies
  std::size_t materials = 50'000;
  double covered = 1000.0;   // area of all triangles, in that of their box: each layer is drawn, however small the file
  int texture_size = 16384;  // pixels along one side
  std::size_t texture_pixels = std::size_t{256} << 20;  // of all textures together
};

// Reads .glb, or .gltf with buffers and pictures from the same folder tree only; never from a network. Draco,
// meshopt, WebP and KTX2 are unpacked by a module (rare_models.hpp); AVIF is refused with advice. Skins and morph
// targets stand as the file leaves them: joints where their nodes are, default weights. `scene`: one of the file's scenes by name, or by number
// from 0; empty: the default one. Nodes whose name begins with "kasumi_ground" or whose extras say "kasumi": "ground"
// become, with their children, the model's ground. Extras "kasumi_box" (lowest and highest x y z) are a node's bounds.
// Errors: bad_input, naming the file and what is wrong with it; io.
Result<Model> read_gltf(const std::filesystem::path& path, const ModelLimits& limits = {}, std::string_view scene = {});

// Checks a model made in memory by the same rules as a file: indices in range, finite positions, at least one triangle.
// Errors: bad_input.
Result<> check(const Model& model);

// A model's placement: metres from the scene camera's site, turned clockwise about the vertical.
enum class UpAxis { y, z };  // y in glTF; some exporters write z
struct Placement {
  double east_m = 0.0;
  double north_m = 0.0;
  double up_m = 0.0;
  Radians heading{};
  double scale = 1.0;
  UpAxis up_axis = UpAxis::y;
};
// Model frame to world frame; at heading 0 the model's x points east, y up, -z north (up_axis z: y north, z up).
glm::dmat4 model_to_world(const Placement& placement);

}  // namespace kasumi

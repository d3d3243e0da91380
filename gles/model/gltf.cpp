#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "gles/model/accessor.hpp"
#include "gles/model/gltf_values.hpp"
#include "gles/model/material.hpp"
#include "gles/model/model.hpp"
#include "gles/model/model_file.hpp"
#include "gles/model/model_mesh.hpp"
#include "gles/model/pose.hpp"
#include "gles/model/unpack.hpp"

namespace kasumi {
namespace {

bool finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Nodes marked as the real ground. Matches the beginning of the name, because Blender appends numbers to copies.
bool marks_ground(const tinygltf::Node& node) {
  if (node.name.starts_with("kasumi_ground")) return true;
  if (!node.extras.IsObject() || !node.extras.Has("kasumi")) return false;
  const tinygltf::Value& mark = node.extras.Get("kasumi");
  return mark.IsString() && mark.Get<std::string>() == "ground";
}

ModelBounds joined(const std::optional<ModelBounds>& a, const ModelBounds& b) {
  return a ? ModelBounds{glm::min(a->lowest, b.lowest), glm::max(a->highest, b.highest)} : b;
}

std::optional<ModelBounds> box_of(std::span<const ModelPart> parts) {
  std::optional<ModelBounds> box;
  for (const ModelPart& part : parts)
    for (const ModelVertex& vertex : part.vertices) box = joined(box, {vertex.position, vertex.position});
  return box;
}

// What write_gltf.cpp keeps of a node whose meshes have been joined with others.
std::optional<ModelBounds> written_box(const tinygltf::Node& node) {
  const auto at = numbers(node.extras, "kasumi_box", std::vector<double>(6, HUGE_VAL));
  const ModelBounds box{{at[0], at[1], at[2]}, {at[3], at[4], at[5]}};
  return finite(box.lowest) && finite(box.highest) ? std::optional(box) : std::nullopt;
}

double times_covered(const std::vector<ModelPart>& parts) {
  const auto box = box_of(parts);
  if (!box) return 0.0;
  const glm::dvec3 size = glm::dvec3(box->highest) - glm::dvec3(box->lowest);
  const double around = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
  double area = 0.0;
  for (const ModelPart& part : parts)
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      const auto at = [&](std::size_t c) { return glm::dvec3(part.vertices[part.indices[i + c]].position); };
      area += 0.5 * glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
    }
  return around > 0.0 ? area / around : 0.0;
}

class GltfReader {
 public:
  GltfReader(tinygltf::Model& gltf, std::string name, const ModelLimits& limits, std::string_view scene, Model& model)
      : gltf_(gltf),
        name_(std::move(name)),
        limits_(limits),
        wanted_scene_(scene),
        model_(model),
        accessors_(gltf, limits),
        skins_(gltf, accessors_, limits) {}

  Result<> read() {
    auto surfaces = read_surfaces(gltf_, name_, limits_, model_.notes);
    if (!surfaces) return fail(surfaces.error());
    model_.materials = std::move(surfaces->materials);
    model_.textures = std::move(surfaces->textures);
    placements_ = std::move(surfaces->placements);
    for (const tinygltf::Scene& scene : gltf_.scenes) model_.scenes.push_back(scene.name);
    if (gltf_.nodes.size() > limits_.nodes)
      return fail(FaultKind::bad_input, "{}: {} nodes: expected {} at most", name_, gltf_.nodes.size(), limits_.nodes);
    if (auto walked = walk(); !walked) return walked;
    if (!gltf_.animations.empty()) note("its animations are not played: it stands as its nodes say");
    if (model_.triangle_count() == 0)
      return fail(
          FaultKind::bad_input, "{}: no triangles in its scene{}", name_,
          points_ ? ", but points or lines: make a mesh of them first (CloudCompare: Plugins, PoissonRecon)" : "");
    for (const auto* parts : {&model_.parts, &model_.ground})
      if (const double times = times_covered(*parts); times > limits_.covered)
        return fail(FaultKind::bad_input, "{}: its triangles would cover its box {:.0f} times: expected {:.0f} at most",
                    name_, times, limits_.covered);
    return {};
  }

 private:
  template <class... Args>
  void note(fmt::format_string<Args...> format, Args&&... args) {
    add_note(model_.notes, fmt::format("{}: {}", name_, fmt::format(format, std::forward<Args>(args)...)));
  }

  // The index of the scene to show; -1: the file has none.
  Result<int> scene() const {
    const auto count = static_cast<int>(gltf_.scenes.size());
    if (wanted_scene_.empty()) {
      const int scene = gltf_.defaultScene >= 0 ? gltf_.defaultScene : 0;
      return scene < count ? scene : -1;
    }
    for (int i = 0; i < count; ++i)
      if (gltf_.scenes[static_cast<std::size_t>(i)].name == wanted_scene_) return i;
    int number = -1;
    const char* end = wanted_scene_.data() + wanted_scene_.size();
    const auto read = std::from_chars(wanted_scene_.data(), end, number);
    if (read.ec == std::errc() && read.ptr == end && number >= 0 && number < count) return number;
    std::string there;
    for (int i = 0; i < count; ++i)
      there += fmt::format("{}{} \"{}\"", i == 0 ? "" : ", ", i, gltf_.scenes[static_cast<std::size_t>(i)].name);
    return fail(FaultKind::bad_input, "{}: scene \"{}\": {}", name_, wanted_scene_,
                count == 0 ? "the file has no scenes" : "expected one of these by name or number: " + there);
  }

  // The root nodes: the scene's, else every node without a parent.
  std::vector<int> roots(int scene) const {
    if (scene >= 0) return gltf_.scenes[static_cast<std::size_t>(scene)].nodes;
    std::vector<bool> child(gltf_.nodes.size());
    for (const tinygltf::Node& node : gltf_.nodes)
      for (const int i : node.children)
        if (i >= 0 && static_cast<std::size_t>(i) < child.size()) child[static_cast<std::size_t>(i)] = true;
    std::vector<int> found;
    for (std::size_t i = 0; i < child.size(); ++i)
      if (!child[i]) found.push_back(static_cast<int>(i));
    return found;
  }

  Result<> walk() {
    struct Visit {
      int node;
      glm::dmat4 parent;
      bool ground;
      std::size_t above;  // of `passed`, the node that this one hangs from
    };
    const auto shown = scene();
    if (!shown) return fail(shown.error());
    std::vector<Visit> open;
    constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
    for (const int root : roots(*shown)) open.push_back({root, glm::dmat4{1.0}, false, kNone});
    std::vector<Passed> passed;
    std::vector<bool> visited(gltf_.nodes.size());
    while (!open.empty()) {
      const Visit visit = open.back();
      open.pop_back();
      const std::string what = fmt::format("{}: node {}", name_, visit.node);
      if (visit.node < 0 || static_cast<std::size_t>(visit.node) >= gltf_.nodes.size())
        return fail(FaultKind::bad_input, "{}: there are {}", what, gltf_.nodes.size());
      const auto at = static_cast<std::size_t>(visit.node);
      if (visited[at]) return fail(FaultKind::bad_input, "{} is its own ancestor or has two parents", what);
      visited[at] = true;
      const tinygltf::Node& node = gltf_.nodes[at];
      const auto local = transform_of(node, what);
      if (!local) return fail(local.error());
      const glm::dmat4 whole = visit.parent * *local;
      const bool ground = visit.ground || marks_ground(node);
      if (hidden(node)) continue;
      auto& into = ground ? model_.ground : model_.parts;
      const std::size_t first = into.size();
      if (auto read = read_node(node, whole, into, what); !read) return read;
      passed.push_back({visit.node, visit.above,
                        box_of({into.begin() + static_cast<std::ptrdiff_t>(first), into.end()}), glm::vec3(whole[3])});
      for (const int child : node.children) open.push_back({child, whole, ground, passed.size() - 1});
    }
    name_places(std::move(passed));
    return {};
  }

  struct Passed {
    int node;
    std::size_t above;
    std::optional<ModelBounds> box;  // of its meshes; empty: it has none
    glm::vec3 origin;
  };

  // A node comes before those that hang from it.
  void name_places(std::vector<Passed> passed) {
    for (std::size_t i = passed.size(); i-- > 0;)
      if (const auto& box = passed[i].box; box && passed[i].above < passed.size())
        passed[passed[i].above].box = joined(passed[passed[i].above].box, *box);
    for (const Passed& place : passed) {
      const tinygltf::Node& node = gltf_.nodes[static_cast<std::size_t>(place.node)];
      if (node.name.empty() || !finite(place.origin)) continue;
      model_.nodes.push_back(
          {node.name, written_box(node).value_or(place.box.value_or(ModelBounds{place.origin, place.origin}))});
    }
  }

  // With all that hangs from it (KHR_node_visibility).
  bool hidden(const tinygltf::Node& node) {
    const auto* visibility = extension_of(node.extensions, "KHR_node_visibility");
    if (visibility == nullptr || !visibility->IsObject() || !visibility->Has("visible")) return false;
    const tinygltf::Value& visible = visibility->Get("visible");
    if (!visible.IsBool() || visible.Get<bool>()) return false;
    note("nodes that it calls invisible are left out");
    return true;
  }

  // What moves a mesh's vertices.
  struct Stand {
    glm::dmat4 transform{1.0};
    const std::vector<glm::dmat4>* joints = nullptr;  // none: the transform alone
    std::vector<double> weights;                      // of morph targets
  };

  Result<> read_node(const tinygltf::Node& node, const glm::dmat4& whole, std::vector<ModelPart>& into,
                     const std::string& what) {
    if (node.mesh < 0) return {};
    if (static_cast<std::size_t>(node.mesh) >= gltf_.meshes.size())
      return fail(FaultKind::bad_input, "{}: mesh {}: there are {}", name_, node.mesh, gltf_.meshes.size());
    Stand stand;
    const auto& own = gltf_.meshes[static_cast<std::size_t>(node.mesh)].weights;
    stand.weights = node.weights.empty() ? own : node.weights;
    if (node.skin >= 0) {
      const auto joints = skins_.joints(node.skin, what);
      if (!joints) return fail(joints.error());
      stand.joints = *joints;
    }
    const auto copies = instances_of(accessors_, node, limits_, what);
    if (!copies) return fail(copies.error());
    const std::size_t drawn = gltf_.meshes[static_cast<std::size_t>(node.mesh)].primitives.size() * copies->size();
    if (drawn > limits_.nodes - primitives_)
      return fail(FaultKind::bad_input, "{}: with its mesh's {} primitives in {} copies more than {} are drawn", what,
                  gltf_.meshes[static_cast<std::size_t>(node.mesh)].primitives.size(), copies->size(), limits_.nodes);
    primitives_ += drawn;
    for (const glm::dmat4& copy : *copies) {
      stand.transform = whole * copy;
      if (auto read = read_mesh(node.mesh, stand, into); !read) return read;
    }
    return {};
  }

  Result<> read_mesh(int index, const Stand& stand, std::vector<ModelPart>& into) {
    tinygltf::Mesh& mesh = gltf_.meshes[static_cast<std::size_t>(index)];
    for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
      const std::string what = fmt::format("{}: mesh {}, primitive {}", name_, index, i);
      if (auto read = unpack_primitive(gltf_, mesh.primitives[i], what, limits_, unpacked_, model_.notes); !read)
        return read;
      if (auto read = read_primitive(mesh.primitives[i], stand, into, what); !read) return read;
    }
    return {};
  }

  Result<> read_primitive(const tinygltf::Primitive& primitive, const Stand& stand, std::vector<ModelPart>& into,
                          const std::string& what) {
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode > TINYGLTF_MODE_TRIANGLE_FAN)
      return fail(FaultKind::bad_input, "{}: mode {}: expected 0 .. 6", what, mode);
    if (mode < TINYGLTF_MODE_TRIANGLES) {
      note("its points and lines are left out");
      points_ = true;
      return {};
    }
    ModelPart part;
    part.material = primitive.material < 0 ? static_cast<int>(gltf_.materials.size()) : primitive.material;
    if (static_cast<std::size_t>(part.material) >= model_.materials.size())
      return fail(FaultKind::bad_input, "{}: material {}: there are {}", what, part.material, gltf_.materials.size());
    if (auto read = read_vertices(primitive, part, what); !read) return read;
    if (auto read = read_triangles(primitive, mode, part, what); !read) return read;
    triangles_ += part.indices.size() / 3;
    vertices_ += part.vertices.size();
    if (triangles_ > limits_.triangles || vertices_ > limits_.vertices)
      return fail(FaultKind::bad_input, "{}: more than {} triangles or {} vertices", name_, limits_.triangles,
                  limits_.vertices);
    if (part.indices.empty()) return {};
    if (auto moved = morph(accessors_, primitive, stand.weights, part, limits_, what); !moved) return moved;

    const bool with_normals = primitive.attributes.contains("NORMAL");
    if (with_normals) {
      if (const std::size_t replaced = mend_normals(part); replaced > 0)
        note("{} invalid normals replaced by those of their faces", replaced);
    }
    const bool skinned = stand.joints != nullptr && primitive.attributes.contains("JOINTS_0");
    auto placed =
        skinned ? pose(accessors_, primitive, *stand.joints, part, limits_, what) : place(part, stand.transform, what);
    if (!placed) return placed;
    if (!with_normals) give_flat_normals(part);
    if (const MaterialMap& normals = model_.materials[static_cast<std::size_t>(part.material)].normal_map;
        normals.used()) {
      if (with_normals && primitive.attributes.contains("TANGENT"))
        mend_tangents(part);
      else  // glTF requires ignoring tangents if there are no normals
        give_tangents(part, normals.second);
    }
    if (&into == &model_.ground && primitive.material < 0) part.material = plain_ground();
    into.push_back(std::move(part));
    return {};
  }

  // The material of ground without one in the file: glTF's default is white, which is implausible for ground.
  int plain_ground() {
    if (plain_ground_ < 0) {
      plain_ground_ = static_cast<int>(model_.materials.size());
      model_.materials.push_back({.name = "ground", .base_colour = {0.1f, 0.1f, 0.1f, 1.0f}});
    }
    return plain_ground_;
  }

  // The accessor of an attribute, empty where the primitive has none; one element per vertex.
  Result<AccessorFloats> attribute(const tinygltf::Primitive& primitive, const std::string& semantic,
                                   std::initializer_list<int> components, std::size_t vertices,
                                   const std::string& what) {
    const auto found = primitive.attributes.find(semantic);
    if (found == primitive.attributes.end()) return AccessorFloats{};
    auto floats = accessors_.floats(found->second, components, limits_.vertices, what + ": " + semantic);
    if (floats && floats->count != vertices)
      return fail(FaultKind::bad_input, "{}: {} has {} elements for {} vertices", what, semantic, floats->count,
                  vertices);
    return floats;
  }

  Result<> read_vertices(const tinygltf::Primitive& primitive, ModelPart& part, const std::string& what) {
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) return fail(FaultKind::bad_input, "{}: no POSITION", what);
    const auto positions = accessors_.floats(position->second, {3}, limits_.vertices, what + ": POSITION");
    if (!positions) return fail(positions.error());
    const std::size_t count = positions->count;
    const auto& placements = placements_[static_cast<std::size_t>(part.material)];
    const auto normals = attribute(primitive, "NORMAL", {3}, count, what);
    if (!normals) return fail(normals.error());
    const auto tangents = attribute(primitive, "TANGENT", {4}, count, what);
    if (!tangents) return fail(tangents.error());
    const auto colours = attribute(primitive, "COLOR_0", {3, 4}, count, what);
    if (!colours) return fail(colours.error());

    part.vertices.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      ModelVertex& vertex = part.vertices[i];
      const float* p = &positions->values[3 * i];
      vertex.position = {p[0], p[1], p[2]};
      if (!finite(vertex.position))
        return fail(FaultKind::bad_input, "{}: vertex {}: its position is not finite", what, i);
      if (normals->count > 0) {
        const float* n = &normals->values[3 * i];
        vertex.normal = {n[0], n[1], n[2]};
      }
      if (tangents->count > 0) {
        const float* t = &tangents->values[4 * i];
        vertex.tangent = {t[0], t[1], t[2], t[3]};
      }
      for (int c = 0; c < colours->components; ++c) {
        const float value =
            colours->values[i * static_cast<std::size_t>(colours->components) + static_cast<std::size_t>(c)];
        vertex.colour[c] = value >= 0.0f ? std::min(value, 1.0f) : 0.0f;
      }
    }
    for (const bool second : {false, true})
      if (const auto& placement = placements[second ? 1 : 0]; placement) {
        if (auto laid = lay(primitive, part, *placement, second, what); !laid) return laid;
      }
    return {};
  }

  // Texture coordinates with the material's transform applied.
  Result<> lay(const tinygltf::Primitive& primitive, ModelPart& part, const TexturePlacement& placement, bool second,
               const std::string& what) {
    const auto places =
        attribute(primitive, fmt::format("TEXCOORD_{}", placement.set), {2}, part.vertices.size(), what);
    if (!places) return fail(places.error());
    if (places->count == 0 && !part.vertices.empty())
      note("material \"{}\": a mesh has no texture coordinates for its pictures: one texel of each colours all of it",
           model_.materials[static_cast<std::size_t>(part.material)].name);
    for (std::size_t i = 0; i < places->count; ++i) {
      const glm::dvec3 moved = placement.transform * glm::dvec3(places->values[2 * i], places->values[2 * i + 1], 1.0);
      if (finite(moved))
        (second ? part.vertices[i].texture_2 : part.vertices[i].texture) = glm::vec2(moved);
      else
        note("texture coordinates that are not finite are replaced by 0");
    }
    return {};
  }

  Result<> read_triangles(const tinygltf::Primitive& primitive, int mode, ModelPart& part, const std::string& what) {
    std::vector<std::uint32_t> indices;
    if (primitive.indices >= 0) {
      auto read = accessors_.indices(primitive.indices, 3 * limits_.triangles, what + ": indices");
      if (!read) return fail(read.error());
      indices = std::move(*read);
    } else {
      indices.resize(part.vertices.size());
      for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = static_cast<std::uint32_t>(i);
    }
    const auto beyond = std::ranges::find_if(indices, [&](std::uint32_t i) { return i >= part.vertices.size(); });
    if (beyond != indices.end())
      return fail(FaultKind::bad_input, "{}: index {}: there are {} vertices", what, *beyond, part.vertices.size());
    part.indices = as_triangles(indices, mode);
    return {};
  }

  tinygltf::Model& gltf_;
  std::string name_;
  const ModelLimits& limits_;
  std::string_view wanted_scene_;
  Model& model_;
  Accessors accessors_;
  Skins skins_;
  std::vector<Surfaces::Placements> placements_;
  int plain_ground_ = -1;
  bool points_ = false;
  std::size_t primitives_ = 0;
  std::size_t unpacked_ = 0;  // bytes
  std::size_t triangles_ = 0;
  std::size_t vertices_ = 0;
};

}  // namespace

Result<Model> read_gltf(const std::filesystem::path& path, const ModelLimits& limits, std::string_view scene) {
  Model model;
  model.name = path.string();
  auto gltf = parse_gltf(path, limits, model.notes, model.files, model.extensions);
  if (!gltf) return fail(gltf.error());
  if (auto unpacked = unpack_views(*gltf, path.string(), limits); !unpacked) return fail(unpacked.error());
  if (auto read = GltfReader(*gltf, path.string(), limits, scene, model).read(); !read) return fail(read.error());
  if (auto sound = check(model); !sound) return fail(sound.error());
  return model;
}

}  // namespace kasumi

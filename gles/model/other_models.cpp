#include "gles/model/other_models.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include <fmt/format.h>

#include "base/picture_header.hpp"

namespace kasumi {

namespace {

constexpr std::string_view kPointCloud =
    "a point cloud, which has no surfaces that light could fall on: make a mesh of it first (CloudCompare: Plugins, "
    "PoissonRecon) and save that";
constexpr std::string_view kSplats =
    "Gaussian splats, which have no surfaces that light could fall on: deliver the mesh that was made of the same "
    "photographs";
constexpr std::string_view kWebPage = "a web page: its download brought a message in place of the model";
constexpr std::string_view kUsd = "a scene of USD: import it in Blender and export glTF 2.0";
constexpr std::string_view kCityModel = "a model of a city: citygml-tools or cjio make glTF of CityGML and CityJSON";

struct OtherModel {
  std::string_view key, words;
};
constexpr OtherModel kByBeginning[] = {
    {"version https://git-lfs", "only the place of a file that Git LFS keeps elsewhere: git lfs pull brings it"},
    {"<!DOCTYPE", kWebPage},
    {"<!doctype", kWebPage},
    {"<html", kWebPage},
    {"b3dm", "a tile of 3D Tiles (b3dm): npx 3d-tiles-tools b3dmToGlb -i IN.b3dm -o OUT.glb takes the glTF out of it"},
    {"i3dm",
     "a tile of 3D Tiles (i3dm): npx 3d-tiles-tools convertI3dmToGlb -i IN.i3dm -o OUT.glb makes a glTF with all its "
     "copies"},
    {"cmpt",
     "a tile of several of 3D Tiles (cmpt): npx 3d-tiles-tools splitCmpt -i IN.cmpt -o OUT makes a file of each"},
    {"pnts", kPointCloud},
    {"LASF", kPointCloud},
    {"ASTM-E57", kPointCloud},
    {"#usda", kUsd},
    {"PXR-USDC", kUsd},
    {"BLENDER", "Blender's own document: open it there and export glTF 2.0"},
    {"AC10", "a drawing of AutoCAD: save it as DXF or FBX, then assimp export IN.fbx OUT.glb (Debian: assimp-utils)"},
};
constexpr OtherModel kByEnding[] = {
    {".splat", kSplats},
    {".spz", kSplats},
    {".ksplat", kSplats},
    {".xyz", kPointCloud},
    {".pts", kPointCloud},
    {".ptx", kPointCloud},
    {".laz", kPointCloud},
    {".usdz", kUsd},
    {".usd", kUsd},
    {".citygml", kCityModel},
    {".skp",
     "a SketchUp document: export it as COLLADA (.dae), then assimp export IN.dae OUT.glb (Debian: assimp-utils)"},
};
// What assimp reads.
constexpr std::string_view kForAssimp[] = {".obj", ".ply", ".stl", ".fbx", ".dae", ".3ds",
                                           ".ifc", ".x3d", ".off", ".dxf", ".lwo"};

bool has(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

}  // namespace

std::string other_model(std::string_view bytes, std::string_view name) {
  constexpr std::size_t kFirst = 2000;
  const auto beginning = bytes.substr(0, kFirst);
  std::string ending = std::filesystem::path(name).extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (bytes.empty()) return "an empty file: copy or download it again";
  for (const auto& [begins, words] : kByBeginning)
    if (beginning.starts_with(begins)) return std::string(words);
  if (beginning.starts_with("ply") && has(beginning, "f_dc_0")) return std::string(kSplats);
  if (beginning.starts_with("ply") && !has(beginning, "element face")) return std::string(kPointCloud);
  if (has(beginning, "\"CityJSON\"") || has(beginning, "opengis.net/citygml")) return std::string(kCityModel);
  if (has(beginning, "\"geometricError\""))
    return "a tileset of 3D Tiles, which names the tiles that hold the models: look at those";
  for (const auto& [ends, words] : kByEnding)
    if (ending == ends) return std::string(words);
  if (std::ranges::find(kForAssimp, ending) != std::end(kForAssimp))
    return fmt::format("no glTF: assimp export IN{} OUT.glb (Debian: assimp-utils) makes one", ending);
  return {};
}

std::string other_than_data(std::span<const std::uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const auto& [begins, words] : std::span(kByBeginning).first(4))
    if (text.starts_with(begins)) return std::string(words);
  return {};
}

std::string other_picture(std::span<const std::uint8_t> bytes, std::string_view name) {
  constexpr OtherModel kPictures[]{{"8BPS", "PSD"}, {"GIF8", "GIF"},
                                   {"DDS ", "DDS"}, {std::string_view("\0\0\0\x0cjP", 6), "JPEG 2000"},
                                   {"<svg", "SVG"}, {"<?xml", "SVG"}};
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("\xabKTX 11")) return "a KTX of version 1: ktx2ktx2 of KTX-Software makes a KTX2 of it";
  std::string ending = std::filesystem::path(name).extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  std::string_view kind = ending == ".tga" ? "TGA" : "";
  if (const auto header = picture_header(bytes)) kind = header->format;
  if (kind == "PNG" || kind == "JPEG" || kind == "WebP") return {};
  if (kind == "HEIF") kind = "AVIF or HEIC";
  for (const auto& [begins, is] : kPictures)
    if (text.starts_with(begins)) kind = is;
  if (kind.empty()) return {};
  const std::string from = ending.empty() ? "IN" : "IN" + ending;
  return fmt::format(
      "a picture of {}: expected PNG, JPEG, WebP or KTX2. convert {} OUT.png (Debian: imagemagick) makes a PNG of it, "
      "which the model must name instead",
      kind, from);
}

}  // namespace kasumi

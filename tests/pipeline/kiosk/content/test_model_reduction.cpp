// `content pack` reduces what is too large for the kiosk. The loss is measured here by drawings of its own, from the scene
// camera of the bench.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "base/picture_files/picture_file.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/show/scene/compositor.hpp"
#include "tests/gles/model/packed_files.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/content/desk.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

constexpr int kPictureWidth = 320, kPictureHeight = 180;

// A round tower, 40 m high and wide, of 2 steps^2 triangles. `relief`: with the grain of hewn stone, finer than a pixel.
PlainMesh tower(int steps, bool relief = false) {
  PlainMesh mesh;
  for (int y = 0; y <= steps; ++y)
    for (int x = 0; x <= steps; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(steps);
      const float v = static_cast<float>(y) / static_cast<float>(steps);
      const float turn = 6.2831853f * u, up = 40.0f * v;
      const float grain = relief ? 0.004f * std::sin(190.0f * turn) * std::sin(9.0f * up) : 0.0f;
      const float radius = (20.0f - 12.0f * v * v) + grain;
      mesh.positions.insert(mesh.positions.end(), {radius * std::sin(turn), up, radius * std::cos(turn)});
      // As rough as the surface itself.
      const float rough = relief ? 0.02f * std::cos(190.0f * turn) * std::sin(9.0f * up) : 0.0f;
      const glm::vec3 normal = glm::normalize(glm::vec3(std::sin(turn + rough), 0.6f * v, std::cos(turn + rough)));
      mesh.normals.insert(mesh.normals.end(), {normal.x, normal.y, normal.z});
      mesh.texture.insert(mesh.texture.end(), {u, 1.0f - v});
    }
  const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (steps + 1) + x); };
  for (int y = 0; y < steps; ++y)
    for (int x = 0; x < steps; ++x)
      for (const std::uint32_t i : {at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y), at(x + 1, y + 1), at(x, y + 1)})
        mesh.indices.push_back(i);
  return mesh;
}

// Courses of stone with windows.
std::vector<std::uint8_t> stone(int side) {
  Image<Rgb8> picture(side, side);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const int u = 64 * x / side, v = 64 * y / side;
      const bool window = u % 8 < 2 && v % 12 < 5;
      const int grain = (x * 7 + y * 13 + (x * y) % 31) % 24;
      const int light = window ? 30 : 130 + 40 * (u % 3) + grain;
      picture.at(x, y) = Rgb8(light, light * 9 / 10, light * 7 / 10);
    }
  return encode_png(picture).value();
}

GltfFile file_of(const PlainMesh& mesh, Packing packing, int texture_side) {
  GltfFile file;
  file.json["meshes"][0]["primitives"] = nlohmann::json::array();
  file.json["materials"] = {{{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0.9}}}}};
  if (texture_side > 0) {
    file.add_picture(stone(texture_side));
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  }
  add_primitive(file, mesh, packing);
  file.primitive()["material"] = 0;
  return file;
}

// The bench's desk with another model, whose bytes are given back.
struct Desk {
  fs::path folder, config;
  explicit Desk(const std::string& name) : folder(content_folder("reduced-" + name)) {
    config = write_desk(folder / "desk");
  }
  fs::path model() const { return folder / "desk/temple.glb"; }
  void put(const GltfFile& file) const { ASSERT_TRUE(write_file(model(), file.binary())); }
  // What the kiosk gets; `out` what was said.
  fs::path unpacked(const std::string& options, std::string& out) const {
    const auto bundle = folder / "out.kasumi", to = folder / "unpacked";
    const auto told = run_kasumi(fmt::format("content pack {} --out {} {}", config.string(), bundle.string(), options));
    EXPECT_EQ(told.code, 0) << told.err;
    out = told.out;
    fs::remove_all(to);
    fs::create_directories(to);
    const auto looked = look_into(bundle);
    EXPECT_TRUE(looked) << looked.error().message;
    if (looked) {
      EXPECT_TRUE(unpack(*looked, to));
    }
    return to;
  }
};

Image<Rgb8> drawn(GlContext& context, const Content& content, const Direction& sun, bool with_model = true) {
  auto installation = content.config.installation;
  installation.scene_quality = {};
  SkyReport report;
  report.sun.source = SunSource::ephemeris;
  report.sun.direction = glm::normalize(sun);
  report.estimate.sky = SkyCondition::clear;
  Frame frame;
  frame.metadata.format = four_cc("RGB3");
  frame.metadata.width = kPictureWidth;
  frame.metadata.height = kPictureHeight;
  frame.metadata.stride = 3 * kPictureWidth;
  std::vector<std::uint8_t> grey(3 * kPictureWidth * kPictureHeight, 150);
  frame.metadata.bytes_used = static_cast<std::uint32_t>(grey.size());
  frame.payload = payload_of(std::move(grey));
  if (!with_model) installation.object.placement.up_m = -1e6;
  auto compositor = Compositor::create(context, installation, *content.model, AirRendering{});
  EXPECT_TRUE(compositor) << compositor.error().message;
  auto target = Offscreen::create(context.info(), kPictureWidth, kPictureHeight);
  EXPECT_TRUE(target && compositor->draw(frame, report, target->target()));
  return target->read().value_or(Image<Rgb8>());
}

// The greatest of these suns: mean absolute difference over the pixels that show the building, of 255.
double loss_of(const fs::path& original, const fs::path& reduced, const std::vector<Direction>& suns) {
  const auto context = must(open_headless_context());
  const auto before = must(read_content(original)), after = must(read_content(reduced));
  double greatest = 0.0;
  for (const auto& sun : suns) {
    const auto one = drawn(**context, **before, sun), other = drawn(**context, **after, sun),
               without = drawn(**context, **after, sun, false);
    double sum = 0.0;
    int values = 0;
    for (std::size_t i = 0; i < one.elements().size(); ++i)
      for (int c = 0; c < 3; ++c) {
        const auto apart = [&](const Image<Rgb8>& a, const Image<Rgb8>& b) {
          return std::abs(int(a.elements()[i][c]) - int(b.elements()[i][c]));
        };
        if (apart(one, without) <= 2 && apart(other, without) <= 2) continue;
        sum += apart(one, other);
        ++values;
      }
    EXPECT_GT(values, 1500) << "the building is hardly seen";
    greatest = std::max(greatest, sum / std::max(values, 1));
  }
  return greatest;
}

const Direction kMorning{0.7, -0.5, 0.4}, kEvening{-0.8, -0.3, 0.3};

Model model_in(const fs::path& folder, const std::string& scene = {}) {
  return loaded(read_gltf(folder / "temple.glb", {}, scene));
}

TEST(ModelReduction, ADenseModelIsReducedToWhatTheCameraShows) {
  const Desk desk("dense");
  desk.put(file_of(tower(330), Packing::none, 2048));
  const auto before = fs::file_size(desk.model());
  std::string out;
  const auto packed = desk.unpacked("", out);
  EXPECT_THAT(out, AllOf(HasSubstr("217800 -> "), HasSubstr("textures of 2048 -> "), HasSubstr("of 255 in the mean")));
  const Model reduced = model_in(packed);
  EXPECT_LT(reduced.triangle_count(), 21'780u);
  EXPECT_LE(reduced.textures.at(0).pixels.width(), 1024);
  EXPECT_GE(reduced.textures.at(0).pixels.width(), 128);
  EXPECT_LT(fs::file_size(packed / "temple.glb"), before / 10);
  EXPECT_LE(loss_of(desk.config, packed / "kasumi.toml", {kMorning, kEvening}), 0.3);
  // What is right stays as it is, byte for byte.
  const auto right = read_file(packed / "temple.glb").value();
  ASSERT_TRUE(write_file(desk.model(), right));
  const auto again = desk.unpacked("", out);
  EXPECT_THAT(out, Not(HasSubstr("reduced to")));
  EXPECT_EQ(read_file(again / "temple.glb").value(), right);
}

TEST(ModelReduction, WithKeepAllOrWithoutLossEveryByteStays) {
  const Desk desk("kept");
  desk.put(file_of(tower(330, true), Packing::none, 0));
  const auto whole = read_file(desk.model()).value();
  std::string out;
  EXPECT_EQ(read_file(desk.unpacked("--keep-all", out) / "temple.glb").value(), whole);
  EXPECT_THAT(out, Not(HasSubstr("reduced to")));
  EXPECT_EQ(read_file(desk.unpacked("--most-loss 0", out) / "temple.glb").value(), whole);
  EXPECT_THAT(out, AllOf(HasSubstr("packed as it is"), HasSubstr("reduced, it would lose")));
}

TEST(ModelReduction, AnOrdinaryModelStaysByteForByte) {
  const Desk desk("ordinary");
  std::string out;
  const auto packed = desk.unpacked("", out);
  EXPECT_EQ(read_file(packed / "temple.glb").value(), read_file(desk.model()).value());
  EXPECT_THAT(out, Not(HasSubstr("triangles")));
}

TEST(ModelReduction, WhereTheCameraDoesNotSeeItNothingIsReduced) {
  const Desk desk("unseen");
  desk.put(file_of(tower(330), Packing::none, 0));
  const auto whole = read_file(desk.model()).value();
  replace_in(desk.config, "[object]\n", "[object]\n# turned away\n");
  auto text = read_text_file(desk.config).value();
  const auto north = text.find("north_m = ", text.find("[object]"));
  ASSERT_NE(north, std::string::npos);
  text.insert(north + 10, "-");
  ASSERT_TRUE(write_text_file(desk.config, text));
  std::string out;
  EXPECT_EQ(read_file(desk.unpacked("", out) / "temple.glb").value(), whole);
  EXPECT_THAT(out, HasSubstr("the scene camera does not see it"));
}

// A copy beside it, by Draco; on a joint, by meshopt.
TEST(ModelReduction, CopiesSkinsAndCompressionStandWhereTheyStood) {
  for (const bool skinned : {false, true}) {
    const Desk desk(skinned ? "skinned" : "copied");
    auto file = file_of(tower(330), skinned ? Packing::meshopt : Packing::draco, 0);
    if (skinned) {
      file.node()["skin"] = 0;
      file.json["nodes"].push_back({{"translation", {8, 4, 0}}, {"scale", {.8, .8, .8}}});
      file.json["scenes"][0]["nodes"] = {0, 1};
      file.json["skins"] = {{{"joints", {1}}}};
      const std::size_t vertices = 331 * 331;
      std::vector<float> weights;
      for (std::size_t i = 0; i < vertices; ++i) weights.insert(weights.end(), {1, 0, 0, 0});
      const std::vector<std::uint8_t> joints(4 * vertices, 0);
      file.primitive()["attributes"]["JOINTS_0"] = file.add(joints.data(), joints.size(), 5121, "VEC4", vertices);
      file.primitive()["attributes"]["WEIGHTS_0"] = file.add_floats(weights, 4);
    } else {
      file.node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
          {"TRANSLATION", file.add_floats({0, 0, 0, 45, 0, 0}, 3)}};
      file.json["extensionsUsed"].push_back("EXT_mesh_gpu_instancing");
    }
    desk.put(file);
    const Model before = model_in(desk.folder / "desk");
    std::string out;
    const auto packed = desk.unpacked("", out);
    EXPECT_THAT(out, HasSubstr("reduced to"));
    const Model after = model_in(packed);
    EXPECT_LT(after.triangle_count(), before.triangle_count() / 4);
    EXPECT_LT(glm::distance(after.bounds().lowest, before.bounds().lowest), 0.5f);
    EXPECT_LT(glm::distance(after.bounds().highest, before.bounds().highest), 0.5f);
    EXPECT_LE(loss_of(desk.config, packed / "kasumi.toml", {kMorning}), 0.3);
  }
}

// A .gltf with a buffer of its own, two eras of it, and a third scene that is not shown.
TEST(ModelReduction, EveryEraKeepsItsSceneAndNothingElseIsPacked) {
  const Desk desk("eras");
  auto file = file_of(tower(330), Packing::none, 0);
  file.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"scale", {1, .5, 1}}}, {{"mesh", 0}, {"scale", {.1, .1, .1}}}};
  file.json["scenes"] = {{{"name", "ruin"}, {"nodes", {1}}}, {{"name", "toy"}, {"nodes", {2}}}, {{"nodes", {0}}}};
  file.json["buffers"] = {{{"byteLength", file.buffer.size()}, {"uri", "tower.bin"}}};
  ASSERT_TRUE(write_file(desk.folder / "desk/tower.bin", file.buffer));
  ASSERT_TRUE(write_text_file(desk.folder / "desk/tower.gltf", file.json.dump()));
  ASSERT_TRUE(
      write_text_file(desk.config, read_text_file(desk.config).value() +
                                       "\n[[era]]\nname = \"winter\"\ndates = \"10-01..03-31\"\n"
                                       "model = \"tower.gltf\"\nscene = \"2\"\n"
                                       "[[era]]\nname = \"summer\"\nmodel = \"tower.gltf\"\nscene = \"ruin\"\n"));
  std::string out;
  const auto packed = desk.unpacked("", out);
  EXPECT_THAT(out, HasSubstr("tower.gltf: reduced to"));
  EXPECT_FALSE(fs::exists(packed / "tower.bin"));
  const auto whole = loaded(read_gltf(packed / "tower.gltf", {}, "2")),
             half = loaded(read_gltf(packed / "tower.gltf", {}, "ruin"));
  EXPECT_NEAR(whole.bounds().highest.y, 40.0f, 0.5f);
  EXPECT_NEAR(half.bounds().highest.y, 20.0f, 0.5f);
  EXPECT_LT(whole.triangle_count(), 60'000u);
  const auto toy = read_gltf(packed / "tower.gltf", {}, "toy");
  EXPECT_FALSE(toy) << "it is shown in no era";
}

}  // namespace
}  // namespace kasumi

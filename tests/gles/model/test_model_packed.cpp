// Compressed models: they show what the same model shows uncompressed, and what is damaged or lies is refused before
// anything is taken for it.
#include <cmath>
#include <cstring>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "gles/model/model.hpp"
#include "gles/model/model_picture.hpp"
#include "gles/model/rare_models.hpp"
#include "tests/gles/model/packed_files.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// A dome of (steps + 1)^2 vertices.
PlainMesh dome(int steps) {
  PlainMesh mesh;
  for (int y = 0; y <= steps; ++y)
    for (int x = 0; x <= steps; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(steps);
      const float v = static_cast<float>(y) / static_cast<float>(steps);
      const glm::vec3 at(8.0f * u - 4.0f, 3.0f * std::cos(2.0f * u - 1.0f) * std::cos(2.0f * v - 1.0f),
                         8.0f * v - 4.0f);
      const glm::vec3 normal = glm::normalize(glm::vec3(at.x, 6.0f, at.z));
      mesh.positions.insert(mesh.positions.end(), {at.x, at.y, at.z});
      mesh.normals.insert(mesh.normals.end(), {normal.x, normal.y, normal.z});
      mesh.texture.insert(mesh.texture.end(), {u, v});
    }
  const auto at = [&](int x, int y) { return static_cast<std::uint32_t>(y * (steps + 1) + x); };
  for (int y = 0; y < steps; ++y)
    for (int x = 0; x < steps; ++x)
      for (const std::uint32_t i : {at(x, y), at(x, y + 1), at(x + 1, y + 1), at(x, y), at(x + 1, y + 1), at(x + 1, y)})
        mesh.indices.push_back(i);
  return mesh;
}

GltfFile file_of(const PlainMesh& mesh, Packing packing, int draco_bits = 14) {
  GltfFile file;
  file.json["meshes"][0]["primitives"] = nlohmann::json::array();
  file.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorFactor", {.5, .5, .5, 1}}}}}};
  add_primitive(file, mesh, packing, draco_bits);
  file.primitive()["material"] = 0;
  return file;
}

// Where each triangle's middle lies, in an order that does not depend on that of the file.
std::vector<std::array<float, 3>> middles(const Model& model) {
  std::vector<std::array<float, 3>> found;
  for (const ModelPart& part : model.parts)
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      glm::vec3 sum{0};
      for (std::size_t c = 0; c < 3; ++c) sum += part.vertices[part.indices[i + c]].position / 3.0f;
      found.push_back({std::round(sum.x * 50.0f) / 50.0f, std::round(sum.z * 50.0f) / 50.0f, sum.y});
    }
  std::ranges::sort(found);
  return found;
}

TEST(PackedModel, DracoHasTheSameTrianglesWhetherRequiredOrOnlyUsed) {
  const PlainMesh mesh = dome(30);
  const auto plain = middles(loaded(file_of(mesh, Packing::none).read("plain")));
  ASSERT_EQ(plain.size(), 1800u);
  for (const bool required : {true, false}) {
    GltfFile file = file_of(mesh, Packing::draco, 16);
    if (!required) {
      file.json["extensionsUsed"] = file.json["extensionsRequired"];
      file.json.erase("extensionsRequired");
    }
    const Model model = loaded(file.read("draco"));
    const auto packed = middles(model);
    ASSERT_EQ(packed.size(), plain.size());
    for (std::size_t i = 0; i < plain.size(); ++i) EXPECT_NEAR(packed[i][2], plain[i][2], 2e-3f) << i;
    EXPECT_THAT(model.notes, testing::IsEmpty());
    EXPECT_THAT(model.extensions, testing::ElementsAre("KHR_draco_mesh_compression"));
    for (const ModelVertex& vertex : model.parts.at(0).vertices) ASSERT_GT(vertex.normal.y, 0.5f);
  }
}

TEST(PackedModel, ADamagedDracoMeshIsTakenFromItsUnpackedCopyAndThatIsSaid) {
  GltfFile file = file_of(dome(4), Packing::none);
  const auto stream = draco_stream(dome(4), 14);
  const int bytes = file.add_bytes({stream.begin(), stream.begin() + 30});
  file.primitive()["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", file.json["accessors"][static_cast<std::size_t>(bytes)]["bufferView"]},
      {"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"TEXCOORD_0", 2}}}};
  const Model model = loaded(file.read("copy"));
  EXPECT_EQ(model.triangle_count(), 32u);
  EXPECT_THAT(model.notes, testing::ElementsAre(HasSubstr("its unpacked copy is taken")));
}

TEST(PackedModel, MeshoptHasTheSameNumbers) {
  const PlainMesh mesh = dome(30);
  const Model plain = loaded(file_of(mesh, Packing::none).read("plain"));
  const GltfFile file = file_of(mesh, Packing::meshopt);
  const auto path = model_folder() / "meshopt.glb";
  const auto binary = file.binary();
  ASSERT_TRUE(write_file(path, binary));
  for (const auto& read : {file.read("meshopt"), read_gltf(path)}) {
    const Model model = loaded(read);
    ASSERT_EQ(model.parts.size(), 1u);
    ASSERT_EQ(model.parts[0].indices.size(), plain.parts[0].indices.size());
    ASSERT_EQ(model.parts[0].vertices.size(), plain.parts[0].vertices.size());
    for (std::size_t i = 0; i < plain.parts[0].vertices.size(); ++i) {
      ASSERT_EQ(model.parts[0].vertices[i].position, plain.parts[0].vertices[i].position);
      ASSERT_EQ(model.parts[0].vertices[i].normal, plain.parts[0].vertices[i].normal);
    }
    EXPECT_EQ(middles(model), middles(plain));  // the codec may turn a triangle's corners round
  }
}

// Made by meshoptimizer 1.3: 24 elements of a float, two 16-bit numbers and four bytes, in all three kinds of channels.
constexpr std::uint8_t kVersion1[]{
    0xa1, 0x68, 0x77, 0xa5, 0x01, 0x02, 0x01, 0x07, 0x0f, 0x06, 0x0f, 0xf8, 0xf4, 0xc4, 0xf2, 0x62, 0xe2, 0x62,
    0xd0, 0x30, 0x18, 0xfc, 0xdd, 0xdd, 0x00, 0x00, 0x1e, 0x03, 0x07, 0x03, 0x00, 0x58, 0x58, 0x58, 0x58, 0x58,
    0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58, 0x58,
    0x05, 0x2a, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0x00, 0x00, 0x00, 0x90, 0x90, 0x90, 0x90, 0x90, 0x90, 0x90, 0x90,
    0x90, 0x90, 0x90, 0x90, 0x90, 0x90, 0x90, 0x90, 0x90, 0x90, 0x90, 0x90, 0x90, 0x90, 0x90, 0x05, 0x15, 0x55,
    0x55, 0x55, 0x55, 0x55, 0x00, 0x00, 0x06, 0x02, 0x23, 0x22, 0x32, 0x23, 0x22, 0x32, 0x23, 0xae, 0xba, 0x00,
    0x00, 0x03, 0x03, 0x05, 0x2a, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0xfa, 0x00, 0xe8, 0xfd, 0x00, 0x00, 0x07, 0x00, 0x52, 0x01, 0x00};

TEST(PackedModel, MeshoptsNewerVertexStreamsAreRead) {
  const auto models = must(rare_models());
  const auto bytes = must((*models)->meshopt_view(kVersion1, {"ATTRIBUTES", "", 24, 12}, 1 << 20));
  for (std::size_t i = 0; i < 24; ++i) {
    const auto* at = bytes->data() + 12 * i;
    float first = 0;
    std::uint16_t second = 0, third = 0;
    std::memcpy(&first, at, 4);
    std::memcpy(&second, at + 4, 2);
    std::memcpy(&third, at + 6, 2);
    EXPECT_EQ(first, 0.25f * static_cast<float>(i));
    EXPECT_EQ(second, (250 + 300 * i) % 65536);
    EXPECT_EQ(third, (65000 + 200 * i) % 65536);
    EXPECT_THAT(std::vector<int>(at + 8, at + 12), testing::ElementsAre(i % 3, i, 7, 0));
  }
  for (std::size_t cut = 0; cut < sizeof kVersion1; ++cut)
    EXPECT_FALSE((*models)->meshopt_view(std::span(kVersion1).first(cut), {"ATTRIBUTES", "", 24, 12}, 1 << 20)) << cut;
}

// Decoded by meshoptimizer 1.3's reference: red .5 .25 opaque, and 0 .2 .9 half transparent.
TEST(PackedModel, MeshoptsColourFilterIsRead) {
  // The encoder of version 0 packs bytes as they are, so a stream can be made here.
  const std::vector<std::uint8_t> filtered{0x90, 0x5f, 0xf1, 0xff, 0x53, 0x8d, 0xe0, 0xc0};
  GltfFile file = file_of(dome(1), Packing::none);
  const auto models = must(rare_models());
  std::vector<std::uint8_t> stream{0xa0, 0x03, 0x03, 0x03, 0x03};
  stream.clear();
  // One header of 16 verbatim deltas for each of four bytes: from the first element, which stands at the end.
  stream.push_back(0xa0);
  for (std::size_t c = 0; c < 4; ++c) {
    stream.push_back(0x03);
    stream.push_back(0);
    const auto by = static_cast<std::int8_t>(filtered[4 + c] - filtered[c]);
    stream.push_back(static_cast<std::uint8_t>(by >= 0 ? 2 * by : -2 * by - 1));
    stream.insert(stream.end(), 14, 0);
  }
  stream.insert(stream.end(), 28, 0);
  stream.insert(stream.end(), filtered.begin(), filtered.begin() + 4);
  const auto colours = must((*models)->meshopt_view(stream, {"ATTRIBUTES", "COLOR", 2, 4}, 1 << 20));
  const std::vector<int> meant{255, 128, 64, 255, 0, 51, 230, 128};
  for (std::size_t i = 0; i < meant.size(); ++i) EXPECT_NEAR((*colours)[i], meant[i], 2) << i;
}

TEST(PackedModel, WebpIsReadAsItsPixelsAre) {
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 12 * 7; ++i)
    for (const int c : {3 * i, 255 - i, 7 * i % 256, 255}) rgba.push_back(static_cast<std::uint8_t>(c));
  const auto webp = webp_file(rgba, 12, 7);
  GltfFile file = file_of(dome(2), Packing::none);
  file.json["extensionsRequired"] = {"EXT_texture_webp"};
  file.json["images"] = {{{"uri", "data:image/webp;base64," + base64(webp)}}};
  file.json["textures"] = {{{"extensions", {{"EXT_texture_webp", {{"source", 0}}}}}}};
  file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
  const Model model = loaded(file.read("webp"));
  ASSERT_EQ(model.textures.size(), 1u);
  const auto& texels = model.textures[0].pixels.elements();
  ASSERT_EQ(texels.size(), 84u);
  EXPECT_EQ(0, std::memcmp(texels.data(), rgba.data(), rgba.size()));
  EXPECT_THAT(model.notes, testing::IsEmpty());
}

TEST(PackedModel, AWebpOfAMillionTimesItsBytesIsRefusedByItsHeader) {
  auto webp = webp_file(std::vector<std::uint8_t>(16 * 16 * 4, 200), 16, 16);
  const auto whole = decode_picture(webp, 4096);
  ASSERT_TRUE(whole) << whole.error().message;
  // 14 bits each way, minus one, behind the lossless signature.
  for (const std::size_t at : {21u, 22u, 23u}) webp[at] = 0xff;
  EXPECT_THAT(decode_picture(webp, 4096).error().message, HasSubstr("expected 1 .. 4096"));
  webp.resize(webp.size() / 2);
  EXPECT_FALSE(decode_picture(webp, 16384));
}

TEST(PackedModel, EachFalseClaimIsRefusedByName) {
  struct Claim {
    std::string what;
    Packing packing;
    std::function<void(GltfFile&)> apply;
    std::string answer;
  };
  const auto packed = [](GltfFile& f) -> nlohmann::json& {
    return f.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
  };
  const auto stream = [](GltfFile& f) -> nlohmann::json& { return f.json["bufferViews"][0]; };
  const std::vector<Claim> claims{
      {"a Draco stream cut short", Packing::draco,
       [&](GltfFile& f) { stream(f)["byteLength"] = stream(f)["byteLength"].get<int>() / 2; }, "Draco"},
      {"a Draco stream of nothing", Packing::draco, [&](GltfFile& f) { stream(f)["byteLength"] = 3; },
       "not a Draco mesh"},
      {"a Draco stream of two thousand million triangles", Packing::draco,
       [](GltfFile& f) {  // the traversal's kind, then two numbers of up to five bytes
         for (const std::size_t at : {12u, 13u, 14u, 15u, 17u, 18u, 19u, 20u}) f.buffer[at] = 0xff;
         f.buffer[16] = f.buffer[21] = 0x07;
       },
       "expected 10000000 and 30000000 at most"},
      {"a Draco stream of nine million triangles in some hundred bytes", Packing::draco,
       [](GltfFile& f) {
         for (const std::size_t at : {12u, 16u}) {
           f.buffer[at] = f.buffer[at + 1] = f.buffer[at + 2] = 0xc0;
           f.buffer[at + 3] = 0x04;
         }
       },
       "bytes of Draco claim"},
      {"an attribute that the stream has not", Packing::draco,
       [](GltfFile& f) { f.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["NORMAL"] = 77; },
       "no attribute 77"},
      {"a Draco view that is not there", Packing::draco,
       [](GltfFile& f) { f.primitive()["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = 9; },
       "buffer view 9"},
      {"more meshopt elements than bytes can hold", Packing::meshopt,
       [&](GltfFile& f) { packed(f)["count"] = 30000000; }, "bytes of meshopt claim"},
      {"a count that overflows", Packing::meshopt, [&](GltfFile& f) { packed(f)["count"] = 4e18; }, "at most"},
      {"a count below nothing", Packing::meshopt, [&](GltfFile& f) { packed(f)["count"] = -1; }, "at most"},
      {"a stride of seven bytes", Packing::meshopt, [&](GltfFile& f) { packed(f)["byteStride"] = 7; }, "of 7 bytes"},
      {"a stride of nothing", Packing::meshopt, [&](GltfFile& f) { packed(f)["byteStride"] = 0; }, "of 0 bytes"},
      {"no such mode", Packing::meshopt, [&](GltfFile& f) { packed(f)["mode"] = "POINTS"; }, "\"POINTS\""},
      {"no such filter", Packing::meshopt, [&](GltfFile& f) { packed(f)["filter"] = "MAGIC"; }, "\"MAGIC\""},
      {"a filter for other strides", Packing::meshopt, [&](GltfFile& f) { packed(f)["filter"] = "QUATERNION"; },
       "QUATERNION"},
      {"a stream beyond its buffer", Packing::meshopt, [&](GltfFile& f) { packed(f)["byteOffset"] = 1e9; },
       "bytes 1000000000"},
      {"a stream cut short", Packing::meshopt,
       [&](GltfFile& f) { packed(f)["byteLength"] = packed(f)["byteLength"].get<int>() - 9; }, "damaged meshopt"},
      {"a stream of no buffer", Packing::meshopt, [&](GltfFile& f) { packed(f)["buffer"] = 5; }, "buffer 5"},
  };
  for (const Claim& claim : claims) {
    GltfFile file = file_of(dome(6), claim.packing);
    ASSERT_TRUE(file.read("honest")) << claim.what << file.read("honest").error().message;
    claim.apply(file);
    const auto refused = file.read("lie");
    ASSERT_FALSE(refused) << claim.what;
    EXPECT_EQ(refused.error().kind, FaultKind::bad_input) << claim.what;
    EXPECT_THAT(refused.error().message, testing::AllOf(HasSubstr("lie.gltf"), HasSubstr(claim.answer))) << claim.what;
  }
}

TEST(PackedModel, UnpackedViewsCountTogether) {
  const GltfFile file = file_of(dome(30), Packing::meshopt);
  const std::size_t bytes = file.text().size();
  EXPECT_THAT(file.read("together", {.file_bytes = bytes}), FailsWith(HasSubstr("bytes at most")));
}

TEST(PackedModel, AttributesOfADracoMeshCountTogether) {
  GltfFile file = file_of(dome(30), Packing::draco);
  const std::size_t bytes = file.text().size() + 4096;
  ASSERT_TRUE(file.read("many", {.file_bytes = bytes * 4}));
  auto& attributes = file.primitive()["attributes"];
  auto& packed = file.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"];
  for (int set = 2; set < 60; ++set) {  // the same stream, again and again
    attributes[fmt::format("TEXCOORD_{}", set)] = attributes["TEXCOORD_0"];
    packed[fmt::format("TEXCOORD_{}", set)] = 2;
  }
  EXPECT_THAT(file.read("many", {.file_bytes = bytes * 4}).error().message, HasSubstr("bytes at most"));
}

// Whether the file asks for them or not: the library unpacks all.
TEST(PackedModel, ConstantAttributesOfADracoStreamAreBoundedBeforeTheyAreUnpacked) {
  constexpr std::uint32_t kVertices = 3000;
  const auto read = [&](int attributes, std::size_t most_bytes) {
    GltfFile file = file_of(dome(3), Packing::draco);
    const auto packed = constant_draco_stream(kVertices, attributes);
    EXPECT_FALSE(packed.empty());
    auto& view =
        file.json["bufferViews"]
                 [file.primitive()["extensions"]["KHR_draco_mesh_compression"]["bufferView"].get<std::size_t>()];
    view["byteOffset"] = file.buffer.size();
    view["byteLength"] = packed.size();
    file.buffer.insert(file.buffer.end(), packed.begin(), packed.end());
    const auto position = file.primitive()["attributes"]["POSITION"];
    file.primitive()["attributes"] = {{"POSITION", position}};
    file.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"] = {{"POSITION", 0}};
    return file.read("constant", {.file_bytes = most_bytes});
  };
  const auto whole = read(1, 1'000'000);
  EXPECT_TRUE(whole) << whole.error().message;
  EXPECT_THAT(read(20, 500'000),
              FailsWith(testing::AllOf(HasSubstr("vertices with 21 attributes"), HasSubstr("bytes at most"))));
}

// Bytes changed at random within the packed streams: a valid model or a message.
TEST(PackedModel, RandomDamageNeverCausesHarm) {
  std::mt19937_64 random(20260719);
  int refused = 0;
  for (const Packing packing : {Packing::draco, Packing::meshopt}) {
    const GltfFile sound = file_of(dome(6), packing);
    for (int round = 0; round < 600; ++round) {
      GltfFile file = sound;
      for (std::uint64_t i = 0; i <= random() % 4; ++i)
        file.buffer[random() % file.buffer.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
      const auto model = file.read("damaged", {.triangles = 100000, .vertices = 300000});
      refused += !model;
      if (model)
        ASSERT_TRUE(check(*model)) << round;
      else
        ASSERT_THAT(model.error().message, HasSubstr("damaged.gltf")) << round;
    }
  }
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace kasumi

// Files with false claims, and files nobody has tried before.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "base/files.hpp"
#include "gles/model/model.hpp"
#include "gles/model/model_picture.hpp"
#include "tests/gles/model/gltf_writer.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

struct Lie {
  std::string what;
  std::function<void(GltfFile&)> apply;
  std::string answer;
};

GltfFile dressed_square() {
  GltfFile file = square_file();
  file.primitive()["attributes"]["NORMAL"] = file.add_floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
  file.primitive()["attributes"]["TEXCOORD_0"] = file.add_floats({0, 0, 1, 0, 1, 1, 0, 1}, 2);
  std::vector<std::uint8_t> png;
  cv::imencode(".png", cv::Mat(4, 4, CV_8UC3, cv::Scalar(10, 20, 30)), png);
  file.add_picture(png);
  file.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  file.primitive()["material"] = 0;
  return file;
}

TEST(HostileModel, EachFalseClaimIsRefusedByName) {
  using J = nlohmann::json;
  const std::vector<Lie> lies{
      {"accessor beyond its view", [](GltfFile& f) { f.json["accessors"][0]["count"] = 5; },
       "POSITION (accessor 0): 5 elements"},
      {"accessor with a huge count", [](GltfFile& f) { f.json["accessors"][0]["count"] = 4000000000000ull; },
       "30000000 at most"},
      {"accessor offset beyond its view", [](GltfFile& f) { f.json["accessors"][0]["byteOffset"] = 1000; },
       "from byte 1000"},
      {"view beyond its buffer", [](GltfFile& f) { f.json["bufferViews"][0]["byteLength"] = 100000; },
       "covers bytes 0 + 100000"},
      {"view of no buffer", [](GltfFile& f) { f.json["bufferViews"][0]["buffer"] = 7; }, "buffer 7: there are 1"},
      {"accessor of no view", [](GltfFile& f) { f.json["accessors"][0]["bufferView"] = 99; }, "buffer view 99"},
      {"attribute of no accessor", [](GltfFile& f) { f.primitive()["attributes"]["POSITION"] = 99; },
       "accessor 99: there are"},
      {"index beyond the vertices",
       [](GltfFile& f) {
         f.primitive()["indices"] = f.add_shorts({0, 1, 4});
       },
       "index 4: there are 4"},
      {"indices of floats",
       [](GltfFile& f) {
         f.primitive()["indices"] = f.add_floats({0, 1, 2}, 1);
       },
       "component type 5126"},
      {"positions of two components",
       [](GltfFile& f) {
         f.primitive()["attributes"]["POSITION"] = f.add_floats({0, 0, 1, 0, 1, 1, 0, 1}, 2);
       },
       "of 2 components"},
      {"too few normals",
       [](GltfFile& f) {
         f.primitive()["attributes"]["NORMAL"] = f.add_floats({0, 0, 1}, 3);
       },
       "NORMAL has 1 elements for 4"},
      {"a position that is not a number",
       [](GltfFile& f) {
         f.primitive()["attributes"]["POSITION"] = f.add_floats({0, 0, 0, 1, 0, 0, 1, NAN, 0, 0, 1, 0}, 3);
       },
       "vertex 2: its position is not finite"},
      {"an infinite position",
       [](GltfFile& f) {
         f.primitive()["attributes"]["POSITION"] = f.add_floats({0, 0, 0, 1, 0, 0, 1, INFINITY, 0, 0, 1, 0}, 3);
       },
       "vertex 2: its position is not finite"},
      {"no positions", [](GltfFile& f) { f.primitive()["attributes"].erase("POSITION"); }, "no POSITION"},
      {"no triangles", [](GltfFile& f) { f.primitive()["mode"] = 1; }, "no triangles"},
      {"an unknown mode", [](GltfFile& f) { f.primitive()["mode"] = 12; }, "mode 12"},
      {"a node that is its own child", [](GltfFile& f) { f.node()["children"] = {0}; }, "its own ancestor"},
      {"nodes in a ring",
       [](GltfFile& f) {
         f.json["nodes"] = J::array({{{"children", {1}}}, {{"children", {2}}}, {{"children", {1}}, {"mesh", 0}}});
       },
       "its own ancestor"},
      {"a child with two parents",
       [](GltfFile& f) {
         f.json["nodes"] = J::array({{{"children", {1, 2}}}, {{"children", {2}}}, {{"mesh", 0}}});
       },
       "two parents"},
      {"a node that is not there", [](GltfFile& f) { f.node()["children"] = {8}; }, "node 8: there are 1"},
      {"a mesh that is not there", [](GltfFile& f) { f.node()["mesh"] = 8; }, "mesh 8: there are 1"},
      {"a material that is not there", [](GltfFile& f) { f.primitive()["material"] = 8; }, "material 8: there are 1"},
      {"a texture that is not there",
       [](GltfFile& f) { f.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 8; },
       "texture 8: there are 1"},
      {"an image that is not there", [](GltfFile& f) { f.json["textures"][0]["source"] = 8; }, "8"},
      {"an image beyond its buffer",
       [](GltfFile& f) {
         f.json["images"][0] = {{"mimeType", "image/png"}, {"bufferView", f.json["bufferViews"].size()}};
         f.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 8}, {"byteLength", 100000}});
       },
       "images 0: its buffer view does not lie within a buffer"},
      {"an image that is none", [](GltfFile& f) { f.json["images"][0]["uri"] = "data:image/png;base64,AAAA"; },
       "image 0"},
      {"an image half there",
       [](GltfFile& f) {
         auto& uri = f.json["images"][0]["uri"].get_ref<std::string&>();
         uri.resize(uri.size() / 8 * 4 + 2);
       },
       "image 0"},
      {"a rotation of no length",
       [](GltfFile& f) {
         f.node()["rotation"] = {0, 0, 0, 0};
       },
       "rotation is (0, 0, 0, 0)"},
      {"a place beyond the map",
       [](GltfFile& f) {
         f.node()["translation"] = {1e12, 0, 0};
       },
       "from the model's origin"},
      {"AVIF alone",
       [](GltfFile& f) {
         f.json["extensionsRequired"] = {"EXT_meshopt_compression", "EXT_texture_avif"};
         f.json["textures"][0] = {{"extensions", {{"EXT_texture_avif", {{"source", 0}}}}}};
       },
       "EXT_texture_avif"},
      {"glTF 1", [](GltfFile& f) { f.json["asset"]["version"] = "1.0"; }, "version \"1.0\""},
      {"no asset", [](GltfFile& f) { f.json.erase("asset"); }, "version \"\""},
      {"sparse beyond the end",
       [](GltfFile& f) {
         f.json["accessors"][0]["sparse"] = {
             {"count", 1},
             {"indices", {{"bufferView", 1}, {"byteOffset", 11}, {"componentType", 5123}}},
             {"values", {{"bufferView", 0}}}};
       },
       "sparse"},
      {"sparse of an element not there",
       [](GltfFile& f) {
         const int i = f.add_shorts({9});
         f.json["accessors"][0]["sparse"] = {
             {"count", 1},
             {"indices", {{"bufferView", f.json["accessors"][i]["bufferView"]}, {"componentType", 5123}}},
             {"values", {{"bufferView", 0}}}};
       },
       "element 9"},
      {"deep nesting", [](GltfFile& f) { f.json["extras"] = J::parse(std::string(500, '[') + std::string(500, ']')); },
       "nested 50"},
  };
  for (const Lie& lie : lies) {
    GltfFile file = dressed_square();
    ASSERT_TRUE(file.read("honest"));
    lie.apply(file);
    const auto refused = file.read("lie");
    ASSERT_FALSE(refused) << lie.what;
    EXPECT_EQ(refused.error().kind, FaultKind::bad_input) << lie.what;
    EXPECT_THAT(refused.error().message, testing::AllOf(HasSubstr("lie.gltf"), HasSubstr(lie.answer))) << lie.what;
  }
}

TEST(HostileModel, DeepNestingDoesNotOverflowTheStack) {
  const auto path = model_folder() / "deep.gltf";
  const std::string deep =
      R"({"asset":{"version":"2.0"},"extras":)" + std::string(2000000, '[') + std::string(2000000, ']') + "}";
  ASSERT_TRUE(write_text_file(path, deep));
  EXPECT_THAT(read_gltf(path).error().message, HasSubstr("nested"));
}

TEST(HostileModel, LimitsAreEnforced) {
  const GltfFile file = dressed_square();
  EXPECT_THAT(file.read("limits", {.file_bytes = 100}).error().message, HasSubstr("expected 100 at most"));
  EXPECT_THAT(file.read("limits", {.triangles = 1}).error().message, HasSubstr("3 at most"));
  EXPECT_THAT(file.read("limits", {.vertices = 3}).error().message, HasSubstr("3 at most"));
  EXPECT_THAT(file.read("limits", {.nodes = 0}).error().message, HasSubstr("0 at most"));
  EXPECT_THAT(file.read("limits", {.texture_size = 2}).error().message, HasSubstr("expected 1 .. 2"));
  EXPECT_THAT(file.read("limits", {.texture_pixels = 15}).error().message, HasSubstr("15 pixels"));
  // A mesh used by many nodes counts once for each use.
  GltfFile many = square_file();
  for (int i = 1; i < 50; ++i) {
    many.json["nodes"].push_back({{"mesh", 0}});
    many.json["scenes"][0]["nodes"].push_back(i);
  }
  EXPECT_TRUE(many.read("limits", {.triangles = 100}));
  EXPECT_THAT(many.read("limits", {.triangles = 99}).error().message, HasSubstr("more than 99 triangles"));
}

// Some bytes of JSON may name the same data any number of times; each bomb took minutes or all memory.
TEST(HostileModel, WhatIsNamedOftenCountsAsOften) {
  using J = nlohmann::json;
  const auto copied = [](GltfFile& f) {
    f.json["accessors"].push_back({{"componentType", 5126}, {"type", "VEC3"}, {"count", 60}});  // of zeros
    f.node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = f.json["accessors"].size() - 1;
  };
  struct Bomb {
    std::string what;
    std::function<void(GltfFile&)> apply;
    ModelLimits just_enough, too_few;
    std::string answer;
  };
  const std::vector<Bomb> bombs{
      {"copies of points, which are not drawn",
       [&](GltfFile& f) {
         copied(f);
         f.json["meshes"][0]["primitives"].push_back({{"mode", 0}, {"attributes", f.primitive()["attributes"]}});
       },
       {.nodes = 120},
       {.nodes = 119},
       "2 primitives in 60 copies more than 119 are drawn"},
      {"copies of whole meshes", copied, {.triangles = 120}, {.triangles = 119}, "more than 119 triangles"},
      {"layers of one square", copied, {.covered = 30.0}, {.covered = 29.9}, "cover its box 30 times"},
      {"morph targets",
       [](GltfFile& f) {
         f.primitive()["targets"] = J(100, {{"POSITION", f.primitive()["attributes"]["POSITION"]}});
         f.json["meshes"][0]["weights"] = J(100, 0.01);
       },
       {.numbers = 2000},
       {.numbers = 1000},
       "the same ones too often"},
      {"skins",
       [](GltfFile& f) {
         f.json["accessors"].push_back({{"componentType", 5126}, {"type", "MAT4"}, {"count", 10}});
         f.json["skins"] = J(100, {{"joints", {0}}, {"inverseBindMatrices", f.json["accessors"].size() - 1}});
         for (int i = 1; i < 100; ++i) {
           f.json["nodes"].push_back({{"mesh", 0}, {"skin", i}});
           f.json["scenes"][0]["nodes"].push_back(i);
         }
       },
       {.numbers = 30000},
       {.numbers = 10000},
       "the same ones too often"},
      {"indices of no triangle",
       [](GltfFile& f) {
         J empty = f.primitive();
         empty["indices"] = f.add_bytes(std::vector<std::uint8_t>(1000));
         for (int i = 0; i < 50; ++i) f.json["meshes"][0]["primitives"].push_back(empty);
       },
       {.numbers = 60000},
       {.numbers = 50000},
       "the same ones too often"},
      {"one picture's bytes",
       [](GltfFile& f) { f.json["images"] = J(100, f.json["images"][0]); },
       {.all_bytes = 20000},
       {.all_bytes = 5000},
       "have more than 5000 bytes"},
      {"textures of one picture",
       [](GltfFile& f) {
         f.json["textures"] = J(100, f.json["textures"][0]);
         for (int i = 1; i < 100; ++i)
           f.json["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}}}}}});
       },
       {.all_bytes = 20000},
       {.all_bytes = 5000},
       "textures of more than 5000 bytes are decoded"},
      {"materials",
       [](GltfFile& f) { f.json["materials"] = J(50, f.json["materials"][0]); },
       {.materials = 50},
       {.materials = 49},
       "50 materials: expected 49 at most"},
      {"values of JSON",
       [](GltfFile& f) { f.json["extras"] = J(5000, J::array()); },
       {.json_values = 20000},
       {.json_values = 9000},
       "JSON of more than 9000 values"},
  };
  for (const Bomb& bomb : bombs) {
    GltfFile file = dressed_square();
    bomb.apply(file);
    const auto honest = file.read("named", bomb.just_enough);
    EXPECT_TRUE(honest) << bomb.what << ": " << honest.error().message;
    const auto refused = file.read("named", bomb.too_few);
    ASSERT_FALSE(refused) << bomb.what;
    EXPECT_EQ(refused.error().kind, FaultKind::bad_input) << bomb.what;
    EXPECT_THAT(refused.error().message, testing::AllOf(HasSubstr("named.gltf"), HasSubstr(bomb.answer))) << bomb.what;
  }
}

// Their number is the file's choice, and each is compared with all before.
TEST(HostileModel, NotesAreNoMoreThanArePrinted) {
  GltfFile file = dressed_square();
  file.primitive()["attributes"].erase("TEXCOORD_0");
  for (int i = 1; i < 500; ++i) {
    file.json["materials"].push_back(file.json["materials"][0]);
    file.json["materials"][i]["name"] = fmt::format("{} {}", i, std::string(5000, 'x'));
    file.json["meshes"][0]["primitives"].push_back(file.primitive());
    file.json["meshes"][0]["primitives"][i]["material"] = i;
  }
  const Model model = loaded(file.read("notes"));
  ASSERT_EQ(model.notes.size(), 101u);
  EXPECT_THAT(model.notes.back(), HasSubstr("more of its kind"));
  for (const std::string& note : model.notes) EXPECT_LT(note.size(), 1100u);
}

TEST(HostileModel, PictureHeadersAreCheckedBeforeAnythingIsDecoded) {
  std::vector<std::uint8_t> png;
  cv::imencode(".png", cv::Mat(4, 5, CV_8UC3, cv::Scalar(1, 2, 3)), png);
  EXPECT_TRUE(model_picture_size(png, 5)->is(5, 4));
  png[16] = 0x7f;  // claims 2 billion columns
  EXPECT_THAT(decode_picture(png, 4096).error().message, HasSubstr("expected 1 .. 4096"));
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", cv::Mat(40, 50, CV_8UC3, cv::Scalar(1, 2, 3)), jpeg);
  EXPECT_TRUE(model_picture_size(jpeg, 50)->is(50, 40));
  EXPECT_THAT(decode_picture(jpeg, 45).error().message, HasSubstr("50 x 40"));
  const auto decoded = decode_picture(jpeg, 4096);
  ASSERT_TRUE(decoded);
  EXPECT_NEAR(decoded->at(20, 20).r, 3, 2);
  EXPECT_EQ(decode_picture({}, 10).error().kind, FaultKind::bad_input);
}

// As some exporters write them: the lengths are mended, not believed.
TEST(HostileModel, AGlbWhoseChunksAreNotPaddedIsRead) {
  const std::vector<std::uint8_t> sound = dressed_square().binary();
  const auto path = model_folder() / "chunks.glb";
  const auto put = [](std::vector<std::uint8_t>& file, std::size_t at, std::size_t value) {
    for (std::size_t i = 0; i < 4; ++i) file[at + i] = static_cast<std::uint8_t>(value >> 8 * i);
  };
  const auto length = [&](std::size_t at) { return std::size_t{sound[at]} | std::size_t{sound[at + 1]} << 8; };
  const std::size_t chunk = 20 + length(12);
  for (const int extra : {1, 3}) {
    auto file = sound;
    file.insert(file.end(), static_cast<std::size_t>(extra), 0);
    put(file, chunk, sound.size() - chunk - 8 + static_cast<std::size_t>(extra));
    put(file, 8, file.size());
    ASSERT_TRUE(write_file(path, file));
    EXPECT_EQ(loaded(read_gltf(path)).triangle_count(), 2u) << extra;
  }
  for (const std::size_t claimed : {std::size_t{0}, chunk, sound.size() - 4}) {
    auto file = sound;
    put(file, 8, claimed);
    ASSERT_TRUE(write_file(path, file));
    EXPECT_EQ(loaded(read_gltf(path)).triangle_count(), 2u) << claimed;
  }
}

// What a file holds where a picture or a buffer should be says what to do.
TEST(HostileModel, PicturesOfOtherKindsAreRefusedWithWhatConvertsThem) {
  const auto answer = [](const std::string& name, std::string_view bytes) {
    EXPECT_TRUE(write_text_file(model_folder() / name, std::string(bytes)));
    GltfFile file = dressed_square();
    file.json["images"][0] = {{"uri", name}};
    const auto refused = file.read("pictures");
    return refused ? std::string("read") : refused.error().message;
  };
  const auto converted = [](const std::string& kind, const std::string& ending) {
    return testing::AllOf(HasSubstr("a picture of " + kind), HasSubstr("convert IN" + ending + " OUT.png"),
                          HasSubstr("imagemagick"));
  };
  EXPECT_THAT(answer("a.tga", std::string_view("\0\0\2\0\0\0\0\0\0\0\0\0\1\0\1\0\x18\0abc", 21)),
              converted("TGA", ".tga"));
  EXPECT_THAT(answer("a.psd", std::string_view("8BPS\0\1", 6)), converted("PSD", ".psd"));
  EXPECT_THAT(answer("a.bmp", std::string_view("BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\4\0\0\0\4\0\0\0", 26)),
              converted("BMP", ".bmp"));
  EXPECT_THAT(answer("a.avif", std::string_view("\0\0\0\x1c"
                                                "ftypavif\0\0\0\0avif",
                                                20)),
              converted("AVIF", ".avif"));
  EXPECT_THAT(answer("a.jpg", "version https://git-lfs.github.com/spec/v1\n"), HasSubstr("git lfs pull"));
  EXPECT_THAT(answer("b.jpg", "<!DOCTYPE html>"), HasSubstr("a web page"));
}

// Names as they stand in addresses, on disk or in the model.
TEST(HostileModel, NamesWithPlusAndPercentAreFound) {
  for (const auto& [on_disk, in_model] : {std::pair{"wall+roof.bin", "wall+roof.bin"},
                                          {"old%20wall.bin", "old%20wall.bin"},
                                          {"new wall.bin", "new%20wall.bin"},
                                          {"Third Wall.bin", "third%20wall.bin"}}) {
    GltfFile file = square_file();
    const auto folder = model_folder() / "names";
    std::filesystem::create_directories(folder);
    ASSERT_TRUE(write_file(folder / on_disk, file.buffer));
    file.json["buffers"] = {{{"uri", in_model}, {"byteLength", file.buffer.size()}}};
    ASSERT_TRUE(write_text_file(folder / "names.gltf", file.json.dump()));
    const auto model = read_gltf(folder / "names.gltf");
    EXPECT_TRUE(model) << in_model << ": " << model.error().message;
  }
}

TEST(HostileModel, AMissingFileIsReported) {
  EXPECT_FALSE(read_gltf(model_folder() / "not-there.glb"));
  const auto empty = model_folder() / "empty.glb";
  ASSERT_TRUE(write_text_file(empty, ""));
  EXPECT_THAT(read_gltf(empty).error().message, HasSubstr("empty.glb"));
  ASSERT_TRUE(write_text_file(empty, "glTF"));
  EXPECT_THAT(read_gltf(empty).error().message, HasSubstr("too few"));
}

// Bytes and tokens of a valid file changed at random: the result is a valid model or a message.
TEST(HostileModel, RandomDamageNeverCausesHarm) {
  std::mt19937_64 random(20260621);
  const std::vector<std::uint8_t> sound = dressed_square().binary();
  const std::string text = dressed_square().text();
  const std::vector<std::string> tokens{"-1", "4294967295", "1e99",       "null", "[]",
                                        "{}", "\"\"",       "2147483648", "0.5",  "99999999999999999999"};
  int loaded = 0, refused = 0;
  const auto path = model_folder() / "damaged.glb";
  for (int round = 0; round < 1500; ++round) {
    std::vector<std::uint8_t> file = sound;
    if (round % 3 == 0) {  // bits anywhere
      for (std::uint64_t i = 0; i <= random() % 4; ++i)
        file[random() % file.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
    } else if (round % 3 == 1) {  // a cut
      file.resize(random() % file.size());
    } else {  // a number of the JSON replaced
      std::string changed = text;
      std::vector<std::size_t> numbers;
      for (std::size_t i = 1; i < changed.size(); ++i)
        if (std::isdigit(static_cast<unsigned char>(changed[i])) &&
            (changed[i - 1] == ':' || changed[i - 1] == '[' || changed[i - 1] == ','))
          numbers.push_back(i);
      const std::size_t at = numbers[random() % numbers.size()];
      std::size_t end = at;
      while (end < changed.size() && (std::isdigit(static_cast<unsigned char>(changed[end])) || changed[end] == '.'))
        ++end;
      changed.replace(at, end - at, tokens[random() % tokens.size()]);
      file.assign(changed.begin(), changed.end());
    }
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(file.size()));
    const auto model = read_gltf(path);
    if (model) {
      ++loaded;
      ASSERT_TRUE(check(*model)) << round;
    } else {
      ++refused;
      ASSERT_THAT(model.error().message, HasSubstr("damaged.glb")) << round;
    }
  }
  EXPECT_GT(loaded, 30);
  EXPECT_GT(refused, 300);
}

TEST(HostileModel, EveryTestModelLoadsOrIsRefusedWithAMessage) {
  const std::filesystem::path root = "/usr/share/assimp/models";
  if (!std::filesystem::exists(root)) GTEST_SKIP() << "apt install assimp-testmodels";
  int loaded = 0, refused = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
    std::string extension = entry.path().extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension != ".gltf" && extension != ".glb") continue;
    const auto model = read_gltf(entry.path());
    if (model) {
      ++loaded;
      EXPECT_TRUE(check(*model)) << entry.path();
    } else {
      ++refused;
      EXPECT_THAT(model.error().message, HasSubstr(entry.path().filename().string()));
      EXPECT_GT(model.error().message.size(), entry.path().string().size() + 10);
    }
    RecordProperty(fmt::format("{}", entry.path().string().substr(root.string().size())),
                   model ? "loaded" : model.error().message);
  }
  RecordProperty("loaded", loaded);
  RecordProperty("refused", refused);
  EXPECT_GT(loaded, 20);
}

}  // namespace
}  // namespace kasumi

// content.toml: every fault is named with file and key; and whether a story's place is ever seen.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "pipeline/site/config/story_sight.hpp"
#include "pipeline/site/config/visitor_content.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// A wall 40 m wide and 20 m high at that z, facing +z, which is the model's south.
ModelPart wall_at(float z) {
  ModelPart wall;
  for (const glm::vec2 at : {glm::vec2(-20, 0), glm::vec2(20, 0), glm::vec2(20, 20), glm::vec2(-20, 20)})
    wall.vertices.push_back({.position = {at.x, at.y, z}});
  wall.indices = {0, 1, 2, 0, 2, 3};
  return wall;
}

struct VisitorContentOf : testing::Test {
  VisitorContentOf() {
    model.name = "temple.glb";
    model.parts = {wall_at(10.0F), wall_at(-10.0F)};
    model.nodes = {{"south_gate", {{-2, 0, 10}, {2, 4, 10}}}, {"north_gate", {{-2, 0, -10}, {2, 4, -10}}}};
    later = model;
    later.nodes.pop_back();
    models = {{"old", &model}, {"new", &later}};
  }
  Result<VisitorContent> read(const std::string& text) const {
    const auto file = test_output_folder() / "visitor" / "content.toml";
    std::filesystem::create_directories(file.parent_path());
    EXPECT_TRUE(write_text_file(file, text));
    return read_visitor_content(file, models);
  }
  Model model, later;
  std::vector<ModelInEra> models;
};

constexpr const char* kLanguages = "languages = [\"en\", \"de\"]\n";
constexpr const char* kTitleAndText =
    "title = { en = \"The gate\", de = \"Das Tor\" }\ntext = { en = \"Built.\", de = \"Gebaut.\" }\n";

TEST_F(VisitorContentOf, IsReadWhole) {
  const auto content = must(
      read(std::string(kLanguages) +
           "[[era]]\nname = \"old\"\ntitle.en = \"Before\"\ntitle.de = \"Vorher\"\n"
           "[[story]]\nname = \"gate\"\nnode = \"north_gate\"\n" +
           kTitleAndText + "[[story]]\nname = \"top\"\nplace_m = [1, 2.5, -3]\neras = [\"new\"]\n" + kTitleAndText));
  EXPECT_THAT(content->languages, testing::ElementsAre("en", "de"));
  ASSERT_EQ(content->eras.size(), 1U);
  EXPECT_EQ(content->eras[0].title.at("de"), "Vorher");
  ASSERT_EQ(content->stories.size(), 2U);
  const Story &gate = content->stories[0], &top = content->stories[1];
  EXPECT_EQ(gate.text.at("en"), "Built.");
  EXPECT_EQ(must(place_of(gate, model))->highest, glm::vec3(2, 4, -10));
  EXPECT_FALSE(place_of(gate, later)) << "its node is of the old building";
  EXPECT_EQ(must(place_of(top, later))->lowest, glm::vec3(1, 2.5, -3));
  EXPECT_TRUE(is_told_in(gate, "new") && is_told_in(top, "new") && !is_told_in(top, "old"));
}

TEST_F(VisitorContentOf, NamesEveryFaultAtOnce) {
  const auto refused =
      read(std::string(kLanguages) +
           "[[era]]\nname = \"odl\"\ntitle = { en = \"Before\", de = \" \" }\n"
           "[[story]]\nname = \"gate\"\nnode = \"south_gaet\"\ntitle = { en = \"Gate\" }\n"
           "text = { en = \"Built.\", de = \"Gebaut.\", fr = \"Fini.\" }\n"
           "[[story]]\nname = \"gate\"\nnode = \"south_gate\"\nplace_m = [1, 2, 3]\n" +
           kTitleAndText + "[[story]]\nname = \"top\"\nplace_m = [1, 2]\ntitel = 3\n" + kTitleAndText +
           "[[story]]\nname = \"bell\"\nnode = \"north_gate\"\neras = [\"old\", \"new\", \"nwe\"]\n" + kTitleAndText);
  EXPECT_THAT(
      refused,
      FailsAs(
          FaultKind::bad_input,
          AllOf(HasSubstr("content.toml: era[0].name = 'odl'"), HasSubstr("did you mean old?"),
                HasSubstr("era[0].title.de = ' ': expected a text in this language"),
                HasSubstr("story[0].node = 'south_gaet': expected the name of a node of temple.glb; did you mean "
                          "south_gate?"),
                HasSubstr("story[0].title.de is missing: expected a text in this language, which `languages` lists"),
                HasSubstr("story[0].text.fr: unknown key"),
                HasSubstr("story[1].name = 'gate': expected a name that no"),
                HasSubstr("story[1].node = 'south_gate': expected either the name of a node"),
                HasSubstr("story[2].place_m = [ 1, 2 ]: expected a list of 3 numbers"),
                HasSubstr("story[2].titel: unknown key; did you mean title?"), HasSubstr("did you mean new?"),
                HasSubstr("story[3].node = 'north_gate': expected the name of a node of temple.glb"))));
}

TEST_F(VisitorContentOf, LanguagesAreCodesAndWithoutThemTheRestIsNotReported) {
  for (const char* wrong : {"", "languages = []\n", "languages = [\"en\", \"en\"]\n", "languages = [\"English\"]\n",
                            "languages = [\"EN\"]\n"})
    EXPECT_THAT(read(std::string(wrong) + "[[story]]\nname = 3\n"),
                FailsWith(AllOf(HasSubstr("languages"), HasSubstr("codes of ISO 639"), Not(HasSubstr("story")))))
        << wrong;
}

TEST_F(VisitorContentOf, TextsAndStoriesAreBounded) {
  EXPECT_THAT(
      read(std::string(kLanguages) + "[[story]]\nname = \"a\"\nplace_m = [1, 2, 3]\n" +
           "title = { en = \"A\", de = \"A\" }\ntext = { de = \"B\", en = \"" + std::string(10'001, 'x') + "\" }\n"),
      FailsWith(AllOf(HasSubstr("story[0].text.en"), HasSubstr("expected 10000 bytes at most"))));
  std::string many = kLanguages;
  for (int i = 0; i < 201; ++i) many += "[[story]]\n";
  EXPECT_THAT(read(many), FailsWith(AllOf(HasSubstr("200 stories at most"), Not(HasSubstr("story[0]")))));
}

TEST_F(VisitorContentOf, WithoutErasNoneMayBeNamed) {
  models = {{"", &model}};
  EXPECT_THAT(read(std::string(kLanguages) + "[[era]]\nname = \"old\"\ntitle = { en = \"A\", de = \"A\" }\n"),
              FailsWith(HasSubstr("kasumi.toml has no [[era]]")));
}

// A camera that looks north at the two walls, 3.5 km away.
struct StorySeen : VisitorContentOf {
  StorySeen() {
    Camera& scene = kiosk.scene;
    scene.width = 600;
    scene.height = 400;
    scene.lens = pinhole_lens({{1000.0, 1000.0}, {299.5, 199.5}, {}});
    scene.to_world = camera_to_world(Radians{0.0}, Radians{0.0}, Radians{0.0});
    kiosk.site.altitude_m = 100.0;
    kiosk.object.placement.north_m = 3500.0;
  }
  std::string unseen(const glm::vec3& low, const glm::vec3& high) const {
    return why_unseen(kiosk, model, {low, high});
  }
  Installation kiosk;
};

TEST_F(StorySeen, OnTheNearWallAndNotBehindTheBuilding) {
  EXPECT_EQ(unseen({-2, 0, 10}, {2, 4, 10}), "");
  EXPECT_EQ(unseen({0, 5, 10}, {0, 5, 10}), "") << "a point of the surface";
  EXPECT_EQ(unseen({-2, 0, -10}, {2, 4, -10}), "it is behind the building");
  EXPECT_EQ(unseen({0, 5, 9}, {0, 5, 9}), "it is behind the building") << "a metre behind the surface";
  EXPECT_EQ(unseen({0, 15, -10}, {0, 25, -10}), "") << "its top looks over the wall";
  kiosk.object.placement.heading = from_degrees(180.0);  // turned round
  EXPECT_EQ(unseen({-2, 0, -10}, {2, 4, -10}), "");
  EXPECT_EQ(unseen({-2, 0, 10}, {2, 4, 10}), "it is behind the building");
}

TEST_F(StorySeen, OutsideThePictureItSaysWhere) {
  EXPECT_THAT(unseen({1500, 0, 10}, {1502, 4, 10}), HasSubstr("it is outside the picture"));
  kiosk.scene.to_world = camera_to_world(from_degrees(180.0), Radians{0.0}, Radians{0.0});
  EXPECT_THAT(unseen({-2, 0, 10}, {2, 4, 10}), HasSubstr("it is behind the scene camera"));
}

}  // namespace
}  // namespace kasumi

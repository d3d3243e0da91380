// content.toml from the desk to the kiosk: named, checked, packed, and its places kept in a model that is reduced.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/kiosk/content/packing.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/content/desk.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

struct StoriesPacked : testing::Test {
  void SetUp() override {
    config = write_desk(content_folder("stories") / "desk");
    ASSERT_TRUE(write_text_file(config, "content = \"content.toml\"\n" + read_text_file(config).value()));
  }
  void write(const std::string& stories) const {
    ASSERT_TRUE(write_text_file(config.parent_path() / "content.toml", "languages = [\"en\", \"de\"]\n" + stories));
  }
  std::filesystem::path config;
};

constexpr const char* kStory =
    "[[story]]\nname = \"hall\"\nnode = \"temple\"\ntitle = { en = \"Hall\", de = \"Halle\" }\n"
    "text = { en = \"It stood here.\", de = \"Hier stand sie.\" }\n";

TEST_F(StoriesPacked, TravelWithTheContent) {
  write(kStory);
  const auto bundle = packed(config, "told", kMonday);
  const auto inside = must(look_into(bundle));
  EXPECT_THAT(inside->manifest.files, testing::Contains(testing::Field(&PackedFile::path, "content.toml")));
  const Generations generations(bundle.parent_path() / "content");
  ended(0, run_kasumi(fmt::format("content install {} --unsigned --content {} --status {}", bundle.string(),
                                  generations.folder().string(), (bundle.parent_path() / "none.json").string())));
  const auto current = must(generations.current());
  const auto content = must(read_content(generations.folder_of(*current) / "kasumi.toml"));
  ASSERT_TRUE((*content)->visitor);
  EXPECT_EQ((*content)->visitor->stories.at(0).text.at("de"), "Hier stand sie.");
  // A file changed on the kiosk is found.
  ASSERT_TRUE(write_text_file(generations.folder_of(*current) / "content.toml", "languages = [\"en\"]\n"));
  EXPECT_THAT(ended(2, run_kasumi(fmt::format("content verify --content {}", generations.folder().string()))).err,
              HasSubstr("content.toml"));
}

TEST_F(StoriesPacked, AMissingTranslationIsNotPacked) {
  write(std::string(kStory) +
        "[[story]]\nname = \"gate\"\nnode = \"tempel\"\ntitle = { en = \"Gate\" }\n"
        "text = { en = \"Gone.\", de = \"Fort.\" }\n");
  const auto refused =
      ended(2, run_kasumi(fmt::format("content pack {0} --out {0}.kasumi --name told", config.string())));
  EXPECT_THAT(refused.err, AllOf(HasSubstr("content.toml: story[1].title.de is missing"),
                                 HasSubstr("content.toml: story[1].node = 'tempel'"), HasSubstr("did you mean temple?"),
                                 Not(HasSubstr("story[0]"))));
  EXPECT_FALSE(std::filesystem::exists(config.string() + ".kasumi"));
  EXPECT_THAT(ended(78, run_kasumi("run --check --config " + config.string())).err,
              HasSubstr("story[1].title.de is missing"));
}

TEST_F(StoriesPacked, WhatIsNeverSeenOrTooLongIsNamed) {
  std::string lines;
  for (int i = 0; i < 60; ++i) lines += "Another sentence that goes on. ";
  write(std::string(kStory) +
        "[[story]]\nname = \"far\"\nplace_m = [9000.0, 0.0, 0.0]\n"
        "title = { en = \"Far\", de = \"Fern\" }\ntext = { en = \"" +
        lines + "\", de = \"Kurz.\" }\n");
  const auto remarks =
      AllOf(HasSubstr("content.toml: story[1].place_m (far): never seen from the kiosk: it is outside"),
            HasSubstr("content.toml: story[1].text.en (far): "), HasSubstr("lines more than the panel shows"),
            Not(HasSubstr("story[0]")), Not(HasSubstr("text.de")));
  EXPECT_THAT(ended(0, run_kasumi("run --check --config " + config.string())).out, remarks);
  const auto made = must(pack({config, config.string() + ".kasumi", "told", kMonday, std::nullopt, {}}));
  EXPECT_THAT(fmt::format("{}", fmt::join(made->remarks, "\n")), remarks);
  EXPECT_THAT(run_kasumi("doctor --json --config " + config.string()).out,
              AllOf(HasSubstr("content.stories"), HasSubstr("story[1].place_m (far)")));
}

}  // namespace
}  // namespace kasumi

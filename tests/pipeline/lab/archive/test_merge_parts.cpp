// A merge takes the whole of one archive, and names what is missing, twice or strange.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "pipeline/lab/archive/merge_parts.hpp"
#include "tests/pipeline/lab/archive/made_archive.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Parts : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
  }
  std::filesystem::path part(const std::string& name, std::string_view text) const {
    std::ofstream(folder / name, std::ios::binary) << text;
    return folder / name;
  }
  static std::string problems_of(const std::vector<std::filesystem::path>& parts) {
    const auto whole = WholeArchive::prove(parts);
    return whole ? "none" : whole.error().message;
  }
  const std::filesystem::path folder = test_folder("merge-parts");
  const MadeArchive made{30};
};

TEST_F(Parts, AreOneInTheListsOrderWhateverTheirOrder) {
  const auto whole = WholeArchive::prove({part("c", made.records(21, 30)), part("a", made.records(1, 7)),
                                          part("empty", ""), part("b", made.records(8, 20))});
  ASSERT_TRUE(whole) << whole.error().message;
  std::string text;
  std::size_t number = 0;
  const auto taken = whole->for_each([&](std::string_view line, const nlohmann::json& record) -> Result<> {
    text += std::string(line) + "\n";
    EXPECT_EQ(record["archive"]["picture"], ++number);
    return {};
  });
  EXPECT_TRUE(taken);
  EXPECT_EQ(text, made.records(1, 30));
}

TEST_F(Parts, MissingPicturesAreNamed) {
  EXPECT_THAT(problems_of({part("a", made.records(1, 7)), part("b", made.records(9, 20))}),
              AllOf(HasSubstr("picture 8 of 30 is in no part"), HasSubstr("pictures 21 to 30 of 30")));
}

TEST_F(Parts, PicturesThatAreThereTwiceAreNamedWithBothParts) {
  EXPECT_THAT(problems_of({part("a", made.records(1, 20)), part("b", made.records(20, 30))}),
              AllOf(HasSubstr("b: line 1: picture 20"), HasSubstr("/a"), Not(HasSubstr("no part"))));
}

TEST_F(Parts, ATornPartIsNamed) {
  const auto text = made.records(21, 30);
  EXPECT_THAT(problems_of({part("a", made.records(1, 20)), part("b", text.substr(0, text.size() - 9))}),
              AllOf(HasSubstr("b: line 10 is torn"), HasSubstr("--resume")));
}

TEST_F(Parts, PartsOfOtherListsOrOptionsAreNamed) {
  const auto first = part("a", made.records(1, 29));
  const Archive same = made.archive();
  EXPECT_THAT(problems_of({first, part("b", archive_record("{}", {}, "", {30, {30, "0", same.options}}))}),
              HasSubstr("b: line 1 is of another list"));
  EXPECT_THAT(problems_of({first, part("b", archive_record("{}", {}, "", {30, {30, same.list, "0"}}))}),
              HasSubstr("b: line 1 was made with other options"));
}

TEST_F(Parts, WhatIsNoPartIsNamed) {
  EXPECT_THAT(problems_of({part("a", "image,utc\n")}), HasSubstr("a: line 1: expected a record"));
  EXPECT_THAT(problems_of({folder / "none"}), HasSubstr("none: cannot be read"));
  EXPECT_THAT(problems_of({part("a", "")}), HasSubstr("no part has any record"));
  EXPECT_THAT(problems_of({part("a", std::string(3 << 20, 'x'))}), HasSubstr("longer than any record"));
  EXPECT_THAT(problems_of({part("a", R"({"image":"a","archive":{"picture":1,"of":99999999999,"list":"","options":""}})"
                                     "\n")}),
              HasSubstr("expected a record"));
}

TEST_F(Parts, ADamagedRecordIsNamed) {
  auto text = made.records(1, 30);
  text[text.find("\"sigma\"", 900)] = '?';
  const auto whole = WholeArchive::prove({part("a", text)});
  ASSERT_TRUE(whole) << whole.error().message;
  const auto taken = whole->for_each([](std::string_view, const nlohmann::json&) { return Result<>(); });
  ASSERT_FALSE(taken);
  EXPECT_THAT(taken.error().message, HasSubstr("is no JSON"));
}

}  // namespace
}  // namespace kasumi

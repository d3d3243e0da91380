// [[cards]]: what is read of them, and one message for each mistake.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "pipeline/site/config/cards.hpp"

namespace kasumi {
namespace {

struct CardsOfFile {
  std::vector<LightCard> cards;
  std::string problems;
};
CardsOfFile cards_of(const std::string& keys) {
  const auto root = ConfigTable::parse("[[cards]]\n" + keys, "kasumi.toml").value();
  CardsOfFile all{read_cards(root, 640, 360), {}};
  if (const auto done = root.finish(); !done) all.problems = done.error().message;
  return all;
}

TEST(CardKeys, AreAWallOrALevelBoard) {
  const auto wall =
      cards_of("name = \"wall\"\nregion_px = [10, 20, 30, 40]\nreflectance = [0.42, 0.4, 0.36]\nfaces_deg = 90.0\n");
  ASSERT_EQ(wall.problems, "");
  ASSERT_EQ(wall.cards.size(), 1U);
  EXPECT_EQ(wall.cards[0].name, "wall");
  EXPECT_EQ(wall.cards[0].y, 20);
  EXPECT_EQ(wall.cards[0].height, 40);
  EXPECT_EQ(wall.cards[0].reflectance, glm::dvec3(0.42, 0.4, 0.36));
  EXPECT_NEAR(glm::distance(wall.cards[0].normal, Direction(1, 0, 0)), 0.0, 1e-9) << "to the east";
  const auto level = cards_of("region_px = [10, 20, 30, 40]\nreflectance = 0.18\nfaces_up_deg = 90\n");
  ASSERT_EQ(level.problems, "");
  EXPECT_EQ(level.cards[0].name, "card 1");
  EXPECT_EQ(level.cards[0].reflectance, glm::dvec3(0.18));
  EXPECT_NEAR(glm::distance(level.cards[0].normal, Direction(0, 0, 1)), 0.0, 1e-9);
  EXPECT_FALSE(level.cards[0].grey);
  const auto grey = cards_of("region_px = [10, 20, 30, 40]\nreflectance = \"grey\"\nfaces_deg = 15\n");
  ASSERT_EQ(grey.problems, "");
  EXPECT_TRUE(grey.cards[0].grey);
  EXPECT_EQ(grey.cards[0].reflectance, glm::dvec3(kGreyReflectance));
  const auto none = ConfigTable::parse("", "kasumi.toml").value();
  EXPECT_TRUE(read_cards(none, 640, 360).empty());
}

TEST(CardKeys, EachMistakeHasItsMessage) {
  using testing::HasSubstr;
  const std::string region = "region_px = [10, 20, 30, 40]\n", rest = "reflectance = 0.4\nfaces_deg = 15\n";
  EXPECT_THAT(cards_of("region_px = [620, 20, 30, 40]\n" + rest).problems,
              testing::AllOf(HasSubstr("region_px"), HasSubstr("within the scene camera's 640 x 360 pixels")));
  EXPECT_THAT(cards_of("region_px = [10, 20, 30, 0]\n" + rest).problems, HasSubstr("region_px"));
  EXPECT_THAT(cards_of(rest).problems, HasSubstr("region_px"));
  EXPECT_THAT(cards_of(region + "reflectance = 1.4\nfaces_deg = 15\n").problems, HasSubstr("reflectance"));
  EXPECT_THAT(cards_of(region + "reflectance = [0.4, 0.4]\nfaces_deg = 15\n").problems, HasSubstr("reflectance"));
  EXPECT_THAT(cards_of(region + "reflectance = \"white\"\nfaces_deg = 15\n").problems, HasSubstr("reflectance"));
  EXPECT_THAT(cards_of(region + "faces_deg = 15\n").problems, HasSubstr("reflectance"));
  EXPECT_THAT(cards_of(region + "reflectance = 0.4\n").problems, HasSubstr("faces_deg"));
  EXPECT_THAT(cards_of(region + rest + "faces_up_deg = 100\n").problems, HasSubstr("faces_up_deg"));
  EXPECT_THAT(cards_of(region + rest + "colour = 1\n").problems, HasSubstr("unknown key"));
}

}  // namespace
}  // namespace kasumi

#include <gtest/gtest.h>

#include "base/words/nearest_word.hpp"

namespace kasumi {
namespace {

TEST(NearestWord, CountsLettersThatAreWrong) {
  EXPECT_EQ(edit_distance("haze", "haze"), 0);
  EXPECT_EQ(edit_distance("hzae", "haze"), 1) << "swapped";
  EXPECT_EQ(edit_distance("haz", "haze"), 1);
  EXPECT_EQ(edit_distance("hazze", "haze"), 1);
  EXPECT_EQ(edit_distance("", "haze"), 4);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
}

TEST(NearestWord, IsFoundWhereItIsNearAndNotElsewhere) {
  const std::vector<std::string> words{"replay", "retarget", "reload", "run", "record", "estimate"};
  EXPECT_EQ(nearest_word("replya", words), "replay");
  EXPECT_EQ(nearest_word("Retraget", words), "retarget");
  EXPECT_EQ(nearest_word("esti", words), "estimate") << "the beginning of one word only";
  EXPECT_EQ(nearest_word("compare", words), "");
  EXPECT_EQ(nearest_word("xy", words), "");
  EXPECT_EQ(nearest_word("", words), "");
  EXPECT_EQ(nearest_word(std::string(100000, 'a'), words), "");
  EXPECT_EQ(did_you_mean("relaod", words), "; did you mean reload?");
}

}  // namespace
}  // namespace kasumi

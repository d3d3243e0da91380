// Which pictures a task of a job array takes, by the variables that each engine sets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "pipeline/lab/archive/shard.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using Set = std::map<std::string, std::string>;

Result<Shard> shard_in(const Set& set, const std::string& given = "") {
  return shard_of(given, [&](const char* name) { return set.contains(name) ? set.at(name).c_str() : nullptr; });
}

void expect_shard(const Result<Shard>& shard, std::size_t index, std::size_t count, const std::string& from) {
  ASSERT_TRUE(shard) << shard.error().message;
  EXPECT_EQ(shard->index, index);
  EXPECT_EQ(shard->count, count);
  EXPECT_EQ(shard->from, from);
}

// sbatch --array=1-40, and --array=0-90:10
TEST(Shard, IsSlurmsArrayTask) {
  expect_shard(
      shard_in({{"SLURM_ARRAY_TASK_ID", "3"}, {"SLURM_ARRAY_TASK_COUNT", "40"}, {"SLURM_ARRAY_TASK_MIN", "1"}}), 2, 40,
      "SLURM_ARRAY_TASK_ID");
  expect_shard(shard_in({{"SLURM_ARRAY_TASK_ID", "90"},
                         {"SLURM_ARRAY_TASK_COUNT", "10"},
                         {"SLURM_ARRAY_TASK_MIN", "0"},
                         {"SLURM_ARRAY_TASK_STEP", "10"}}),
               9, 10, "SLURM_ARRAY_TASK_ID");
}

TEST(Shard, IsKubernetesCompletionIndex) {
  expect_shard(shard_in({{"JOB_COMPLETION_INDEX", "0"}, {"JOB_COMPLETIONS", "8"}}), 0, 8, "JOB_COMPLETION_INDEX");
}

// qsub -t 2-20:2; outside of arrays Grid Engine sets "undefined".
TEST(Shard, IsGridEnginesTask) {
  expect_shard(
      shard_in({{"SGE_TASK_ID", "20"}, {"SGE_TASK_FIRST", "2"}, {"SGE_TASK_LAST", "20"}, {"SGE_TASK_STEPSIZE", "2"}}),
      9, 10, "SGE_TASK_ID");
  expect_shard(shard_in({{"SGE_TASK_ID", "undefined"}, {"SGE_TASK_FIRST", "undefined"}}), 0, 1, "");
}

TEST(Shard, WhatIsGivenGoesBeforeTheArray) {
  const Set slurm{{"SLURM_ARRAY_TASK_ID", "3"}, {"SLURM_ARRAY_TASK_COUNT", "40"}, {"SLURM_ARRAY_TASK_MIN", "1"}};
  expect_shard(shard_in(slurm, "2/5"), 1, 5, "--shard");
  expect_shard(shard_in({}), 0, 1, "");
}

TEST(Shard, HalfAPairIsAnErrorThatNamesTheOtherHalf) {
  const std::vector<std::pair<Set, std::string>> halves{
      {{{"SLURM_ARRAY_TASK_ID", "3"}, {"SLURM_ARRAY_TASK_MIN", "0"}}, "SLURM_ARRAY_TASK_COUNT"},
      {{{"SLURM_ARRAY_TASK_ID", "3"}, {"SLURM_ARRAY_TASK_COUNT", "40"}}, "SLURM_ARRAY_TASK_MIN"},
      {{{"JOB_COMPLETION_INDEX", "3"}}, "JOB_COMPLETIONS"},
      {{{"SGE_TASK_ID", "3"}, {"SGE_TASK_FIRST", "1"}}, "SGE_TASK_LAST"}};
  for (const auto& [set, missing] : halves) {
    const auto shard = shard_in(set);
    ASSERT_FALSE(shard) << missing;
    EXPECT_EQ(shard.error().kind, FaultKind::bad_input);
    EXPECT_THAT(shard.error().message, HasSubstr(missing));
  }
}

// --array=1,3,7 has three tasks, of which the last would be the seventh.
TEST(Shard, AnArrayWithGapsIsRefused) {
  const auto shard =
      shard_in({{"SLURM_ARRAY_TASK_ID", "7"}, {"SLURM_ARRAY_TASK_COUNT", "3"}, {"SLURM_ARRAY_TASK_MIN", "1"}});
  ASSERT_FALSE(shard);
  EXPECT_THAT(shard.error().message, HasSubstr("gaps"));
}

TEST(Shard, WrongOnesAreRefused) {
  for (const char* given : {"0/3", "4/3", "3", "/3", "1/", "a/b", "1/3x", "-1/3", "1/0"})
    EXPECT_FALSE(shard_in({}, given)) << given;
  EXPECT_FALSE(shard_in({{"JOB_COMPLETION_INDEX", "x"}, {"JOB_COMPLETIONS", "8"}}));
  EXPECT_FALSE(shard_in({{"JOB_COMPLETION_INDEX", "8"}, {"JOB_COMPLETIONS", "8"}}));
}

TEST(Shard, ShardsAreTheWholeListInOrderAndAlikeInSize) {
  for (const std::size_t size : {0ul, 1ul, 7ul, 40ul, 20001ul, (1ul << 62) + 3})
    for (const std::size_t count : {1ul, 3ul, 40ul}) {
      std::size_t next = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const Shard shard{i, count, {}};
        EXPECT_EQ(shard.first(size), next);
        EXPECT_GE(shard.size(size), size / count);
        EXPECT_LE(shard.size(size), size / count + 1);
        next += shard.size(size);
      }
      EXPECT_EQ(next, size);
    }
}

}  // namespace
}  // namespace kasumi

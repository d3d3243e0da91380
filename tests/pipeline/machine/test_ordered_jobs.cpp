#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <thread>

#include "pipeline/machine/ordered_jobs.hpp"

namespace kasumi {
namespace {

TEST(OrderedJobs, AnswersComeInTheOrderOfTheJobsWhateverTheirDuration) {
  for (const std::size_t threads : {1u, 2u, 7u}) {
    int given = 0;
    std::vector<int> answers;
    run_in_order<int, int>(
        threads, [&]() -> std::optional<int> { return given < 100 ? std::optional(given++) : std::nullopt; },
        [](std::size_t, const int& job) {
          if (job % 10 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
          return job * job;
        },
        [&](const int& job, const int& answer) {
          EXPECT_EQ(answer, job * job);
          answers.push_back(job);
        });
    ASSERT_EQ(answers.size(), 100u);
    EXPECT_TRUE(std::is_sorted(answers.begin(), answers.end()));
  }
}

TEST(OrderedJobs, AnAnswerIsDeliveredWhileTheNextJobIsAwaited) {
  // Like a program that writes one path and waits for the result before it writes the next.
  std::promise<void> first_answered;
  auto answered = first_answered.get_future();
  int given = 0;
  bool in_time = true;
  run_in_order<int, int>(
      2,
      [&]() -> std::optional<int> {
        if (given == 1) in_time = answered.wait_for(std::chrono::seconds(20)) == std::future_status::ready;
        return given < 2 ? std::optional(given++) : std::nullopt;
      },
      [](std::size_t, const int& job) { return job; },
      [&](const int& job, const int&) {
        if (job == 0) first_answered.set_value();
      });
  EXPECT_TRUE(in_time);
}

}  // namespace
}  // namespace kasumi

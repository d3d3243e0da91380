// Runs a test program's tests. What its process and the programs it started took of the processors stands in the results
// (processor_s), which tests/summary reads.
#include <cstdio>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>

#include "tests/made_once.hpp"

namespace {

double spent_s(int who) {
  rusage use{};
  ::getrusage(who, &use);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(use.ru_utime) + seconds(use.ru_stime);
}

class ProcessorTime : public testing::Environment {
  void TearDown() override {
    char text[32];
    std::snprintf(text, sizeof text, "%.2f", spent_s(RUSAGE_SELF) + spent_s(RUSAGE_CHILDREN));
    testing::Test::RecordProperty("processor_s", text);
  }
};

}  // namespace

int main(int count, char** arguments) {
  ::setenv("KASUMI_SKY_TABLES", kasumi::made_once_store().c_str(), 0);
  testing::InitGoogleMock(&count, arguments);
  testing::AddGlobalTestEnvironment(new ProcessorTime);
  return RUN_ALL_TESTS();
}

// Runs a test program's tests. What its process and the programs it started took of the processors stands in the results
// (processor_s), which tests/summary reads. A test that ends its process by a fault is named: it prints no result.
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <unistd.h>

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

// The running test's name, for the handler of a fault, which can do little more than write.
char running[256] = "no test";

class RunningTest : public testing::EmptyTestEventListener {
  void OnTestStart(const testing::TestInfo& test) override {
    std::snprintf(running, sizeof running, "%s.%s", test.test_suite_name(), test.name());
  }
};

void name_test(int signal) {
  for (const char* text : {"The program ends by a fault in ", static_cast<const char*>(running), "\n"})
    if (::write(STDERR_FILENO, text, std::strlen(text)) < 0) break;
  ::raise(signal);  // as if it had not been handled
}

void name_faults() {
  for (const int fault : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
    struct sigaction action {};
    action.sa_handler = name_test;
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER);
    struct sigaction before {};
    ::sigaction(fault, nullptr, &before);
    if (before.sa_handler == SIG_DFL) ::sigaction(fault, &action, nullptr);  // else a sanitizer's
  }
}

}  // namespace

int main(int count, char** arguments) {
  ::setenv("KASUMI_SKY_TABLES", kasumi::made_once_store().c_str(), 0);
  testing::InitGoogleMock(&count, arguments);
  testing::AddGlobalTestEnvironment(new ProcessorTime);
  testing::UnitTest::GetInstance()->listeners().Append(new RunningTest);
  name_faults();
  return RUN_ALL_TESTS();
}

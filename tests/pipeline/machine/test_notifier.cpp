// What the service manager is told, and that a manager that does not listen stops nobody.
#include <chrono>
#include <future>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/machine/notifier.hpp"
#include "tests/pipeline/service_manager.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

struct Notified {
  Notified() {
    ::setenv("NOTIFY_SOCKET", manager.path().c_str(), 1);
    notifier = notify_systemd();
    ::unsetenv("NOTIFY_SOCKET");
  }
  ServiceManager manager;
  std::unique_ptr<Notifier> notifier;
};

TEST(Notifier, EachReportIsOneMessage) {
  Notified it;
  it.notifier->ready();
  it.notifier->status("live:\ntwo lines");
  it.notifier->alive();
  it.notifier->extend_start(30s);
  it.notifier->stopping();
  EXPECT_EQ(it.manager.heard(),
            "READY=1\nSTATUS=live: two lines\nWATCHDOG=1\nEXTEND_TIMEOUT_USEC=30000000\nSTOPPING=1\n");
}

TEST(Notifier, WithoutAServiceManagerNothingHappens) {
  ::unsetenv("NOTIFY_SOCKET");
  notify_systemd()->ready();
}

// A manager that hangs would otherwise stop every loop that reports to it, the picture's first, for as long as it hangs.
TEST(Notifier, Row38AManagerThatDoesNotListenHearsTheLatestWhenItListensAgain) {
  Notified it;
  auto reporting = std::async(std::launch::async, [&] {
    for (int i = 0; i < 3000; ++i) {
      it.notifier->status("line " + std::to_string(i));
      it.notifier->alive();
    }
    it.notifier->reloading();
    it.notifier->ready();
  });
  const bool went_on = reporting.wait_for(60s) == std::future_status::ready;
  while (!went_on && reporting.wait_for(0s) != std::future_status::ready) it.manager.heard();
  ASSERT_TRUE(went_on) << "it waited for the manager";
  EXPECT_THAT(it.manager.heard(), Not(HasSubstr("READY=1")));
  it.notifier->alive();
  EXPECT_THAT(it.manager.heard(), HasSubstr("STATUS=line 2999\nRELOADING=1\nMONOTONIC_USEC="));
  EXPECT_THAT(it.manager.heard(), EndsWith("READY=1\nWATCHDOG=1\n"));
}

}  // namespace
}  // namespace kasumi

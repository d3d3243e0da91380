#include "pipeline/machine/stop_signal.hpp"

#include <csignal>

namespace kasumi {

namespace {

volatile std::sig_atomic_t g_stop = 0;  // a signal handler may access only such a global

bool install() {
  struct sigaction action {};
  action.sa_handler = [](int) { g_stop = 1; };
  action.sa_flags = SA_RESETHAND;  // a second Ctrl-C ends it at once
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  return true;
}

}  // namespace

bool stop_requested() {
  static const bool installed = install();
  return installed && g_stop != 0;
}

}  // namespace kasumi

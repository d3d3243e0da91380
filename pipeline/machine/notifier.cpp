#include "pipeline/machine/notifier.hpp"

#include <systemd/sd-daemon.h>

#include <algorithm>

#include <fmt/format.h>

namespace kasumi {

namespace {

class SystemdNotifier final : public Notifier {
 public:
  void ready() override { send("READY=1"); }
  void status(const std::string& line) override {
    auto one_line = line;
    std::replace(one_line.begin(), one_line.end(), '\n', ' ');
    send("STATUS=" + one_line);
  }
  void alive() override { send("WATCHDOG=1"); }
  void extend_start(Duration by) override {
    send(fmt::format("EXTEND_TIMEOUT_USEC={}", std::chrono::duration_cast<std::chrono::microseconds>(by).count()));
  }
  void reloading() override {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    send(fmt::format("RELOADING=1\nMONOTONIC_USEC={}",
                     std::chrono::duration_cast<std::chrono::microseconds>(now).count()));
  }
  void stopping() override { send("STOPPING=1"); }

 private:
  static void send(const std::string& state) { ::sd_notify(0, state.c_str()); }
};

}  // namespace

std::unique_ptr<Notifier> notify_systemd() {
  return std::make_unique<SystemdNotifier>();
}

}  // namespace kasumi

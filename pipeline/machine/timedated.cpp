#include "pipeline/machine/timedated.hpp"

#include <chrono>

#include <systemd/sd-bus.h>

#include "base/c_ptr.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;
using SteadyClock = std::chrono::steady_clock;

constexpr auto kQuestionInterval = 10s;

class BusTimedated final : public Timedated {
 public:
  bool synchronized() override {
    const auto now = SteadyClock::now();
    if (!asking_ && now >= ask_at_) ask(now);
    while (bus_ && asking_) {
      const int done = ::sd_bus_process(bus_.get(), nullptr);
      if (done < 0) give_up();
      if (done <= 0) break;
    }
    return synchronized_;
  }

 private:
  void ask(SteadyClock::time_point now) {
    ask_at_ = now + kQuestionInterval;
    if (!bus_) {
      sd_bus* bus = nullptr;
      if (::sd_bus_open_system(&bus) < 0) return give_up();
      bus_.reset(bus);
    }
    const int sent = ::sd_bus_call_method_async(bus_.get(), nullptr, "org.freedesktop.timedate1",
                                                "/org/freedesktop/timedate1", "org.freedesktop.DBus.Properties", "Get",
                                                hear, this, "ss", "org.freedesktop.timedate1", "NTPSynchronized");
    if (sent < 0) return give_up();
    asking_ = true;
  }

  static int hear(sd_bus_message* answer, void* self, sd_bus_error*) {
    auto& asker = *static_cast<BusTimedated*>(self);
    int synchronized = 0;
    const bool read = ::sd_bus_message_is_method_error(answer, nullptr) == 0 &&
                      ::sd_bus_message_read(answer, "v", "b", &synchronized) >= 0;
    asker.synchronized_ = read && synchronized != 0;
    asker.asking_ = false;
    return 0;
  }

  void give_up() {
    synchronized_ = asking_ = false;
    bus_.reset();
  }

  CPtr<sd_bus, &sd_bus_close_unref> bus_;
  bool synchronized_ = false, asking_ = false;
  SteadyClock::time_point ask_at_{};
};

}  // namespace

std::unique_ptr<Timedated> ask_timedated() {
  return std::make_unique<BusTimedated>();
}

}  // namespace kasumi

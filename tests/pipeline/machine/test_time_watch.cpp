// What the machine says of its clock, and what is remembered of that over restarts of the service.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <systemd/sd-bus.h>

#include "base/files.hpp"
#include "base/unique_fd.hpp"
#include "pipeline/machine/time_watch.hpp"
#include "pipeline/machine/timedated.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

std::filesystem::path clock_folder(const std::string& name) {
  const auto folder = test_output_folder() / "pipeline" / ("clock-" + name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

// As in the service, whose unit forbids asking the kernel.
TimeSources no_kernel(const std::filesystem::path& timesyncd) {
  TimeSources sources;
  sources.timesyncd = timesyncd;
  sources.ask_timedated = false;
  return sources;
}

TEST(TimeWatch, TheKernelIsBelievedWhereItMayBeAsked) {
  auto sources = no_kernel(clock_folder("kernel") / "synchronized");
  std::optional<bool> says = false;
  sources.kernel = [&] { return says; };
  const auto watch = watch_time(sources);
  EXPECT_FALSE(watch->read().synchronized);
  says = true;
  EXPECT_TRUE(watch->read().synchronized);
}

TEST(TimeWatch, TimesyncdsFileTellsWhereTheKernelMayNotBeAsked) {
  const auto file = clock_folder("timesyncd") / "synchronized";
  const auto watch = watch_time(no_kernel(file));
  EXPECT_FALSE(watch->read().synchronized);
  ASSERT_TRUE(write_text_file(file, ""));
  EXPECT_TRUE(watch->read().synchronized);
  std::filesystem::remove(file);
  EXPECT_FALSE(watch->read().synchronized);
}

class SetByHand final : public TimeWatch {
 public:
  explicit SetByHand(const ClockState& state) : state_(state) {}
  ClockState read() override { return state_; }

 private:
  const ClockState& state_;
};

// A machine whose clocks a test turns, with restarts of the service and of itself.
struct RestartedMachine {
  explicit RestartedMachine(const std::string& name) : file(clock_folder(name) / "clock.json") {}
  std::unique_ptr<TimeWatch> start() {
    state.jumps = 0;
    return remember_trust(std::make_unique<SetByHand>(state), file,
                          {boot, [this] { return since_s; }, [this] { return utc; }});
  }
  SunSource sun(TimeWatch& watch) { return TimeTrust().judge(watch.read(), utc); }
  void pass(double seconds) {
    since_s += seconds;
    utc += from_seconds(seconds);
  }
  std::filesystem::path file;
  std::string boot = "a";
  double since_s = 20.0;
  Utc utc = std::chrono::sys_days{std::chrono::year{2026} / 6 / 21} + 12h;
  ClockState state;
};

TEST(RememberedTrust, Row35TrustOutlivesARestartOfTheServiceThoughTheTimeServerIsGone) {
  RestartedMachine machine("restart");
  machine.state.synchronized = true;
  EXPECT_EQ(machine.sun(*machine.start()), SunSource::ephemeris);
  machine.state.synchronized = false;
  machine.pass(3600.0);
  const auto again = machine.start();
  EXPECT_EQ(machine.sun(*again), SunSource::ephemeris);
}

TEST(RememberedTrust, Row35NotTheNextBoot) {
  RestartedMachine machine("boot");
  machine.state.synchronized = true;
  machine.sun(*machine.start());
  machine.state.synchronized = false;
  machine.boot = "b";
  EXPECT_EQ(machine.sun(*machine.start()), SunSource::none);
}

TEST(RememberedTrust, Row35NotWhenSomebodySetsTheClockMeanwhile) {
  RestartedMachine machine("set");
  machine.state.synchronized = true;
  machine.sun(*machine.start());
  machine.state.synchronized = false;
  machine.utc += 1h;  // while the service is down
  EXPECT_EQ(machine.sun(*machine.start()), SunSource::none);

  machine.utc -= 1h;
  machine.state.synchronized = true;
  const auto watch = machine.start();
  machine.sun(*watch);
  machine.state = {.synchronized = false, .jumps = 1};  // while it runs
  EXPECT_EQ(machine.sun(*watch), SunSource::none);
  EXPECT_FALSE(std::filesystem::exists(machine.file));
}

// Fine adjustment moves the clock a little every day.
TEST(RememberedTrust, SlewingIsNoSetting) {
  RestartedMachine machine("slew");
  machine.state.synchronized = true;
  const auto watch = machine.start();
  for (int hour = 0; hour < 100; ++hour) {
    machine.pass(3600.0);
    machine.utc += 1s;
    EXPECT_EQ(machine.sun(*watch), SunSource::ephemeris);
  }
  machine.state.synchronized = false;
  EXPECT_EQ(machine.sun(*machine.start()), SunSource::ephemeris);
}

TEST(RememberedTrust, ADamagedFileIsNoTrust) {
  RestartedMachine machine("damaged");
  for (const char* text : {"", "[", "{\"boot\": \"a\"}", "{\"boot\": \"a\", \"offset_s\": \"x\"}",
                           "{\"boot\": 3, \"offset_s\": 1.0}", "{\"boot\": \"a\", \"offset_s\": 1e999}"}) {
    ASSERT_TRUE(write_text_file(machine.file, text));
    EXPECT_EQ(machine.sun(*machine.start()), SunSource::none) << text;
  }
}

// A system bus with systemd-timedated on it, for one connection.
class FakeBus {
 public:
  explicit FakeBus(const std::filesystem::path& socket, bool synchronized)
      : synchronized_(synchronized), listening_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    socket.string().copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(listening_.value(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(listening_.value(), 1), 0);
    thread_ = std::thread([this] { serve(); });
  }
  ~FakeBus() {
    stop_ = true;
    ::shutdown(listening_.value(), SHUT_RDWR);
    thread_.join();
  }

 private:
  static int hello(sd_bus_message* call, void*, sd_bus_error*) {
    return ::sd_bus_reply_method_return(call, "s", ":1.1");
  }
  static int get(sd_bus_message* call, void* self, sd_bus_error*) {
    return ::sd_bus_reply_method_return(call, "v", "b", static_cast<int>(static_cast<FakeBus*>(self)->synchronized_));
  }
  void serve() {
    const int fd = ::accept4(listening_.value(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    sd_bus* bus = nullptr;
    sd_id128_t id{};
    ::sd_bus_new(&bus);
    ::sd_bus_set_fd(bus, fd, fd);
    ::sd_bus_set_server(bus, 1, id);
    ::sd_bus_set_trusted(bus, 1);
    ::sd_bus_start(bus);
    ::sd_bus_add_filter(
        bus, nullptr,
        [](sd_bus_message* call, void* self, sd_bus_error* error) {
          if (::sd_bus_message_is_method_call(call, "org.freedesktop.DBus", "Hello") > 0)
            return hello(call, self, error);
          if (::sd_bus_message_is_method_call(call, "org.freedesktop.DBus.Properties", "Get") > 0)
            return get(call, self, error);
          return 0;
        },
        this);
    while (!stop_ && ::sd_bus_process(bus, nullptr) >= 0) ::sd_bus_wait(bus, 20'000);
    ::sd_bus_unref(bus);
  }

  bool synchronized_;
  UniqueFd listening_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

TEST(Timedated, IsAskedOverTheBusWithoutWaiting) {
  for (const bool synchronized : {true, false}) {
    const auto socket = clock_folder("bus") / "socket";
    ::setenv("DBUS_SYSTEM_BUS_ADDRESS", fmt::format("unix:path={}", socket.string()).c_str(), 1);
    const FakeBus bus(socket, synchronized);
    const auto timedated = ask_timedated();
    bool said = false;
    for (int i = 0; i < 100 && !said; ++i) {
      const auto began = std::chrono::steady_clock::now();
      said = timedated->synchronized();
      EXPECT_LT(std::chrono::steady_clock::now() - began, 100ms);
      std::this_thread::sleep_for(10ms);
    }
    EXPECT_EQ(said, synchronized);
  }
}

TEST(Timedated, WithoutABusNothingIsSynchronized) {
  ::setenv("DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nowhere/socket", 1);
  const auto timedated = ask_timedated();
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(timedated->synchronized());
}

}  // namespace
}  // namespace kasumi

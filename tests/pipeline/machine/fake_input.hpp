// Input devices as the kernel shows them (Documentation/input/event-codes), and what a test does with them.
#pragma once

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>

#include <sys/ioctl.h>

#include "pipeline/machine/buttons/input_device.hpp"

namespace kasumi {

struct FakeInputDevice {
  bool plugged = true;
  bool taken = false;  // by another program
  std::string name = "Buttons";
  std::map<int, input_absinfo> axes{};
  std::deque<input_event> queue{};
  std::set<int> down{};           // keys
  std::size_t keeps = 1U << 20U;  // events that the driver's buffer holds
  int opened = 0, grabbed = 0;
  // Called before each: a driver that hangs does not return from one.
  std::function<void()> on_open{}, on_grab{}, on_read{};
  bool may_hang() const { return on_open || on_grab || on_read; }
  std::size_t read = 0;  // events

  void send(int type, int code, int value) {
    if (queue.size() >= keeps) {
      queue.clear();
      put(EV_SYN, SYN_DROPPED, 0);
    }
    put(type, code, value);
  }
  void report() { send(EV_SYN, SYN_REPORT, 0); }
  void key(int code, bool is_down) {
    is_down ? (void)down.insert(code) : (void)down.erase(code);
    send(EV_KEY, code, is_down ? 1 : 0);
    report();
  }

 private:
  void put(int type, int code, int value) {
    input_event event{};
    event.type = static_cast<__u16>(type);
    event.code = static_cast<__u16>(code);
    event.value = value;
    queue.push_back(event);
  }
};

struct FakeInput {
  std::map<std::filesystem::path, FakeInputDevice> devices;
};

class FakeOpenInput final : public InputDevice {
 public:
  explicit FakeOpenInput(FakeInputDevice& device) : device_(device) { ++device_.opened; }
  int read(std::span<input_event> events) override {
    if (device_.on_read) device_.on_read();
    if (!device_.plugged) return -ENODEV;
    if (device_.queue.empty()) return -EAGAIN;
    const auto count = std::min(events.size(), device_.queue.size());
    std::copy_n(device_.queue.begin(), count, events.begin());
    device_.queue.erase(device_.queue.begin(), device_.queue.begin() + static_cast<std::ptrdiff_t>(count));
    device_.read += count;
    return static_cast<int>(count);
  }
  void wait(Duration) override {}
  int control(unsigned long request, void* argument) override {
    const auto number = _IOC_NR(request);
    if (!device_.plugged) return -ENODEV;
    if (request == EVIOCGRAB) {
      if (device_.on_grab) device_.on_grab();
      if (device_.taken) return -EBUSY;
      ++device_.grabbed;
      return 0;
    }
    if (number == _IOC_NR(EVIOCGNAME(0))) {
      const auto length = std::min<std::size_t>(_IOC_SIZE(request), device_.name.size());
      std::memcpy(argument, device_.name.data(), length);
      return static_cast<int>(length);
    }
    if (number == _IOC_NR(EVIOCGKEY(0))) {
      auto* bits = static_cast<std::uint8_t*>(argument);
      std::memset(bits, 0, _IOC_SIZE(request));
      for (const int code : device_.down) bits[code / 8] = static_cast<std::uint8_t>(bits[code / 8] | 1 << code % 8);
      return static_cast<int>(_IOC_SIZE(request));
    }
    for (const auto& [axis, range] : device_.axes)
      if (request == EVIOCGABS(axis)) {
        *static_cast<input_absinfo*>(argument) = range;
        return 0;
      }
    return -EINVAL;
  }

 private:
  FakeInputDevice& device_;
};

inline Result<std::unique_ptr<InputDevice>> open_fake_input(FakeInput& input, const std::filesystem::path& path) {
  const auto device = input.devices.find(path);
  if (device != input.devices.end() && device->second.on_open) device->second.on_open();
  if (device == input.devices.end() || !device->second.plugged)
    return fail(FaultKind::disconnected, "{}: no such device now", path.string());
  return std::make_unique<FakeOpenInput>(device->second);
}

}  // namespace kasumi

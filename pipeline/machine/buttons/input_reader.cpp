#include "pipeline/machine/buttons/input_reader.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>

#include <spdlog/spdlog.h>

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kBounce = 25ms;      // contacts close and open again for so long
constexpr Duration kOpenInterval = 1s;  // of a device that is missing
constexpr int kMostNotchesAtOnce = 100;

}  // namespace

struct InputReader::Device {
  // A key's contact, and what was passed on of it.
  struct Contact {
    int code = 0;
    HandKey key = HandKey::then_and_now;
    bool closed = false, passed_on = false;
    std::optional<Instant> changed;  // what was passed on
  };
  InputDeviceState state;
  std::unique_ptr<InputDevice> device;
  std::optional<Instant> tried;
  std::vector<Contact> contacts;
  std::optional<input_absinfo> range;  // of a finger's place, left to right
  bool single = false;                 // ABS_X and BTN_TOUCH; else ABS_MT_*
  bool touching = false, was_touching = false, moved = false;
  double finger = 0.0;
  int slot = 0, finger_slot = -1;  // the finger that came first is followed
  bool overrun = false;            // until the report ends
};

InputReader::InputReader(VisitorOptions options, Opener opener, Clock& clock)
    : options_(std::move(options)), opener_(std::move(opener)), clock_(clock) {
  for (const auto& path : options_.devices) {
    auto device = std::make_unique<Device>();
    device->state.path = path;
    devices_.push_back(std::move(device));
  }
}

InputReader::~InputReader() = default;

void InputReader::open(Device& device) {
  const auto now = clock_.now();
  if (device.tried && now - *device.tried < kOpenInterval) return;
  device.tried = now;
  const auto fail_with = [&](std::string problem) {
    if (device.state.problem.empty()) spdlog::warn("visitor: {} (the picture goes on without it)", problem);
    device.state.problem = std::move(problem);
  };
  auto opened = opener_(device.state.path);
  if (!opened) return fail_with(opened.error().message);
  // NOLINTNEXTLINE(performance-no-int-to-ptr): so the kernel has it
  if (const int grabbed = (*opened)->control(EVIOCGRAB, reinterpret_cast<void*>(1)); grabbed < 0)
    return fail_with(fmt::format("{}: {}", device.state.path.string(),
                                 grabbed == -EBUSY ? "in use by another program" : std::strerror(-grabbed)));
  auto fresh = Device{};
  fresh.state = device.state;
  fresh.tried = now;
  fresh.device = std::move(*opened);
  fresh.state.name = name_of(*fresh.device);
  fresh.state.up = true;
  fresh.state.problem.clear();
  ++fresh.state.opened;
  for (std::size_t key = 0; key < kHandKeys; ++key)
    for (const int code : options_.keys[key]) fresh.contacts.push_back({code, static_cast<HandKey>(key), {}, {}, {}});
  input_absinfo range{};
  const auto has_range = [&](int axis) {
    return fresh.device->control(EVIOCGABS(axis), &range) >= 0 && range.maximum > range.minimum;
  };
  fresh.single = has_range(ABS_X);
  if (fresh.single || has_range(ABS_MT_POSITION_X)) fresh.range = range;
  device = std::move(fresh);
  spdlog::info("visitor: {}: {}", device.state.path.string(), device.state.name);
}

void InputReader::lose(Device& device, int error, std::vector<HandEvent>& events) {
  device.device.reset();
  device.state.up = false;
  device.state.problem = fmt::format("{}: {}", device.state.path.string(),
                                     error == ENODEV || error == 0 ? "unplugged" : std::strerror(error));
  device.contacts.clear();
  device.tried = clock_.now();
  spdlog::warn("visitor: {} (the picture goes on without it)", device.state.problem);
  events.push_back({HandEvent::Kind::all_up});
}

void InputReader::take_key(Device& device, int code, bool down) {
  for (auto& contact : device.contacts)
    if (contact.code == code) contact.closed = down;
  if (code == BTN_TOUCH && device.single) device.touching = down;
}

// A contact's first change counts at once; what follows within kBounce, only if it lasts.
void InputReader::settle(Device& device, std::vector<HandEvent>& events) {
  const auto now = clock_.now();
  for (auto& contact : device.contacts) {
    if (contact.closed == contact.passed_on || (contact.changed && now - *contact.changed < kBounce)) continue;
    contact.passed_on = contact.closed;
    contact.changed = now;
    events.push_back({contact.closed ? HandEvent::Kind::down : HandEvent::Kind::up, contact.key});
  }
}

// What was lost is asked for.
void InputReader::resynchronize(Device& device, std::vector<HandEvent>& events) {
  const auto keys = keys_down(*device.device);
  const auto is_down = [&](int code) { return std::ranges::binary_search(keys, code); };
  for (auto& contact : device.contacts) contact.closed = is_down(contact.code);
  device.touching = device.single && is_down(BTN_TOUCH);
  device.finger_slot = -1;
  settle(device, events);
}

void InputReader::take(Device& device, const input_event& event, std::vector<HandEvent>& events) {
  if (event.type == EV_SYN && event.code == SYN_DROPPED) {
    ++device.state.lost;
    device.overrun = true;
    return;
  }
  if (device.overrun) {
    if (event.type != EV_SYN || event.code != SYN_REPORT) return;
    device.overrun = false;
    return resynchronize(device, events);
  }
  if (event.type == EV_KEY && event.value != 2) {  // 2: it repeats by itself
    take_key(device, event.code, event.value != 0);
    settle(device, events);
  } else if (event.type == EV_REL && (event.code == REL_DIAL || event.code == REL_WHEEL)) {
    const int notches = std::clamp(event.value, -kMostNotchesAtOnce, kMostNotchesAtOnce);
    if (!events.empty() && events.back().kind == HandEvent::Kind::turn)
      events.back().value += notches;
    else
      events.push_back({HandEvent::Kind::turn, {}, static_cast<double>(notches)});
  } else if (event.type == EV_ABS && device.range) {
    if (event.code == ABS_MT_SLOT) device.slot = event.value;
    const bool followed = device.finger_slot < 0 || device.finger_slot == device.slot;
    if (!device.single && event.code == ABS_MT_TRACKING_ID && followed) {
      device.touching = event.value >= 0;
      device.finger_slot = device.touching ? device.slot : -1;
    }
    if (event.code == (device.single ? ABS_X : ABS_MT_POSITION_X) && (device.single || followed)) {
      const double width = static_cast<double>(device.range->maximum) - device.range->minimum;
      device.finger = std::clamp((static_cast<double>(event.value) - device.range->minimum) / width, 0.0, 1.0);
      device.moved = true;
    }
  }
}

void InputReader::read(Device& device, std::vector<HandEvent>& events) {
  std::array<input_event, kMostInputEvents> some{};
  const int count = device.device->read(some);
  if (count == -EAGAIN || count == -EINTR) return settle(device, events);
  if (count <= 0) return lose(device, -count, events);
  for (int i = 0; i < std::min(count, static_cast<int>(some.size())); ++i)
    take(device, some[static_cast<std::size_t>(i)], events);
  settle(device, events);
  // One place of the finger a picture is enough.
  if (device.touching && (device.moved || !device.was_touching))
    events.push_back({HandEvent::Kind::touch, {}, device.finger});
  if (!device.touching && device.was_touching) events.push_back({HandEvent::Kind::touch_end});
  device.was_touching = device.touching;
  device.moved = false;
}

std::vector<HandEvent> InputReader::read() {
  std::vector<HandEvent> events;
  for (auto& device : devices_) {
    if (!device->device) open(*device);
    if (device->device) read(*device, events);
  }
  return events;
}

void InputReader::wait(Duration longest) {
  for (auto& device : devices_)
    if (device->device) return device->device->wait(longest);
  clock_.sleep_until(clock_.now() + longest);
}

std::vector<InputDeviceState> InputReader::devices() const {
  std::vector<InputDeviceState> states;
  for (const auto& device : devices_) states.push_back(device->state);
  return states;
}

}  // namespace kasumi

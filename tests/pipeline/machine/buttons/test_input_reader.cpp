// Buttons, knobs and touch screens: what is passed on of what a device sends, and what one can cost.
#include "pipeline/machine/buttons/input_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <random>
#include <thread>

#include <linux/uinput.h>

#include "base/outside/abandonable.hpp"
#include "base/unique_fd.hpp"
#include "pipeline/machine/buttons/input_link.hpp"
#include "tests/pipeline/machine/fake_input.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using Kind = HandEvent::Kind;

const std::filesystem::path kButtons = "/dev/input/by-id/usb-Buttons-event-kbd";

VisitorOptions two_keys(const std::filesystem::path& device = kButtons) {
  VisitorOptions options;
  options.devices = {device};
  options.keys[static_cast<std::size_t>(HandKey::then_and_now)] = {KEY_SPACE};
  options.keys[static_cast<std::size_t>(HandKey::era)] = {KEY_E};
  return options;
}

struct Desk {
  explicit Desk(VisitorOptions options = two_keys())
      : reader(
            std::move(options), [this](const auto& path) { return open_fake_input(input, path); }, clock) {
    input.devices[kButtons] = {};
  }
  std::vector<HandEvent> after(Duration time) {
    clock.advance(time);
    return reader.read();
  }
  ManualClock clock{Utc{}};
  FakeInput input;
  InputReader reader;
  FakeInputDevice& buttons = input.devices[kButtons];
};

TEST(InputReader, PassesOnWhatIsPressedAndTakesTheDeviceForItself) {
  Desk desk;
  EXPECT_TRUE(desk.reader.read().empty());
  EXPECT_EQ(desk.buttons.grabbed, 1);
  EXPECT_EQ(desk.reader.devices()[0].name, "Buttons");
  desk.buttons.key(KEY_SPACE, true);
  desk.buttons.key(KEY_Q, true);
  EXPECT_EQ(desk.after(20ms), (std::vector<HandEvent>{{Kind::down, HandKey::then_and_now}}));
  desk.buttons.send(EV_KEY, KEY_SPACE, 2);
  EXPECT_TRUE(desk.after(500ms).empty()) << "a key that repeats by itself";
  desk.buttons.key(KEY_SPACE, false);
  EXPECT_EQ(desk.after(20ms), (std::vector<HandEvent>{{Kind::up, HandKey::then_and_now}}));
}

TEST(InputReader, AContactThatBouncesIsPressedOnce) {
  Desk desk;
  desk.reader.read();
  std::vector<HandEvent> all;
  const auto add = [&](std::vector<HandEvent> events) { all.insert(all.end(), events.begin(), events.end()); };
  for (int i = 0; i < 9; ++i) {
    desk.buttons.key(KEY_E, i % 2 == 0);
    add(desk.after(2ms));
  }
  add(desk.after(100ms));
  for (int i = 0; i < 9; ++i) {
    desk.buttons.key(KEY_E, i % 2 != 0);
    add(desk.after(2ms));
  }
  add(desk.after(100ms));
  EXPECT_EQ(all, (std::vector<HandEvent>{{Kind::down, HandKey::era}, {Kind::up, HandKey::era}}));
}

TEST(InputReader, ADeviceComesBackWithNothingHeld) {
  Desk desk;
  desk.reader.read();
  desk.buttons.key(KEY_SPACE, true);
  desk.after(20ms);
  desk.buttons.plugged = false;
  EXPECT_EQ(desk.after(20ms), (std::vector<HandEvent>{{Kind::all_up}}));
  EXPECT_FALSE(desk.reader.devices()[0].up);
  EXPECT_THAT(desk.reader.devices()[0].problem, testing::HasSubstr("unplugged"));
  for (int i = 0; i < 100; ++i) desk.after(20ms);
  desk.buttons.plugged = true;
  desk.buttons.queue.clear();
  desk.after(1s);
  EXPECT_TRUE(desk.reader.devices()[0].up);
  EXPECT_EQ(desk.buttons.opened, 2);
  desk.buttons.key(KEY_E, true);
  EXPECT_EQ(desk.after(20ms), (std::vector<HandEvent>{{Kind::down, HandKey::era}}));
}

TEST(InputReader, ADeviceThatAnotherProgramHasIsLeftToIt) {
  Desk desk;
  desk.buttons.taken = true;
  desk.buttons.key(KEY_E, true);
  EXPECT_TRUE(desk.reader.read().empty());
  EXPECT_THAT(desk.reader.devices()[0].problem, testing::HasSubstr("in use by another program"));
}

TEST(InputReader, AKnobTurnsByNotches) {
  Desk desk;
  desk.reader.read();
  for (int i = 0; i < 3; ++i) desk.buttons.send(EV_REL, REL_DIAL, 1);
  desk.buttons.send(EV_REL, REL_WHEEL, -1);
  desk.buttons.report();
  EXPECT_EQ(desk.after(20ms), (std::vector<HandEvent>{{Kind::turn, {}, 2.0}}));
}

TEST(InputReader, AFingerIsAShareOfTheScreen) {
  for (const bool single : {true, false}) {
    Desk desk;
    desk.buttons.axes[single ? ABS_X : ABS_MT_POSITION_X].minimum = 1000;
    desk.buttons.axes[single ? ABS_X : ABS_MT_POSITION_X].maximum = 5000;
    desk.reader.read();
    const auto touch = [&](bool down) {
      desk.buttons.send(single ? EV_KEY : EV_ABS, single ? BTN_TOUCH : ABS_MT_TRACKING_ID,
                        down ? 1 : (single ? 0 : -1));
    };
    touch(true);
    desk.buttons.send(EV_ABS, single ? ABS_X : ABS_MT_POSITION_X, 2000);
    desk.buttons.send(EV_ABS, single ? ABS_X : ABS_MT_POSITION_X, 3000);
    desk.buttons.report();
    EXPECT_EQ(desk.after(20ms), (std::vector<HandEvent>{{Kind::touch, {}, 0.5}}));
    desk.buttons.send(EV_ABS, single ? ABS_X : ABS_MT_POSITION_X, 1'000'000);
    EXPECT_EQ(desk.after(20ms), (std::vector<HandEvent>{{Kind::touch, {}, 1.0}}));
    touch(false);
    EXPECT_EQ(desk.after(20ms), (std::vector<HandEvent>{{Kind::touch_end}}));
  }
}

TEST(InputReader, AsksForTheKeysWhenTheDriverHasLostEvents) {
  Desk desk;
  desk.buttons.keeps = 64;
  desk.reader.read();
  desk.buttons.key(KEY_SPACE, true);
  EXPECT_EQ(desk.after(20ms).size(), 1U);
  for (int i = 0; i < 40; ++i) desk.buttons.send(EV_REL, REL_X, 1);
  desk.buttons.key(KEY_SPACE, false);
  for (int i = 0; i < 40; ++i) desk.buttons.send(EV_REL, REL_X, 1);
  desk.buttons.report();
  EXPECT_EQ(desk.after(50ms), (std::vector<HandEvent>{{Kind::up, HandKey::then_and_now}}));
  EXPECT_EQ(desk.reader.devices()[0].lost, 1U);
}

// 10^5 events a second of all kinds, for ten seconds of 30 pictures each.
TEST(InputReader, AHostileDeviceCostsABoundedTime) {
  Desk desk;
  desk.buttons.keeps = 512;
  desk.buttons.axes[ABS_X] = {0, -2147483647 - 1, 2147483647, 0, 0, 0};
  desk.reader.read();
  std::mt19937 random(1);
  double longest_s = 0.0;
  for (int picture = 0; picture < 300; ++picture) {
    for (int i = 0; i < 3333; ++i)
      desk.buttons.send(static_cast<int>(random() % 32U), static_cast<int>(random() % 768U),
                        static_cast<int>(random()));
    const auto before = desk.buttons.read;
    const auto began = std::chrono::steady_clock::now();
    const auto events = desk.after(33ms);
    longest_s = std::max(longest_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
    EXPECT_LE(desk.buttons.read - before, kMostInputEvents);
    EXPECT_LE(events.size(), 2 * kMostInputEvents);
    for (const auto& event : events) {
      if (event.kind == Kind::touch) {
        EXPECT_GE(event.value, 0.0);
        EXPECT_LE(event.value, 1.0);
      }
    }
  }
  fmt::print("the longest reading took {:.3f} ms\n", 1e3 * longest_s);
  EXPECT_GT(desk.reader.devices()[0].lost, 100U);
  desk.buttons.queue.clear();
  desk.buttons.send(EV_SYN, SYN_DROPPED, 0);
  desk.buttons.down = {};
  desk.buttons.report();
  desk.after(100ms);
  desk.after(100ms);
  desk.buttons.key(KEY_E, true);
  EXPECT_THAT(desk.after(100ms), testing::Contains(HandEvent{Kind::down, HandKey::era})) << "it is used again";
}

// A thread of its own, by the machine's clock.
TEST(InputLink, AnOpeningThatHangsKeepsNobodyWaiting) {
  struct Hanging {
    std::mutex mutex;
    std::condition_variable released;
    bool let_go = false, entered = false;
  };
  const auto hanging = std::make_shared<Hanging>();
  SystemClock clock;
  std::atomic<int> news = 0;
  const auto good_fakes = std::make_shared<FakeInput>(), bad_fakes = std::make_shared<FakeInput>();
  good_fakes->devices[kButtons].key(KEY_SPACE, true);
  const auto good = std::make_shared<InputLink>(two_keys(), clock.now(), [&] { ++news; });
  const auto bad = std::make_shared<InputLink>(two_keys(), clock.now());
  serve_input(bad, [=](const auto& path) {
    std::unique_lock lock(hanging->mutex);
    hanging->entered = true;
    hanging->released.wait(lock, [&] { return hanging->let_go; });
    return open_fake_input(*bad_fakes, path);
  });
  serve_input(good, [=](const auto& path) { return open_fake_input(*good_fakes, path); });
  std::vector<HandEvent> events;
  for (int i = 0; i < 500 && events.empty(); ++i) {
    std::this_thread::sleep_for(10ms);
    events = good->take(clock.now());
  }
  EXPECT_EQ(events, (std::vector<HandEvent>{{Kind::down, HandKey::then_and_now}}));
  EXPECT_GE(news, 1);
  const auto asked = std::chrono::steady_clock::now();
  EXPECT_EQ(bad->take(clock.now() + 10s), (std::vector<HandEvent>{{Kind::all_up}})) << "held by it is nothing";
  EXPECT_LT(std::chrono::steady_clock::now() - asked, 1s);
  EXPECT_FALSE(bad->state().up);
  EXPECT_THAT(bad->state().problem, testing::HasSubstr("hung: its driver has not answered for 1"));
  EXPECT_TRUE(bad->take(clock.now() + 10s).empty()) << "once";
  good->end();
  bad->end();
  for (int i = 0; i < 500 && abandoned_threads > 1; ++i) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(abandoned_threads, 1) << "the good one's thread has ended, the other is left behind";
  {
    const std::lock_guard lock(hanging->mutex);
    hanging->let_go = true;
    hanging->released.notify_all();
  }
  for (int i = 0; i < 500 && abandoned_threads > 0; ++i) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(abandoned_threads, 0);
}

TEST(InputLink, EventsThatNobodyTakesAreBounded) {
  ManualClock clock{Utc{}};
  FakeInput input;
  InputReader reader(
      two_keys(), [&](const auto& path) { return open_fake_input(input, path); }, clock);
  InputLink link(two_keys(), clock.now());
  auto& buttons = input.devices[kButtons];
  for (int i = 0; i < 5000; ++i) {
    buttons.key(KEY_E, i % 2 == 0);
    clock.advance(30ms);
    link.turn(reader, clock.now());
  }
  const auto events = link.take(clock.now());
  EXPECT_LE(events.size(), kMostInputWaiting);
  EXPECT_EQ(events.front(), HandEvent{Kind::all_up}) << "what was lost may have let something go";
}

TEST(InputDevice, OtherFilesAreNone) {
  const auto none = open_input_device("/dev/input/there-is-no-such-device");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().kind, FaultKind::disconnected);
  const auto null = open_input_device("/dev/null");
  ASSERT_FALSE(null);
  EXPECT_EQ(null.error().kind, FaultKind::unsupported);
  EXPECT_THAT(null.error().message, testing::HasSubstr("/dev/null: expected an input device"));
}

// The kernel's own way: a keyboard made by uinput, grabbed and read.
TEST(InputDevice, ReadsADeviceOfTheKernel) {
  const UniqueFd uinput(::open("/dev/uinput", O_WRONLY | O_NONBLOCK | O_CLOEXEC));
  if (!uinput) GTEST_SKIP() << "there is no /dev/uinput that may be opened: no device of the kernel's own is read";
  ASSERT_EQ(::ioctl(uinput.value(), UI_SET_EVBIT, EV_KEY), 0);
  ASSERT_EQ(::ioctl(uinput.value(), UI_SET_KEYBIT, KEY_SPACE), 0);
  uinput_setup setup{};
  std::strncpy(setup.name, "Kasumi's test keys", sizeof setup.name - 1);
  ASSERT_EQ(::ioctl(uinput.value(), UI_DEV_SETUP, &setup), 0);
  ASSERT_EQ(::ioctl(uinput.value(), UI_DEV_CREATE), 0);
  std::array<char, 64> sysname{};
  ASSERT_GE(::ioctl(uinput.value(), UI_GET_SYSNAME(sysname.size() - 1), sysname.data()), 0);
  std::filesystem::path node;
  for (int tries = 0; tries < 100 && node.empty(); ++tries) {
    std::error_code error;
    const auto folder = std::filesystem::path("/sys/devices/virtual/input") / sysname.data();
    for (const auto& entry : std::filesystem::directory_iterator(folder, error))
      if (const auto name = entry.path().filename().string();
          name.starts_with("event") && ::access(("/dev/input/" + name).c_str(), R_OK) == 0)
        node = "/dev/input/" + name;
    std::this_thread::sleep_for(20ms);
  }
  if (node.empty()) GTEST_SKIP() << "/dev/input shows no new device: no device of the kernel's own is read";
  SystemClock clock;
  InputReader reader(two_keys(node), open_input_device, clock);
  EXPECT_TRUE(reader.read().empty());
  ASSERT_TRUE(reader.devices()[0].up) << reader.devices()[0].problem;
  EXPECT_EQ(reader.devices()[0].name, "Kasumi's test keys");
  input_event events[2] = {};
  events[0].type = EV_KEY;
  events[0].code = KEY_SPACE;
  events[0].value = 1;
  ASSERT_EQ(::write(uinput.value(), events, sizeof events), static_cast<ssize_t>(sizeof events));
  EXPECT_EQ(reader.read(), (std::vector<HandEvent>{{Kind::down, HandKey::then_and_now}}));
  ::ioctl(uinput.value(), UI_DEV_DESTROY);
  EXPECT_EQ(reader.read(), (std::vector<HandEvent>{{Kind::all_up}}));
}

}  // namespace
}  // namespace kasumi

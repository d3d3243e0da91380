// Brokers that are hostile, shared with a client of the same name, or Home Assistant's; each is a few lines of this test.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <random>
#include <thread>

#include "report/channels/mqtt_channel.hpp"
#include "tests/report/mqtt_broker.hpp"

namespace kasumi::report {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

const std::string kWelcome("\x20\x02\x00\x00", 4);

// Talks to one client after the other until it ends.
class FakeBroker {
 public:
  explicit FakeBroker(std::function<void(FakeBroker&, int)> talk) : talk_(std::move(talk)) {
    listening_ = UniqueFd(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    EXPECT_EQ(::bind(listening_.value(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(listening_.value(), 16), 0);
    ::getsockname(listening_.value(), reinterpret_cast<sockaddr*>(&address), &length);
    options.host = "127.0.0.1";
    options.port = ntohs(address.sin_port);
    options.tls = false;
    options.topic = "kasumi/hill";
    thread_ = std::thread([this] {
      while (!ending) {
        const UniqueFd client(::accept4(listening_.value(), nullptr, nullptr, SOCK_CLOEXEC));
        if (!client || ending) return;
        ++connections;
        talk_(*this, client.value());
      }
    });
  }
  ~FakeBroker() {
    ending = true;
    ::shutdown(listening_.value(), SHUT_RDWR);
    thread_.join();
  }
  // false: the client has gone.
  static bool say(int client, std::string_view bytes) {
    while (!bytes.empty()) {
      const auto n = ::send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
  }
  // What comes within some milliseconds.
  static std::string hear(int client, int longest_ms) {
    pollfd wanted{client, POLLIN, 0};
    char bytes[4096];
    if (::poll(&wanted, 1, longest_ms) <= 0) return {};
    const auto n = ::recv(client, bytes, sizeof bytes, 0);
    return n > 0 ? std::string(bytes, static_cast<std::size_t>(n)) : std::string();
  }
  MqttOptions options;
  std::atomic<bool> ending = false;
  std::atomic<int> connections = 0;

 private:
  std::function<void(FakeBroker&, int)> talk_;
  UniqueFd listening_;
  std::thread thread_;
};

// Without pages of programs and libraries, which come when they are first run.
double memory_kb() {
  const auto text = read_text_file("/proc/self/status").value();
  return std::stod(text.substr(text.find("RssAnon:") + 8));
}

// How a connection ends to a broker that welcomes us and then says this, again and again where it is `endless`.
std::string end_of(const std::string& said, bool endless, bool listens = false) {
  FakeBroker broker([&](FakeBroker& self, int client) {
    FakeBroker::hear(client, 2000);
    FakeBroker::say(client, kWelcome);
    if (listens) FakeBroker::hear(client, 2000);
    while (FakeBroker::say(client, said) && endless && !self.ending) {
    }
    FakeBroker::hear(client, 2000);
  });
  [[maybe_unused]] const double before_kb = memory_kb();
  MqttLink link(broker.options, "hill", {});
  for (const auto until = std::chrono::steady_clock::now() + 10s; std::chrono::steady_clock::now() < until;) {
    const bool welcome = link.answer().has_value();
    const auto turned = link.turn(50ms);
    if (listens && !welcome && link.answer()) link.listen_for_birth("homeassistant");
    if (!turned) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
      EXPECT_LT(memory_kb(), before_kb + 2048);
#endif
      return turned.error().message;
    }
  }
  return "it never ended";
}

TEST(MqttLink, Row42ABrokerThatTellsMoreThanItHasToIsLeft) {
  const std::string megabyte(1 << 20, 'x');
  EXPECT_THAT(end_of("\x30\x80\xc8\xaf\x5f" + megabyte, true), HasSubstr("more than 64 bytes")) << "200 MB";
  EXPECT_THAT(end_of(std::string(1 << 16, '\xff'), true), HasSubstr("does not speak MQTT")) << "an endless length";
  EXPECT_THAT(end_of(std::string("\xd0\x00", 2), true), HasSubstr("nobody asked for")) << "small ones without end";
  EXPECT_THAT(end_of(std::string("\x40\x02\x00\x07", 4), true), HasSubstr("confirms what it was not told"));
  EXPECT_THAT(end_of(kWelcome, false), HasSubstr("a second welcome"));
  EXPECT_THAT(end_of(std::string("\x30\x05\x00\x01"
                                 "ahi",
                                 7),
                     false),
              HasSubstr("nobody asked for"));
}

// What was asked for, and without end: it would be read for ever, and no state told.
TEST(MqttLink, Row42AnEndlessBirthEndsIt) {
  std::string births;
  for (int i = 0; i < 1000; ++i) births += std::string("\x30\x1c\x00\x14", 4) + "homeassistant/status" + "online";
  EXPECT_THAT(end_of(births, true, true), HasSubstr("more than 4096 bytes at once"));
}

TEST(MqttLink, Row42RandomBytesEndIt) {
  std::mt19937 random(7);
  for (int round = 0; round < 20; ++round) {
    std::string noise(4096, '\0');
    for (auto& byte : noise) byte = static_cast<char>(random());
    EXPECT_THAT(end_of(noise, true), HasSubstr("does not speak MQTT"));
  }
}

// Seven take-overs in twenty seconds, each with its lines in the log, were what two kiosks of one name did.
TEST(MqttChannel, Row43AnotherClientOfTheSameNameIsNamedOnceAndGivenRoom) {
  FakeBroker broker([](FakeBroker&, int client) {
    FakeBroker::hear(client, 2000);
    FakeBroker::say(client, kWelcome);
    FakeBroker::hear(client, 2000);  // what a client tells that has been welcomed; then the other one comes
  });
  testing::internal::CaptureStderr();
  {
    SystemClock clock;
    MqttChannel channel(broker.options, "Hill", Language::english, clock,
                        {.first_wait = 10ms, .longest_wait = 60s, .silence = 5s});
    const auto until = std::chrono::steady_clock::now() + 20s;
    while (broker.connections < 3 && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(10ms);
    std::this_thread::sleep_for(1s);
    EXPECT_EQ(broker.connections, 3) << "then it waits";
  }
  const auto log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("another client uses the topic kasumi/hill"));
  EXPECT_EQ(log.find("another client"), log.rfind("another client"));
  EXPECT_THAT(log, HasSubstr("or the broker ends them by itself")) << "as here";
}

// Whoever waits ends the other's connection when it comes back: for hours, without a word in either log.
TEST(MqttChannel, Row43TwoOfOneNameDisputeInSilenceHoweverLong) {
  if (!has_mosquitto()) GTEST_SKIP() << "mosquitto is not installed (packages mosquitto, mosquitto-clients)";
  const MqttBroker broker(report_folder("mqtt-dispute-broker"));
  MqttOptions options;
  options.host = "127.0.0.1";
  options.port = broker.port;
  options.tls = false;
  options.topic = "kasumi/hill";
  MqttPatience patience;  // as shipped, three hundred times as fast
  for (Duration* wait : {&patience.longest_wait, &patience.settled}) *wait /= 300;
  patience.first_wait = 20ms;
  SystemClock clock;
  testing::internal::CaptureStderr();
  MqttChannel one(options, "Hill", Language::english, clock, patience),
      other(options, "Hill", Language::english, clock, patience);
  std::this_thread::sleep_for(3s);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("another client uses the topic kasumi/hill"));
  testing::internal::CaptureStderr();
  std::this_thread::sleep_for(4s);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  bool connected = false;
  for (int i = 0; i < 100 && !connected; ++i, std::this_thread::sleep_for(20ms))
    connected = one.connected() || other.connected();
  EXPECT_TRUE(connected);
}

// Home Assistant forgets what it was told when it starts; then it says so.
TEST(MqttChannel, HomeAssistantsBirthIsAnsweredWithDiscovery) {
  std::atomic<int> told = 0;
  FakeBroker broker([&](FakeBroker& self, int client) {
    FakeBroker::hear(client, 2000);
    FakeBroker::say(client, kWelcome);
    bool born = false;
    for (std::string heard; !self.ending;) {
      heard += FakeBroker::hear(client, 50);
      for (std::size_t at = 0; (at = heard.find("/well/config")) != std::string::npos; heard.erase(0, at + 12)) ++told;
      if (!born && heard.find("homeassistant/status") != std::string::npos) {
        born = true;
        std::this_thread::sleep_for(100ms);
        FakeBroker::say(client, std::string("\x90\x03\x00\x0c\x00", 5));
        FakeBroker::say(client, std::string("\x30\x1c\x00\x14", 4) + "homeassistant/status" + "online");
      }
    }
  });
  SystemClock clock;
  MqttChannel channel(broker.options, "Hill", Language::english, clock, {.birth_pause = 20ms});
  const auto until = std::chrono::steady_clock::now() + 20s;
  while (told < 2 && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(told, 2);
}

}  // namespace
}  // namespace kasumi::report

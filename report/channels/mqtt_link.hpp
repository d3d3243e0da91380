// One connection to an MQTT broker (3.1.1), from greeting to end, by a client that only tells: whatever the broker may say
// to it fits into some bytes, so anything larger, and all that was not asked for, ends the connection.
#pragma once

#include <chrono>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "base/result.hpp"
#include "report/channels/mqtt_messages.hpp"
#include "report/web/web_request.hpp"

namespace kasumi::report {

struct MqttOptions {
  std::string host;
  int port = 8883;
  bool tls = true;
  std::string ca_file;              // empty: who the machine trusts
  std::string cert_file, key_file;  // ours, where the broker asks who we are; empty: none
  std::string user, password;
  std::string topic;                         // the kiosk's
  std::string discovery = "homeassistant";   // Home Assistant's prefix; empty: it is not told
  Duration every = std::chrono::minutes(1);  // figures; what visitors see is told at once
};

// The largest packet that a broker has to send us, but for its head.
constexpr std::size_t kMostMqttBytes = 64;

class MqttLink {
 public:
  // `identity`: the client's; empty: the broker gives one. `will`: told by the broker when we are lost; its topic empty:
  // nothing.
  MqttLink(const MqttOptions& options, const std::string& identity, const MqttMessage& will);

  // BLOCKS for at most `longest`. Errors: disconnected (it has ended), io (why it should): nothing more can be done with it.
  Result<> turn(std::chrono::milliseconds longest);
  // The broker's answer to our greeting: 0 is welcome; empty: none yet.
  std::optional<int> answer() const { return answer_; }
  // Messages that the broker has not confirmed.
  std::size_t unconfirmed() const { return unconfirmed_.size(); }
  // At least once; retained: a late subscriber hears it, too.
  void publish(const MqttMessage& message, bool retained);
  // Hears when Home Assistant has begun: take_birth() is true once then.
  void listen_for_birth(const std::string& prefix);
  bool take_birth() { return std::exchange(born_, false); }
  void say_goodbye();  // what is on its way still goes with the next turn()

 private:
  using Steady = std::chrono::steady_clock;
  Result<> connect();
  Result<> exchange();
  Result<bool> take_packet();
  Result<> hear(unsigned char head, std::string_view body);
  void greet();
  void put(unsigned char head, const std::string& body);

  const MqttOptions& options_;
  std::string identity_;
  MqttMessage will_;
  WebRequest request_;
  bool connected_ = false;
  std::string coming_, going_;  // bytes
  std::optional<int> answer_;
  std::set<unsigned> unconfirmed_;  // their numbers
  unsigned number_ = 0;             // of the last message
  std::string birth_topic_;
  bool subscribing_ = false, born_ = false;
  Steady::time_point said_at_;  // when we last said something
  bool pinged_ = false;
};

}  // namespace kasumi::report

// The kiosk's state on an MQTT broker. The broker is spoken to in a thread of its own: one that is away, slow or silent
// holds nobody up, and costs a try now and then and the memory of one state.
#pragma once

#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "base/words/language.hpp"
#include "report/channels/mqtt_messages.hpp"

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

// A message below the kiosk's topic, once, beside whoever talks to the broker for it already. BLOCKS for at most
// `longest`, beside the look-up of its name. Errors (io): why the broker did not take it.
Result<> publish_once(const MqttOptions& options, std::string_view below, std::string_view payload, Duration longest);

// Of the conversation with a broker.
struct MqttPatience {
  Duration first_wait = std::chrono::seconds(1);    // after the first failure; doubled with each
  Duration longest_wait = std::chrono::minutes(2);  // as the wait grows
  Duration silence = std::chrono::seconds(30);      // until a broker that does not answer is left
};

class MqttChannel {
 public:
  MqttChannel(MqttOptions options, const std::string& name, Language language, Clock& clock,
              MqttPatience patience = {});
  // Says goodbye where the broker listens. BLOCKS for at most 3 s.
  ~MqttChannel();
  MqttChannel(const MqttChannel&) = delete;
  MqttChannel& operator=(const MqttChannel&) = delete;

  // Call it after each look at the kiosk. Never waits.
  void tell(const Heard& heard);
  bool connected() const;

 private:
  class Talk;
  Language language_;
  Duration every_;
  Clock& clock_;
  std::string told_;  // what visitors see and what is wrong, as it was told last
  std::optional<Instant> told_at_;
  std::shared_ptr<Talk> talk_;
  std::future<void> ended_;
  std::thread thread_;
};

}  // namespace kasumi::report

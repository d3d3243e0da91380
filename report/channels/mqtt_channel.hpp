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
#include "report/channels/mqtt_link.hpp"

namespace kasumi::report {

// A message below the kiosk's topic, once, beside whoever talks to the broker for it already. BLOCKS for at most
// `longest`, beside the look-up of its name. Errors (io): why the broker did not take it.
Result<> publish_once(const MqttOptions& options, std::string_view below, std::string_view payload, Duration longest);

// Of the conversation with a broker.
struct MqttPatience {
  Duration first_wait = std::chrono::seconds(1);    // after the first failure; doubled with each
  Duration longest_wait = std::chrono::minutes(2);  // as the wait grows
  Duration silence = std::chrono::seconds(30);      // until a broker that does not answer is left
  Duration birth_pause = std::chrono::seconds(5);   // Home Assistant begins more rarely
  // A connection that lasted so long ends the doubling of waits. Longer than two of the longest: another client of our
  // name comes back after one, and is still the same dispute.
  Duration settled = std::chrono::minutes(5);
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

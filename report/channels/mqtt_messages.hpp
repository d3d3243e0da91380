// What is published on MQTT: the kiosk's state as JSON, and how Home Assistant finds it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/words/language.hpp"
#include "report/diagnosis/status_watch.hpp"

namespace kasumi::report {

// All are retained.
struct MqttMessage {
  std::string topic, payload;
};

// Below the kiosk's topic.
inline constexpr std::string_view kStateTopic = "/state";          // JSON, as mqtt_state() writes it
inline constexpr std::string_view kAvailableTopic = "/available";  // of the reporter
inline constexpr std::string_view kOnline = "online", kOffline = "offline";

// Names may be used as a topic by everybody: no wildcard, no empty level, none of the broker's own.
bool is_topic(std::string_view text);

// One JSON object. What is not known is null; units are in the names of the keys.
std::string mqtt_state(const Heard& heard, Language language);

// Home Assistant's configuration of each of the kiosk's entities, below the topic `prefix`.
std::vector<MqttMessage> discovery_messages(const std::string& prefix, const std::string& topic,
                                            const std::string& name, Language language);

}  // namespace kasumi::report

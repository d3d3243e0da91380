#include "report/channels/mqtt_messages.hpp"

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "base/status/status_figures.hpp"
#include "base/words/texts.hpp"
#include "report/diagnosis/diagnosis.hpp"
#include "report/diagnosis/symptom_words.hpp"

namespace kasumi::report {

namespace {

using Message = nlohmann::ordered_json;

constexpr std::size_t kMostTopicBytes = 128;

std::string text_of(const Message& message) {
  return text_of_json(message);
}

// Letters, digits and lines: what Home Assistant takes in a topic and an entity's name.
std::string identifier(std::string_view text) {
  std::string id;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    id += plain ? c : '_';
  }
  return id;
}

struct Entity {
  std::string_view component;  // "sensor" or "binary_sensor"
  std::string_view key;        // of the state
  std::string_view name;       // of its text
  std::string_view device_class, unit;
  bool diagnostic = true;  // for who looks after it
};

void add_figures(bool machine, std::vector<Entity>& entities) {
  for (const auto& figure : kStatusFigures)
    if (const auto& shown = figure.shown; !shown.text.empty() && shown.machine == machine)
      entities.push_back({"sensor", figure.mqtt, shown.text, shown.device_class, shown.unit, machine});
}

std::vector<Entity> all_entities() {
  std::vector<Entity> entities{{"binary_sensor", "well", "figure.picture", "problem", "", false},
                               {"sensor", "seen", "figure.seen", "", "", false},
                               {"sensor", "wrong", "figure.wrong", "", "", false}};
  add_figures(false, entities);
  entities.push_back({"binary_sensor", "scene_camera", "figure.scene", "connectivity", ""});
  entities.push_back({"binary_sensor", "sky_camera", "figure.sky", "connectivity", ""});
  add_figures(true, entities);
  return entities;
}

Message entity_message(const Entity& entity, const std::string& topic, const std::string& id, Language language) {
  const auto state = topic + std::string(kStateTopic);
  Message message{{"name", text_of(entity.name, language)},
                  {"unique_id", id + "_" + std::string(entity.key)},
                  {"object_id", id + "_" + std::string(entity.key)},
                  {"state_topic", state},
                  {"availability_topic", topic + std::string(kAvailableTopic)}};
  if (entity.component == "binary_sensor") {
    // A "problem" is on where the kiosk is not well. A camera that nobody tells of is unknown.
    const bool is_problem = entity.device_class == "problem";
    message["value_template"] = fmt::format("{{{{ {{True: '{}', False: '{}'}}.get(value_json.{}, 'None') }}}}",
                                            is_problem ? "OFF" : "ON", is_problem ? "ON" : "OFF", entity.key);
    if (is_problem) message["json_attributes_topic"] = state;
  } else {
    // A state of Home Assistant has 255 characters at most.
    message["value_template"] = entity.unit.empty() ? fmt::format("{{{{ value_json.{}[:250] }}}}", entity.key)
                                                    : fmt::format("{{{{ value_json.{} }}}}", entity.key);
    if (!entity.unit.empty()) {
      message["state_class"] = "measurement";
      if (entity.unit != "1") message["unit_of_measurement"] = entity.unit;
    }
  }
  if (!entity.device_class.empty()) message["device_class"] = entity.device_class;
  if (entity.diagnostic) message["entity_category"] = "diagnostic";
  return message;
}

}  // namespace

bool is_topic(std::string_view text) {
  if (text.empty() || text.size() > kMostTopicBytes || text.front() == '$') return false;
  if (text.front() == '/' || text.back() == '/' || text.find("//") != std::string_view::npos) return false;
  for (const char c : text)
    if (c == '+' || c == '#' || static_cast<unsigned char>(c) < 0x21 || c == 0x7f) return false;
  return true;
}

std::string mqtt_state(const Heard& heard, Language language) {
  const auto diagnosis = diagnose(heard);
  std::string wrong;
  auto symptoms = Message::array();
  for (const auto& symptom : diagnosis.symptoms) {
    symptoms.push_back(name_of(symptom.ill));
    if (!wrong.empty()) wrong += ' ';
    wrong += symptom_words(symptom.ill, language).what;
    if (!symptom.detail.empty()) wrong += fmt::format(" ({})", detail_text(symptom, language));
  }
  if (wrong.empty()) wrong = text_of("figure.nothing_wrong", language);
  const ReportedStatus none;
  const auto& told = heard.status ? *heard.status : none;
  const auto camera = [&](const ReportedCamera& of) { return heard.status ? Message(of.values.is("up")) : Message(); };
  Message state{{"sight", name_of(diagnosis.sight)},
                {"well", is_well(diagnosis.sight)},
                {"seen", sight_text(diagnosis.sight, language)},
                {"wrong", wrong},
                {"symptoms", symptoms},
                {"scene_camera", camera(told.scene_camera)},
                {"sky_camera", camera(told.sky_camera)}};
  for (const auto& figure : kStatusFigures) {
    if (figure.mqtt.empty()) continue;
    Message& is = state[std::string(figure.mqtt)];
    if (const auto value = told.values.of(figure.key))
      is = figure.believed.kind == FigureKind::number ? Message(*value) : Message(*value == 1.0);
  }
  return text_of(state);
}

std::vector<MqttMessage> discovery_messages(const std::string& prefix, const std::string& topic,
                                            const std::string& name, Language language) {
  const auto id = identifier(topic);
  const Message device{{"identifiers", {id}}, {"name", name}, {"manufacturer", "Kasumi"}};
  std::vector<MqttMessage> messages;
  for (const auto& entity : all_entities()) {
    auto message = entity_message(entity, topic, id, language);
    message["device"] = device;
    messages.push_back({fmt::format("{}/{}/{}/{}/config", prefix, entity.component, id, entity.key), text_of(message)});
  }
  return messages;
}

}  // namespace kasumi::report

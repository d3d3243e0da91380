// Each figure of the table on its way: alone in a status.json, through every channel where the table shows it.
#include <gmock/gmock.h>

#include <set>

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "base/words/texts.hpp"
#include "report/channels/metrics.hpp"
#include "report/channels/mqtt_messages.hpp"
#include "report/page/state_page.hpp"
#include "tests/report/told.hpp"

namespace kasumi::report {
namespace {

using testing::HasSubstr, testing::Not;
using Json = nlohmann::json;

// A status in which nothing but these figures is set.
std::string status_of(const std::vector<std::pair<std::string, Json>>& figures) {
  Json status = Json::object();
  for (const auto& [key, value] : figures) {
    auto path = "/" + key;
    std::ranges::replace(path, '.', '/');
    status[Json::json_pointer(path)] = value;
  }
  return status.dump();
}

double possible_value(const StatusFigure& figure) {
  const auto& [lowest, highest, kind] = figure.believed;
  return kind == FigureKind::number ? lowest + 0.25 * std::min(highest - lowest, 400.0)
         : kind == FigureKind::sum  ? 5.0
                                    : 1.0;
}

Json possible_json(const StatusFigure& figure) {
  if (figure.believed.kind == FigureKind::number) return possible_value(figure);
  return figure.believed.kind == FigureKind::sum ? Json{{"short", 2}, {"corrupt", 3}} : Json(true);
}

std::vector<Json> impossible_json(const StatusFigure& figure) {
  std::vector<Json> values{"x", nullptr, Json::array({1}), figure.believed.lowest - 1.0,
                           2.0 * figure.believed.highest + 1.0};
  if (figure.believed.kind == FigureKind::number) values.push_back(true);
  return values;
}

// What is known where the figure itself is not believed.
std::optional<double> unknown_value(const StatusFigure& figure) {
  const bool known = figure.believed.kind == FigureKind::is_so || figure.believed.kind == FigureKind::sum;
  return known ? std::optional(0.0) : std::nullopt;
}

// The metric says the value, or is not there; `labels` such as {camera="sky"}.
void expect_metric(const std::string& text, const StatusFigure& figure, const std::string& labels,
                   const std::optional<double>& value) {
  if (figure.metric.empty()) return;
  const auto name = fmt::format("kasumi_{}", figure.metric);
  if (!value) {
    EXPECT_THAT(text, Not(HasSubstr(fmt::format("\n{}{} ", name, labels))));
    return;
  }
  const auto* type = figure.metric.ends_with("_total") ? "counter" : "gauge";
  EXPECT_THAT(text, HasSubstr(fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, figure.what, name, type)));
  EXPECT_THAT(text, HasSubstr(fmt::format("\n{}{} {}\n", name, labels, *value / figure.shown.metric_unit)));
}

void expect_state(const Heard& heard, const StatusFigure& figure, const std::optional<double>& value) {
  if (figure.mqtt.empty()) return;
  const auto state = parse_json(mqtt_state(heard, Language::english));
  const auto& is = state.at(std::string(figure.mqtt));
  const auto wanted = figure.believed.kind == FigureKind::number ? Json(value.value_or(0.0)) : Json(value == 1.0);
  EXPECT_EQ(is, value ? wanted : Json());
}

void expect_page(const Heard& heard, const StatusFigure& figure, const std::optional<double>& value) {
  if (figure.shown.text.empty()) return;
  const auto page = state_page({"Hill", heard, {}, {}, {}, {}, {}}, Language::english);
  const auto line = fmt::format("<dt>{}</dt><dd>", text_of(figure.shown.text, Language::english));
  if (!value) {
    EXPECT_THAT(page, Not(HasSubstr(line)));
    return;
  }
  const auto shown = fmt::format(fmt::runtime(figure.shown.page), *value / figure.shown.page_unit);
  EXPECT_THAT(page, HasSubstr(fmt::format("{}{}</dd>", line, shown)));
}

TEST(StatusFigures, EachGoesThroughAllChannels) {
  for (std::size_t i = 0; i < std::size(kStatusFigures); ++i) {
    const auto& figure = kStatusFigures[i];
    SCOPED_TRACE(figure.key);
    const auto see = [&](const std::string& status, const std::optional<double>& value) {
      SCOPED_TRACE(status);
      const auto heard = heard_of(status);
      EXPECT_EQ(heard.status->values.at(i), value);
      expect_metric(metrics_text(heard, {}, {}), figure, "", value);
      expect_state(heard, figure, value);
      expect_page(heard, figure, value);
    };
    const std::string key(figure.key);
    see(status_of({{key, possible_json(figure)}}), possible_value(figure));
    for (const auto& value : impossible_json(figure)) see(status_of({{key, value}}), unknown_value(figure));
    if (!figure.otherwise.empty())
      see(status_of({{std::string(figure.otherwise), possible_json(figure)}}), possible_value(figure));
  }
}

TEST(StatusFigures, EachOfACameraIsToldOfThatCamera) {
  const std::pair<std::string, std::string> cameras[] = {{"scene_camera", "{camera=\"scene\"}"},
                                                         {"sky_camera", "{camera=\"sky\"}"}};
  for (std::size_t i = 0; i < std::size(kCameraFigures); ++i)
    for (std::size_t c = 0; c < 2; ++c) {
      const auto& figure = kCameraFigures[i];
      const auto& [part, labels] = cameras[c];
      SCOPED_TRACE(fmt::format("{}.{}", part, figure.key));
      const auto see = [&](const Json& json, const std::optional<double>& value) {
        const auto heard = heard_of(status_of({{fmt::format("{}.{}", part, figure.key), json}}));
        const auto& told = *heard.status;
        EXPECT_EQ((c == 0 ? told.scene_camera : told.sky_camera).values.at(i), value);
        EXPECT_EQ((c == 1 ? told.scene_camera : told.sky_camera).values.at(i), unknown_value(figure));
        const auto metrics = metrics_text(heard, {}, {});
        if (value) expect_metric(metrics, figure, labels, value);
        expect_metric(metrics, figure, cameras[1 - c].second, unknown_value(figure));
      };
      see(possible_json(figure), possible_value(figure));
      for (const auto& value : impossible_json(figure)) see(value, unknown_value(figure));
    }
}

TEST(StatusFigures, ThePageShowsSomeWithAnother) {
  int shown = 0;
  for (const auto& figure : kStatusFigures) {
    if (figure.shown.beside.empty()) continue;
    SCOPED_TRACE(figure.key);
    ++shown;
    const auto heard = heard_of(status_of({{std::string(figure.key), 80.0}, {std::string(figure.shown.beside), 10.0}}));
    ASSERT_TRUE(heard.status->values.of(figure.shown.beside)) << "a figure of the table";
    const auto line =
        fmt::format(fmt::runtime(figure.shown.page_both), 80.0 / figure.shown.page_unit, 10.0 / figure.shown.page_unit);
    EXPECT_THAT(state_page({"Hill", heard, {}, {}, {}, {}, {}}, Language::english), HasSubstr("<dd>" + line + "</dd>"));
  }
  EXPECT_GT(shown, 0);
}

TEST(StatusFigures, HomeAssistantFindsTheOnesWithAName) {
  const auto messages = discovery_messages("ha", "hill", "Hill", Language::english);
  for (const auto& figure : kStatusFigures) {
    SCOPED_TRACE(figure.key);
    if (figure.mqtt.empty()) {
      EXPECT_TRUE(figure.shown.text.empty()) << "the state has what an entity shows";
      continue;
    }
    const auto topic = fmt::format("ha/sensor/hill/{}/config", figure.mqtt);
    const auto found = std::ranges::find(messages, topic, &MqttMessage::topic);
    EXPECT_EQ(found != messages.end(), !figure.shown.text.empty());
    if (found == messages.end()) continue;
    const auto entity = parse_json(found->payload);
    EXPECT_EQ(entity["name"], text_of(figure.shown.text, Language::english));
    EXPECT_EQ(entity["value_template"], fmt::format("{{{{ value_json.{} }}}}", figure.mqtt));
    EXPECT_EQ(entity.value("unit_of_measurement", "1"), figure.shown.unit);
  }
}

TEST(StatusFigures, NoTwoShareAKeyOrAName) {
  std::set<std::string_view> keys, metrics, states;
  for (const auto& figure : kStatusFigures) {
    EXPECT_TRUE(keys.insert(figure.key).second) << figure.key;
    EXPECT_TRUE(figure.metric.empty() || metrics.insert(figure.metric).second) << figure.key;
    EXPECT_TRUE(figure.mqtt.empty() || states.insert(figure.mqtt).second) << figure.key;
  }
  for (const auto& figure : kCameraFigures)
    EXPECT_TRUE(figure.metric.empty() || metrics.insert(figure.metric).second) << figure.key;
}

}  // namespace
}  // namespace kasumi::report

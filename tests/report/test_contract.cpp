// The appliance writes, the reporter reads: that both mean the same, and that the reporter misses nothing it needs.
#include <gmock/gmock.h>

#include <algorithm>

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"
#include "pipeline/kiosk/appliance/status.hpp"
#include "report/diagnosis/diagnosis.hpp"
#include "report/web/content_pull.hpp"

namespace kasumi {
namespace {

using report::Ill, report::Sight;

// At nine on a day; live, with what a test adds.
Status some_status() {
  Status status;
  status.now = Instant{} + std::chrono::hours(3);
  status.utc = *parse_utc("2026-06-21T09:00:00Z");
  status.since = *parse_utc("2026-06-21T06:00:00Z");
  status.render.rung.shown = Shown::live;
  status.render.rung.trouble = Trouble::none;
  status.render.building_drawn = true;
  status.render.display.up = true;
  status.scene_camera.health.up = status.sky_camera.health.up = true;
  status.sky.clock_trusted = true;
  return status;
}

report::ReportedStatus told(const Status& status) {
  return report::parse_status(status_json(status)).value();
}

report::Diagnosis diagnosis_of(const Status& status) {
  return report::diagnose({report::Contact::heard, told(status), {}, {}});
}

TEST(ReportContract, EveryRungArrives) {
  for (const Shown shown : kAllShown)
    for (const Trouble trouble : kAllTroubles) {
      auto status = some_status();
      status.render.rung.shown = shown;
      status.render.rung.trouble = trouble;
      EXPECT_EQ(told(status).shown, shown);
      EXPECT_EQ(told(status).trouble, trouble) << name_of(trouble);
      EXPECT_NE(diagnosis_of(status).sight, Sight::unknown);
    }
}

TEST(ReportContract, AKioskInGoodHealthHasNoSymptom) {
  EXPECT_EQ(diagnosis_of(some_status()).sight, Sight::live);
  EXPECT_THAT(diagnosis_of(some_status()).symptoms, testing::IsEmpty());
}

TEST(ReportContract, WhatBecameOfContentArrives) {
  EXPECT_EQ(report::kMostBundleBytes, kMostTarBytes) << "what is fetched is what may be installed";
  auto status = some_status();
  EXPECT_FALSE(told(status).arrived);
  status.probation.arrived =
      Arrival{status.utc, "/run/kasumi-stick/sda1", "refused: a.kasumi: it is not signed", false};
  EXPECT_EQ(told(status).arrived, status.utc);
  EXPECT_EQ(told(status).arrived_words, "refused: a.kasumi: it is not signed");
}

TEST(ReportContract, WhatIsMeasuredArrives) {
  auto status = some_status();
  status.scene_camera.health.up = false;
  status.scene_camera.health.cause = "unplugged";
  status.scene_camera.health.down_since = status.now - std::chrono::seconds(90);
  status.scene_camera.health.bad_frames["short"] = 3;
  status.scene_camera.health.reopened["stall"] = 2;
  status.render.latency_minute = LatencySummary{.median_ms = 61.0, .p95_ms = 80.0, .max_ms = 99.0, .pictures = 1500};
  status.heat.zone = ThermalZone{.name = "cpu", .celsius = 88.0};
  status.heat.show_one_of = 2;
  status.render.page_pictures = {true, 3, status.utc};
  status.loops.push_back({"sky", std::chrono::seconds(9), true});  // the lost camera explains the scene's
  status.instead.emplace();
  status.instead->refused = {"model: no such file"};
  const auto seen = told(status);
  EXPECT_EQ(seen.scene_camera.cause, "unplugged");
  EXPECT_EQ(seen.scene_camera.values["down_s"], 90.0);
  EXPECT_EQ(seen.scene_camera.values["bad_frames"], 3.0);
  EXPECT_EQ(seen.scene_camera.values["reopened"], 2.0);
  EXPECT_EQ(seen.values["latency_ms_last_minute.median"], 61.0);
  EXPECT_EQ(seen.values["heat.celsius"], 88.0);
  EXPECT_EQ(seen.values["heat.pictures_share"], 0.5);
  EXPECT_TRUE(seen.values.is("screen_picture.allowed"));
  EXPECT_EQ(seen.values["screen_picture.taken"], 3.0);
  EXPECT_THAT(seen.hung_loops, testing::ElementsAre("sky"));
  EXPECT_THAT(seen.refused, testing::ElementsAre("model: no such file"));
  EXPECT_EQ(seen.since, status.since);
  std::vector<Ill> ills;
  for (const auto& symptom : diagnosis_of(status).symptoms) ills.push_back(symptom.ill);
  EXPECT_THAT(ills, testing::ElementsAre(Ill::scene_lost, Ill::content_refused, Ill::hung, Ill::hot));
}

// Of a status in which every part is known.
TEST(ReportContract, EveryFigureOfTheTableIsWrittenAndBelieved) {
  auto status = some_status();
  status.scene_camera.health.width = status.scene_camera.health.height = 480;
  status.scene_camera.health.last_good = status.now;
  status.scene_camera.health.mode.emplace();
  status.sky_camera.health.last_good = status.now - std::chrono::seconds(7);
  status.sky.report.air.emplace().observers.emplace_back();
  status.visibility.at = status.utc;
  status.render.latency_minute = LatencySummary{.median_ms = 61.0, .p95_ms = 80.0, .max_ms = 99.0, .pictures = 1500};
  status.heat.zone = ThermalZone{.name = "cpu", .celsius = 88.0};
  status.start.emplace();
  status.render.visitor.emplace().presses.fill(2);
  const auto json = parse_json(status_json(status));
  const auto seen = told(status);
  const auto written = [&](std::string key) -> nlohmann::json {
    std::ranges::replace(key, '.', '/');
    const nlohmann::json::json_pointer path("/" + key);
    EXPECT_TRUE(json.contains(path)) << key;
    return json.contains(path) ? json.at(path) : nlohmann::json();
  };
  for (const auto& figure : kStatusFigures)
    EXPECT_EQ(written(std::string(figure.key)).is_null(), !seen.values.of(figure.key)) << figure.key;
  for (const auto& figure : kCameraFigures)
    EXPECT_EQ(written(fmt::format("scene_camera.{}", figure.key)).is_null(), !seen.scene_camera.values.of(figure.key))
        << figure.key;

  const auto line = history_line(status);
  const auto of = [&](std::string_view key) {
    if (const auto dot = key.find("camera."); dot != std::string_view::npos)
      return (key.starts_with("sky") ? seen.sky_camera : seen.scene_camera).values.of(key.substr(dot + 7));
    return seen.values.of(key);
  };
  for (const auto& column : kHistoryColumns)
    EXPECT_EQ(line.*column.value, of(column.figure).value() / column.unit) << column.name;
  for (const auto& flag : kHistoryFlags) EXPECT_EQ(line.*flag.value, of(flag.figure) == 1.0) << flag.name;
  EXPECT_EQ(line.sky_age_s, 7.0);
}

}  // namespace
}  // namespace kasumi

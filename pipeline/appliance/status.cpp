#include "pipeline/appliance/status.hpp"

#include <cmath>

#include <unistd.h>
#include <nlohmann/json.hpp>

#include "capture/utc_text.hpp"
#include "pipeline/camera_drift/drift_json.hpp"

namespace kasumi {

namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json camera_json(const CameraNews& news, Instant now) {
  const auto& health = news.health;
  Json json;
  json["up"] = health.up;
  json["cause"] = health.cause;
  json["down_s"] = !health.up && health.down_since ? Json(to_seconds(now - *health.down_since)) : Json(nullptr);
  json["last_good_age_s"] = health.last_good ? Json(to_seconds(now - *health.last_good)) : Json(nullptr);
  json["condition"] = name_of(health.condition);
  json["good_frames"] = health.good_frames;
  json["bad_frames"] = health.bad_frames;
  json["opened"] = health.opened;
  json["reopened"] = health.reopened;
  json["sequence_gaps"] = health.sequence_gaps;
  json["skipped"] = health.skipped;
  json["backwards"] = health.backwards;
  json["mode_changes"] = health.mode_changes;
  json["last_outage_s"] = to_seconds(health.last_outage);
  json["copied"] = health.frames_copied;
  json["format"] = health.format ? Json(health.format->text()) : Json(nullptr);
  json["width"] = health.width;
  json["height"] = health.height;
  if (health.mode)
    json["mode"] = {{"driver", health.mode->driver},
                    {"card", health.mode->card},
                    {"place", health.mode->place},
                    {"frames_per_second", health.mode->frames_per_second},
                    {"exposure_s", or_null(health.mode->exposure_s)},
                    {"gain", or_null(health.mode->gain)},
                    {"white_balance_k", or_null(health.mode->white_balance_k)},
                    {"notes", health.mode->notes}};
  return json;
}

Json display_json(const DisplayNews& display) {
  return {{"up", display.up},       {"description", display.description},     {"cause", display.cause},
          {"flips", display.flips}, {"flip_timeouts", display.flip_timeouts}, {"resets", display.resets}};
}

Json latency_json(const std::optional<LatencySummary>& latency) {
  if (!latency) return nullptr;
  return {{"median", latency->median_ms},
          {"p95", latency->p95_ms},
          {"max", latency->max_ms},
          {"pictures", latency->pictures}};
}

Json check_json(const CheckNews& check) {
  Json json{{"utc", utc_text(std::chrono::floor<std::chrono::seconds>(check.at))}, {"summary", check.summary}};
  json["well"] = check.report ? Json(check.report->well()) : Json(nullptr);
  json["reference_utc"] = check.report ? Json(utc_text(check.report->reference)) : Json(nullptr);
  json["findings"] = check.report ? findings_json(*check.report) : Json::array();
  return json;
}

Json visibility_json(const VisibilityNews& news) {
  if (news.at == Utc{}) return nullptr;
  Json json{{"utc", utc_text(std::chrono::floor<std::chrono::seconds>(news.at))}};
  const auto kind = news.air ? news.air->extinction().kind : ExtinctionKind::nothing;
  const bool value = kind == ExtinctionKind::value;
  json["bound"] = kind == ExtinctionKind::at_most    ? Json("at least")
                  : kind == ExtinctionKind::at_least ? Json("at most")
                                                     : Json(nullptr);
  json["visibility_m"] = kind == ExtinctionKind::nothing ? Json(nullptr) : Json(std::round(news.air->visibility_m()));
  json["sigma_m"] = value ? Json(std::round(news.air->visibility_sigma_m())) : Json(nullptr);
  json["turbidity"] =
      value && news.air->turbidity.turbidity ? Json(news.air->turbidity.turbidity->value) : Json(nullptr);
  json["turbidity_sigma"] = value && news.air->turbidity.turbidity ? Json(news.air->turbidity.sigma) : Json(nullptr);
  json["landmarks"] = news.air ? news.air->extinction().landmarks : 0;
  json["reason"] = news.reason;
  json["agreement"] = name_of(news.sky ? news.sky->agreement : Agreement::unknown);
  json["sigmas_apart"] = news.sky ? Json(news.sky->sigmas) : Json(nullptr);
  json["finding"] = news.finding;
  json["words"] = news.sky ? news.sky->message : std::string();
  return json;
}

// Out of the driver's memory, and to the GPU.
double copies_per_frame(const Status& status) {
  const auto& camera = status.scene_camera.health;
  const auto& render = status.render;
  const auto per = [](std::uint64_t copies, std::uint64_t frames) {
    return frames == 0 ? 0.0 : static_cast<double>(copies) / static_cast<double>(frames);
  };
  return per(camera.frames_copied, camera.good_frames) + per(render.uploads, render.scene_frames);
}

}  // namespace

std::string status_json(const Status& status) {
  const auto& rung = status.render.rung;
  const auto& tracked = status.sky.report.tracked;
  const auto tracked_value = [&](auto value) { return tracked ? Json(value(*tracked)) : Json(nullptr); };
  Json json;
  json["shown"] = name_of(rung.shown);
  json["reason"] = name_of(rung.trouble);
  json["display"] = display_json(status.render.display);
  json["scene_camera"] = camera_json(status.scene_camera, status.now);
  json["sky_camera"] = camera_json(status.sky_camera, status.now);
  json["turbidity"] = tracked_value([](const auto& t) { return t.turbidity.value; });
  json["sigma"] = tracked_value([](const auto& t) { return t.sigma; });
  json["turbidity_age_s"] = tracked_value([](const auto& t) { return to_seconds(t.age); });
  json["turbidity_trustworthy"] = tracked_value([](const auto& t) { return t.trustworthy; });
  json["sky"] = name_of(status.sky.report.estimate.sky);
  json["sky_reason"] = status.sky.report.estimate.reason;
  json["sun"] = status.sky.report.sun.message;
  json["building_drawn"] = status.render.building_drawn;
  json["clock_trusted"] = status.sky.clock_trusted;
  json["recording"] = false;  // cameras serve one program at a time: who records is `kasumi record`
  json["latency_ms"] = latency_json(status.render.latency);
  json["latency_ms_last_minute"] = latency_json(status.render.latency_minute);
  json["copies_per_frame"] = copies_per_frame(status);
  json["frames_dropped"] = status.render.frames_dropped;
  json["pictures"] = status.render.pictures;
  json["content"] = {{"reloaded_utc", status.reload ? Json(utc_text(status.reload->at)) : Json(nullptr)},
                     {"problems", status.reload ? Json(status.reload->problems) : Json::array()}};
  json["check"] = status.check ? check_json(*status.check) : Json(nullptr);
  json["visibility"] = visibility_json(status.visibility);
  json["pid"] = ::getpid();
  json["since_utc"] = utc_text(status.since);
  json["utc"] = utc_text(status.utc);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string status_line(const Status& status) {
  const auto& rung = status.render.rung;
  std::string line(name_of(rung.shown));
  if (rung.trouble != Trouble::none) line += fmt::format(": {}", name_of(rung.trouble));
  if (!status.render.display.up) line += fmt::format("; no display: {}", status.render.display.cause);
  if (const auto& tracked = status.sky.report.tracked)
    line += fmt::format("; T {:.2f} +- {:.2f}, {:.0f} s old", tracked->turbidity.value, tracked->sigma,
                        to_seconds(tracked->age));
  return line;
}

std::string stats_text(const Status& status) {
  const auto& render = status.render;
  std::string text =
      fmt::format("pictures: {} shown, {} of them new frames; frames dropped: {}, by the driver: {}\n", render.pictures,
                  render.scene_frames, render.frames_dropped, status.scene_camera.health.sequence_gaps);
  text += fmt::format("copies per frame: {:.2f}\n", copies_per_frame(status));
  if (const auto& latency = render.latency)
    text += fmt::format("capture to flip: median {:.1f} ms, 95 % {:.1f} ms, longest {:.1f} ms, of {} pictures\n",
                        latency->median_ms, latency->p95_ms, latency->max_ms, latency->pictures);
  return text;
}

}  // namespace kasumi

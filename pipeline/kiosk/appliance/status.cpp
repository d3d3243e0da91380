#include "pipeline/kiosk/appliance/status.hpp"

#include <cmath>
#include <numeric>

#include <unistd.h>
#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "base/outside/this_boot.hpp"
#include "base/utc_text.hpp"
#include "pipeline/install/camera_drift/drift_json.hpp"
#include "pipeline/kiosk/loop/hang_watch.hpp"
#include "pipeline/show/scene/air_figures.hpp"

namespace kasumi {

namespace {

using OrderedJson = nlohmann::ordered_json;

template <class T>
OrderedJson or_null(const std::optional<T>& value) {
  return value ? OrderedJson(*value) : OrderedJson(nullptr);
}

OrderedJson camera_json(const CameraStatus& status, Instant now) {
  const auto& health = status.health;
  OrderedJson json;
  json["up"] = health.up;
  json["cause"] = health.cause;
  json["down_s"] =
      !health.up && health.down_since ? OrderedJson(to_seconds(now - *health.down_since)) : OrderedJson(nullptr);
  json["last_good_age_s"] = health.last_good ? OrderedJson(to_seconds(now - *health.last_good)) : OrderedJson(nullptr);
  json["told_age_s"] = status.told == Instant{} ? OrderedJson(nullptr) : OrderedJson(to_seconds(now - status.told));
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
  json["format"] = health.format ? OrderedJson(health.format->text()) : OrderedJson(nullptr);
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

OrderedJson visitor_json(const VisitorStatus& visitor) {
  const auto& presses = visitor.presses;
  OrderedJson json;
  json["presses"] = std::accumulate(presses.begin(), presses.end(), std::uint64_t{0});
  json["devices"] = OrderedJson::array();
  for (const auto& device : visitor.devices)
    json["devices"].push_back({{"device", device.path.string()},
                               {"name", device.name},
                               {"up", device.up},
                               {"problem", device.problem},
                               {"opened", device.opened},
                               {"lost", device.lost}});
  return json;
}

OrderedJson heat_json(const HeatStatus& heat) {
  return {{"pictures_share", 1.0 / heat.show_one_of},
          {"zone", heat.zone ? OrderedJson(heat.zone->name) : OrderedJson(nullptr)},
          {"celsius", heat.zone ? OrderedJson(heat.zone->celsius) : OrderedJson(nullptr)},
          {"throttled", heat.throttled},
          {"spared", heat.spared}};
}

OrderedJson loops_json(const std::vector<LoopStatus>& loops) {
  OrderedJson json = OrderedJson::object();
  for (const auto& loop : loops)
    json[loop.name] = {{"up", loop.silent && !loop.hung},
                       {"silent_s", loop.silent ? OrderedJson(to_seconds(*loop.silent)) : OrderedJson(nullptr)}};
  return json;
}

OrderedJson display_json(const DisplayStatus& display) {
  return {{"up", display.up},
          {"description", display.description},
          {"cause", display.cause},
          {"flips", display.flips},
          {"flip_timeouts", display.flip_timeouts},
          {"resets", display.resets},
          {"planes", display.planes},
          {"mixing", display.mixing}};
}

// null: none is switched.
OrderedJson television_json(const TelevisionStatus& television) {
  if (television.adapter.empty()) return nullptr;
  const auto& on = television.wanted_on;
  return {{"adapter", television.adapter},
          {"wanted", on ? OrderedJson(name_of(*on ? TelevisionPower::on : TelevisionPower::standby)) : OrderedJson()},
          {"answers", or_null(television.answers)},
          {"power", name_of(television.power)},
          {"problem", television.problem}};
}

OrderedJson latency_json(const std::optional<LatencySummary>& latency) {
  if (!latency) return nullptr;
  const auto ms = [&](double value) { return latency->pictures > 0 ? OrderedJson(value) : OrderedJson(); };
  return {{"median", ms(latency->median_ms)},
          {"p95", ms(latency->p95_ms)},
          {"max", ms(latency->max_ms)},
          {"pictures", latency->pictures},
          {"negative", latency->negative}};
}

OrderedJson check_json(const CheckStatus& check) {
  OrderedJson json{{"utc", utc_text(std::chrono::floor<std::chrono::seconds>(check.at))}, {"summary", check.summary}};
  json["well"] = check.report ? OrderedJson(check.report->steady()) : OrderedJson(nullptr);
  json["reference_utc"] = check.report ? OrderedJson(utc_text(check.report->reference)) : OrderedJson(nullptr);
  json["findings"] = check.report ? findings_json(*check.report) : OrderedJson::array();
  return json;
}

OrderedJson visibility_json(const VisibilityStatus& status) {
  if (status.at == Utc{}) return nullptr;
  OrderedJson json{{"utc", utc_text(std::chrono::floor<std::chrono::seconds>(status.at))}};
  const auto kind = status.air ? status.air->extinction().kind : ExtinctionKind::nothing;
  const bool value = kind == ExtinctionKind::value;
  json["bound"] = kind == ExtinctionKind::at_most    ? OrderedJson("at least")
                  : kind == ExtinctionKind::at_least ? OrderedJson("at most")
                                                     : OrderedJson(nullptr);
  json["visibility_m"] =
      kind == ExtinctionKind::nothing ? OrderedJson(nullptr) : OrderedJson(std::round(status.air->visibility_m()));
  json["sigma_m"] = value ? OrderedJson(std::round(status.air->visibility_sigma_m())) : OrderedJson(nullptr);
  json["turbidity"] = value && status.air->turbidity.turbidity ? OrderedJson(status.air->turbidity.turbidity->value)
                                                               : OrderedJson(nullptr);
  json["turbidity_sigma"] =
      value && status.air->turbidity.turbidity ? OrderedJson(status.air->turbidity.sigma) : OrderedJson(nullptr);
  json["landmarks"] = status.air ? status.air->extinction().landmarks : 0;
  const ContrastChroma camera = status.air ? status.air->camera : ContrastChroma{};
  json["saturation"] = camera.known() ? OrderedJson(std::round(1e3 * camera.chroma) / 1e3) : OrderedJson(nullptr);
  json["saturation_sigma"] =
      camera.known() ? OrderedJson(std::round(1e3 * camera.chroma * camera.log_sigma) / 1e3) : OrderedJson(nullptr);
  const ContrastTone tone = status.air ? status.air->tone : ContrastTone{};
  json["tone_exponent"] = tone.known() ? OrderedJson(std::round(1e3 * tone.exponent) / 1e3) : OrderedJson(nullptr);
  json["tone_exponent_sigma"] =
      tone.known() ? OrderedJson(std::round(1e3 * tone.exponent * tone.log_sigma) / 1e3) : OrderedJson(nullptr);
  json["reason"] = status.reason;
  json["agreement"] = name_of(status.sky ? status.sky->agreement : Agreement::unknown);
  json["sigmas_apart"] = status.sky ? OrderedJson(status.sky->sigmas) : OrderedJson(nullptr);
  json["finding"] = status.finding;
  json["words"] = status.sky ? status.sky->message : std::string();
  return json;
}

OrderedJson cards_json(const Status& status) {
  const auto& cards = status.render.cards;
  if (!cards) return nullptr;
  const auto thousandths = [](const glm::dvec3& values) {
    OrderedJson list = OrderedJson::array();
    for (int c = 0; c < 3; ++c) list.push_back(std::round(1e3 * values[c]) / 1e3);
    return list;
  };
  const LightFactors& factors = cards->factors;
  return {{"in_view", cards->in_view},
          {"read", cards->read},
          {"age_s", cards->read_at ? OrderedJson(to_seconds(status.now - *cards->read_at)) : OrderedJson(nullptr)},
          {"sun", thousandths(factors.sun)},
          {"sun_sigma", thousandths(factors.sun_sigma)},
          {"around", thousandths(factors.around)},
          {"around_sigma", thousandths(factors.around_sigma)}};
}

OrderedJson passers_json(const std::optional<PassersStatus>& passers) {
  if (!passers) return nullptr;
  const bool learns = passers->state == PassersState::learning;
  return {{"state", name_of(passers->state)},
          {"reason", reason_of(passers->state)},
          {"known_share", passers->known_share},
          {"covered_share", passers->covered_share},
          {"until_watching_s", learns ? OrderedJson(to_seconds(passers->until_watching)) : OrderedJson(nullptr)}};
}

OrderedJson page_pictures_json(const PagePictures& pictures) {
  const auto& last = pictures.last;
  return {{"allowed", pictures.allowed},
          {"taken", pictures.taken},
          {"last_utc", last ? OrderedJson(utc_text(std::chrono::floor<std::chrono::seconds>(*last))) : OrderedJson()}};
}

OrderedJson start_json(const std::optional<StartRecord>& start) {
  if (!start) return nullptr;
  return {{"safe_mode", start->mode != StartMode::whole},
          {"trial", start->trial},
          {"failed_boots", start->failed_boots},
          {"why", start->why}};
}

OrderedJson generation_json(const Status& status) {
  const auto& shown = status.probation.shown;
  if (!shown) return nullptr;
  const auto second = [](Utc utc) { return OrderedJson(utc_text(std::chrono::floor<std::chrono::seconds>(utc))); };
  const bool probation = shown->on_probation();
  return {{"id", shown->id},
          {"name", shown->manifest.name},
          {"created_utc", second(shown->manifest.created)},
          {"installed_utc", second(shown->installed)},
          {"signed_by", shown->signed_by.empty() ? OrderedJson(nullptr) : OrderedJson(shown->signed_by)},
          {"proven_utc", shown->proven ? second(*shown->proven) : OrderedJson(nullptr)},
          {"probation_left_s", probation ? OrderedJson(to_seconds(status.probation.left)) : OrderedJson(nullptr)},
          {"probation_until_utc",
           probation ? second(status.probation.told + status.probation.left) : OrderedJson(nullptr)}};
}

OrderedJson went_back_json(const std::optional<Generation>& generation) {
  if (!generation) return nullptr;
  return {{"id", generation->id},
          {"name", generation->manifest.name},
          {"utc", utc_text(std::chrono::floor<std::chrono::seconds>(generation->went_back->utc))},
          {"why", generation->went_back->why}};
}

OrderedJson arrived_json(const std::optional<Arrival>& arrival) {
  if (!arrival) return nullptr;
  return {{"utc", utc_text(std::chrono::floor<std::chrono::seconds>(arrival->utc))},
          {"from", arrival->from},
          {"taken", arrival->taken},
          {"words", arrival->words}};
}

OrderedJson content_json(const Status& status) {
  const auto reload = status.reload.value_or(ReloadStatus{});
  const auto& instead = status.instead;
  const bool is_shown = status.render.rung.trouble != Trouble::content_refused;  // what worked before
  return {{"reloaded_utc", reload.ended ? OrderedJson(utc_text(*reload.ended)) : OrderedJson(nullptr)},
          {"problems", OrderedJson(reload.problems)},
          {"reload_began_s",
           reload.began ? OrderedJson(to_seconds(reload.began->time_since_epoch())) : OrderedJson(nullptr)},
          {"reloading", reload.doing.empty() ? OrderedJson(nullptr) : OrderedJson(reload.doing)},
          {"last_good_utc", instead && is_shown ? OrderedJson(utc_text(instead->kept_utc)) : OrderedJson(nullptr)},
          {"refused", instead ? OrderedJson(instead->refused) : OrderedJson::array()},
          {"era", status.era.empty() ? OrderedJson(nullptr) : OrderedJson(status.era)},
          {"era_problem", reload.era_problem.empty() ? OrderedJson(nullptr) : OrderedJson(reload.era_problem)},
          {"generation", generation_json(status)},
          {"went_back", went_back_json(status.probation.went_back)},
          {"arrived", arrived_json(status.probation.arrived)}};
}

OrderedJson observer_json(const ObserverPart& part) {
  return {{"by", name_of(part.by)},
          {"share", part.share},
          {"age_s", to_seconds(part.age)},
          {"aod_550", part.aod_550},
          {"sigma_aod_550", part.sigma_aod_550},
          {"sigmas_apart", part.apart_sigmas}};
}

// What drives the picture, and who says so; null before the first report.
OrderedJson air_json(const std::optional<TrackedAir>& state) {
  if (!state) return nullptr;
  const Aerosol& aerosol = state->air.aerosol();
  OrderedJson json;
  json["text"] = state->text();
  json["supposed"] = state->supposed;
  json["trustworthy"] = state->trustworthy;
  json["age_s"] = to_seconds(state->age);
  json["turbidity"] = state->air.turbidity().value;
  json["sigma"] = state->sigma_turbidity;
  json["aod_550"] = aerosol.aod_550;
  json["sigma_aod_550"] = aod_sigma(*state);
  json["angstrom_exponent"] = aerosol.angstrom_exponent;
  json["sigma_angstrom"] = angstrom_sigma(*state);
  json["aerosol"] = name_of(aerosol.kind);
  for (std::size_t i = 0; i < kAerosolKinds.size(); ++i)
    json["kinds"][std::string(name_of(kAerosolKinds[i]))] = state->kinds[i];
  json["followed"] = name_of(state->air.aerosol_known() ? DaylightModel::dome : DaylightModel::preetham);
  json["papers_share"] = state->papers_share;
  json["near_ground"] = state->air.near_ground();
  json["sigma_log_near_ground"] = state->sigma_log_near_ground;
  json["observers"] = OrderedJson::array();
  for (const ObserverPart& part : state->observers) json["observers"].push_back(observer_json(part));
  return json;
}

// From the driver's memory, and to the GPU.
double copies_per_frame(const Status& status) {
  const auto& camera = status.scene_camera.health;
  const auto& render = status.render;
  const auto per = [](std::uint64_t copies, std::uint64_t frames) {
    return frames == 0 ? 0.0 : static_cast<double>(copies) / static_cast<double>(frames);
  };
  return per(camera.frames_copied, camera.good_frames) + per(render.uploads, render.scene_frames);
}

OrderedJson whole_json(const Status& status) {
  const auto& rung = status.render.rung;
  const auto* seen = status.sky.report.seen_air();
  const auto of_seen = [&](auto value) { return seen ? OrderedJson(value(*seen)) : OrderedJson(nullptr); };
  OrderedJson json;
  json["shown"] = name_of(rung.shown);
  json["reason"] = name_of(rung.trouble);
  json["display"] = display_json(status.render.display);
  json["television"] = television_json(status.television);
  json["scene_camera"] = camera_json(status.scene_camera, status.now);
  json["sky_camera"] = camera_json(status.sky_camera, status.now);
  json["turbidity"] = of_seen([](const auto& t) { return t.air.turbidity().value; });
  json["sigma"] = of_seen([](const auto& t) { return t.sigma_turbidity; });
  json["turbidity_age_s"] = of_seen([](const auto& t) { return to_seconds(t.age); });
  json["turbidity_trustworthy"] = of_seen([](const auto& t) { return t.trustworthy; });
  const auto air = seen_quality(status.sky.report, 0.0);
  const auto* aerosol = air && air->aerosol ? &*air->aerosol : nullptr;
  json["aod_550"] = air ? OrderedJson(air->aod_550) : OrderedJson(nullptr);
  json["angstrom_exponent"] = aerosol ? OrderedJson(aerosol->angstrom_exponent) : OrderedJson(nullptr);
  json["aerosol"] = aerosol ? OrderedJson(name_of(aerosol->kind)) : OrderedJson(nullptr);
  json["air"] = air_json(status.sky.report.air);
  json["sky"] = name_of(status.sky.report.estimate.sky);
  json["sky_reason"] = status.sky.report.estimate.reason;
  json["sun"] = status.sky.report.sun.message;
  json["building_drawn"] = status.render.building_drawn;
  json["ground_light_known"] = nullptr;
  if (status.render.ground_known) json["ground_light_known"] = *status.render.ground_known;
  json["cards"] = cards_json(status);
  const auto& refused = status.render.draw_refused;
  json["draw_refused"] = refused.empty() ? OrderedJson(nullptr) : OrderedJson(refused);
  json["people_in_front"] = passers_json(status.render.passers);
  json["screen_picture"] = page_pictures_json(status.render.page_pictures);
  if (status.render.visitor) json["visitor"] = visitor_json(*status.render.visitor);
  json["clock_trusted"] = status.sky.clock_trusted;
  json["recording"] = false;  // recording needs the cameras for itself: only `kasumi record` does it
  json["latency_ms"] = latency_json(status.render.latency);
  json["latency_ms_last_minute"] = latency_json(status.render.latency_minute);
  json["copies_per_frame"] = copies_per_frame(status);
  json["frames_dropped"] = status.render.frames_dropped;
  json["pictures"] = status.render.pictures;
  json["content"] = content_json(status);
  json["start"] = start_json(status.start);
  json["check"] = status.check ? check_json(*status.check) : OrderedJson(nullptr);
  json["visibility"] = visibility_json(status.visibility);
  json["loops"] = loops_json(status.loops);
  json["heat"] = heat_json(status.heat);
  json["pid"] = ::getpid();
  json["boot"] = boot_id();
  json["since_boot_s"] = std::round(10.0 * since_boot_s()) / 10.0;
  json["since_utc"] = utc_text(status.since);
  json["utc"] = utc_text(status.utc);
  return json;
}

// "air.age_s"; null: it is not there.
OrderedJson figure_of(const OrderedJson& json, std::string_view key) {
  const auto dot = key.find('.');
  const auto found = json.find(key.substr(0, dot));
  if (found == json.end()) return nullptr;
  return dot == std::string_view::npos ? *found : figure_of(*found, key.substr(dot + 1));
}

}  // namespace

std::string heat_text(const HeatStatus& heat) {
  std::string text = heat.show_one_of == 1   ? "all pictures are shown"
                     : heat.show_one_of == 2 ? "every second picture is shown"
                                             : "every fourth picture is shown";
  if (heat.zone) text += fmt::format(": {} at {:.0f} degrees", heat.zone->name, heat.zone->celsius);
  if (heat.throttled) text += heat.zone ? ", the firmware throttles" : ": the firmware throttles";
  return text;
}

std::string status_json(const Status& status) {
  return text_of_json(whole_json(status), 2) + "\n";
}

std::string status_line(const Status& status) {
  const auto& rung = status.render.rung;
  std::string line(name_of(rung.shown));
  if (rung.trouble != Trouble::none) line += fmt::format(": {}", name_of(rung.trouble));
  if (!status.render.draw_refused.empty()) line += fmt::format("; cannot be drawn: {}", status.render.draw_refused);
  if (!status.render.display.up && rung.trouble != Trouble::stopped)
    line += fmt::format("; no display: {}", status.render.display.cause);
  if (status.heat.show_one_of > 1) line += "; too hot: " + heat_text(status.heat);
  for (const auto& loop : status.loops)
    if (loop.hung) line += fmt::format("; {} loop: {}", loop.name, hung_text(*loop.silent));
  if (const auto* air = status.sky.report.seen_air())
    line += fmt::format("; T {:.2f} +- {:.2f}, {:.0f} s old", air->air.turbidity().value, air->sigma_turbidity,
                        to_seconds(air->age));
  if (const auto& air = status.sky.report.air; air && air->supposed) line += "; the air is supposed";
  if (status.instead && rung.trouble != Trouble::content_refused)
    line += fmt::format("; the configured content is refused, shown is that of {}",
                        utc_text(std::chrono::floor<std::chrono::seconds>(status.instead->kept_utc)));
  if (status.start && status.start->mode != StartMode::whole && !status.start->why.empty())
    line += "; " + status.start->why.back();
  return line;
}

HistoryLine history_line(const Status& status) {
  HistoryLine line;
  line.utc = std::chrono::floor<std::chrono::minutes>(status.utc);
  line.shown = status.render.rung.shown;
  line.trouble = status.render.rung.trouble;
  const auto json = whole_json(status);
  for (const auto& column : kHistoryColumns)
    if (const auto figure = figure_of(json, column.figure); figure.is_number())
      line.*column.value = figure.get<double>() / column.unit;
  for (const auto& flag : kHistoryFlags) line.*flag.value = figure_of(json, flag.figure) == OrderedJson(true);
  return line;
}

std::string stats_text(const Status& status) {
  const auto& render = status.render;
  std::string text =
      fmt::format("pictures: {} shown, {} of them new frames; frames dropped: {}, by the driver: {}\n", render.pictures,
                  render.scene_frames, render.frames_dropped, status.scene_camera.health.sequence_gaps);
  text += fmt::format("copies per frame: {:.2f}\n", copies_per_frame(status));
  if (const auto& latency = render.latency) {
    text += fmt::format("capture to flip: median {:.1f} ms, 95 % {:.1f} ms, longest {:.1f} ms, of {} pictures\n",
                        latency->median_ms, latency->p95_ms, latency->max_ms, latency->pictures);
    if (latency->negative > 0)
      text += fmt::format("stamped by the camera after their flip: {} pictures\n", latency->negative);
  }
  return text;
}

}  // namespace kasumi

#include "pipeline/kiosk/doctor/doctor.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <thread>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"
#include "pipeline/kiosk/content/bundle.hpp"
#include "pipeline/kiosk/doctor/checks.hpp"
#include "pipeline/machine/time_watch.hpp"
#include "pipeline/show/stage/stories_on_glass.hpp"
#include "pipeline/show/stage/words_on_glass.hpp"

namespace kasumi {

namespace {

constexpr double kOldCalibration_days = 365.0;

Result<std::string> ask_systemctl() {
  std::FILE* pipe = ::popen("systemctl show kasumi.service 2>/dev/null", "re");
  if (!pipe) return fail(FaultKind::unsupported, "systemctl cannot be run");
  std::string text;
  std::array<char, 4096> buffer;
  for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) text.append(buffer.data(), n);
  if (::pclose(pipe) != 0 || text.empty()) return fail(FaultKind::unsupported, "systemd does not answer");
  return text;
}

void check_content(const Content& content, Findings& findings) {
  std::string left_out;
  for (const auto& note : model_notes(content)) left_out += "; " + note;
  findings
      .good("content.model",
            fmt::format("{}: {} triangles, {} textures{}", content.config.installation.object.model.filename().string(),
                        content.model->triangle_count(), content.model->textures.size(), left_out))
      .values["triangles"] = static_cast<double>(content.model->triangle_count());
  if (content.still)
    findings.good("content.still", fmt::format("{}x{}", content.still->width(), content.still->height()));
  else
    findings.warn("content.still",
                  "no still picture: while a camera is unavailable, visitors see the sky over plain land",
                  "set [still] picture to a photograph of the view");
}

void check_words(const RunConfig& config, Findings& findings) {
  const auto faults = words_that_cannot_be_read(config);
  if (faults.empty()) return (void)findings.good("content.words", "the installed fonts show all of them");
  std::string found = faults.front();
  for (std::size_t i = 1; i < faults.size(); ++i) found += "\n" + faults[i];
  findings.warn("content.words", found, "install the package, or name a font: [words] font_file");
}

void check_stories(const Content& content, Findings& findings) {
  if (!content.visitor) return;
  const auto faults = stories_that_cannot_be_seen(content);
  const auto& visitor = *content.visitor;
  auto& finding = faults.empty()
                      ? findings.good("content.stories", fmt::format("{} in {} languages", visitor.stories.size(),
                                                                     visitor.languages.size()))
                      : findings.warn("content.stories", fmt::format("{}", fmt::join(faults, "\n")),
                                      "correct the keys named; docs/content.md says what they mean");
  finding.values["stories"] = static_cast<double>(visitor.stories.size());
}

// What lies on the disk; what becomes of it on the screen is the running appliance's to say.
void check_generation(const Generations& generations, Findings& findings) {
  const auto current = generations.current();
  if (const auto all = generations.all(); !all.empty() && all.front().went_back)
    findings.warn("content.went_back",
                  fmt::format("{} ({}), installed last, went back {}: {}", all.front().manifest.name, all.front().id,
                              utc_text(std::chrono::floor<std::chrono::seconds>(all.front().went_back->utc)),
                              all.front().went_back->why),
                  "correct it where it was made; docs/content.md");
  if (!current) return;
  const auto name =
      fmt::format("{} ({}){}", current->manifest.name, current->id, current->on_probation() ? ", on probation" : "");
  if (const auto whole = check_unpacked(generations.folder_of(*current), current->manifest); !whole)
    findings.fail("content.generation", name + ": damaged: " + whole.error().message,
                  "install its bundle again, or sudo kasumi content rollback; sudo kasumi doctor says how the disk is");
  else
    findings.good("content.generation", name + ", whole");
}

void check_calibration(const char* name, const Camera& camera, const Installation& installation, Utc now,
                       Findings& findings) {
  const auto check = std::string(name) + ".calibration";
  if (!camera.calibrated_utc) {
    findings.warn(check, "its date is unknown",
                  fmt::format("add calibrated_utc = 2026-06-21T00:00:00Z below [{}]", camera.name));
    return;
  }
  const double days = to_seconds(now - *camera.calibrated_utc) / 86400.0;
  const auto& adopted = installation.calibration;
  const auto& gained = adopted ? adopted->gained : std::vector<std::string>{};
  const bool from_file = std::find(gained.begin(), gained.end(), camera.name + ".calibrated_utc") != gained.end();
  const auto found =
      fmt::format("{:.0f} days old{}", days, from_file ? ", according to " + adopted->file.filename().string() : "");
  auto& finding =
      days > kOldCalibration_days
          ? findings.warn(check, found, "mounts creep: is the building still drawn in its place? if so, renew the date")
          : findings.good(check, found);
  finding.values["days"] = days;
}

// Both at once, as the appliance does, since they may share a bus.
void check_cameras(const DoctorRequest& request, const RunConfig& config, Devices& devices, Clock& clock,
                   Findings& findings) {
  const auto watch = [&](CameraRole role, const CameraOptions& options) {
    const auto& camera = role == CameraRole::sky ? config.installation.sky : config.installation.scene;
    return measure_camera(devices.camera(role, options).opener, camera, clock, request.watch);
  };
  OpeningTrial sky;
  std::thread other([&] { sky = watch(CameraRole::sky, config.sky_camera); });
  const auto scene = watch(CameraRole::scene, config.scene_camera);
  other.join();
  check_camera("scene_camera", config.scene_camera, scene, findings);
  check_camera("sky_camera", config.sky_camera, sky, findings);
}

void check_display(const RunConfig& config, Devices& devices, Clock& clock, Findings& findings) {
  auto display = devices.open_display(config.display);
  if (!display) {
    findings.fail("display.open", display.error().message,
                  "in use by a desktop or another program? sudo fuser -v /dev/dri/card*; id must show the group video");
    return;
  }
  findings.good("display.open", (*display)->description());
  check_gl_context((*display)->context().info(), findings);
  check_mixing((*display)->context().info(), config.mixing, findings);
  check_flips(**display, clock, findings);
}

void check_running(const DoctorRequest& request, const RunConfig& config, const RunningAppliance& before, Clock& clock,
                   Findings& findings) {
  const auto began = clock.now();
  clock.sleep_until(began + request.watch);
  const auto later = find_running_appliance(request.places.status_file, request.places.proc);
  if (!later || later->pid != before.pid)
    findings.fail("service", fmt::format("pid {} ended while it was watched", before.pid), "journalctl -u kasumi -b");
  else
    check_appliance(config, before, *later, to_seconds(clock.now() - began), findings);
  if (const auto gl = open_headless_context())
    check_gl_context((*gl)->info(), findings);
  else
    findings.warn("gl.renderer", gl.error().message, "sudo apt install libgl1-mesa-dri");
}

}  // namespace

std::string_view name_of(Grade grade) {
  switch (grade) {
    case Grade::good: return "good";
    case Grade::warning: return "warning";
    case Grade::failure: return "failure";
  }
  return "";
}

Finding& Findings::good(std::string check, std::string found) {
  return findings_.emplace_back(Finding{std::move(check), Grade::good, std::move(found), {}, {}});
}
Finding& Findings::warn(std::string check, std::string found, std::string advice) {
  return findings_.emplace_back(Finding{std::move(check), Grade::warning, std::move(found), std::move(advice), {}});
}
Finding& Findings::fail(std::string check, std::string found, std::string advice) {
  return findings_.emplace_back(Finding{std::move(check), Grade::failure, std::move(found), std::move(advice), {}});
}
Grade Findings::worst() const {
  Grade worst = Grade::good;
  for (const auto& finding : findings_) worst = std::max(worst, finding.grade);
  return worst;
}

MachinePlaces this_machine() {
  MachinePlaces places;
  places.displays = [] { return list_displays(); };
  places.unit_properties = ask_systemctl;
  return places;
}

Findings examine(const DoctorRequest& request, Devices& devices, Clock& clock) {
  Findings findings;
  const auto config_file = ContentPlace{request.config, request.generations}.configuration();
  const auto content = read_content(config_file);
  if (content)
    findings.good("configuration", config_file.string());
  else
    findings.fail("configuration", content.error().message, "fix the keys named; kasumi run --config FILE --check");

  const auto& places = request.places;
  const auto running = find_running_appliance(places.status_file, places.proc);
  if (content) {
    const auto& config = (*content)->config;
    for (const auto& [name, options] :
         {std::pair{"scene_camera", &config.scene_camera}, {"sky_camera", &config.sky_camera}}) {
      check_camera_path(places, name, *options, findings);
      check_camera_usb(places, name, *options, findings);
    }
    if (const auto* kms = std::get_if<KmsDisplayOptions>(&config.display); kms && places.displays)
      check_connectors(places.displays(), *kms, findings);
    if (running) {
      check_running(request, config, *running, clock, findings);
    } else {
      findings.warn("service", "the appliance is not running", "sudo systemctl start kasumi");
      check_cameras(request, config, devices, clock, findings);
      check_display(config, devices, clock, findings);
    }
    if (config.visitor) check_visitor(*config.visitor, devices, findings);
    check_content(**content, findings);
    check_words(config, findings);
    check_stories(**content, findings);
    check_generation(request.generations, findings);
    const auto& installation = config.installation;
    check_calibration("scene_camera", installation.scene, installation, clock.utc(), findings);
    check_calibration("sky_camera", installation.sky, installation, clock.utc(), findings);
  }
  if (!content && running) check_running(request, RunConfig{}, *running, clock, findings);
  check_clock(content ? (*content)->config.clock : ClockRules{}, watch_time()->read(), clock.utc(), findings);
  check_temperature(places, findings);
  check_throttling(places, findings);
  const auto& state = content && (*content)->config.state_folder ? *(*content)->config.state_folder : places.state;
  check_disk(state, findings);
  check_proof(state, clock.utc(), findings);
  check_watchdogs(places, findings);
  return findings;
}

std::string doctor_text(const Findings& findings) {
  std::string text;
  std::size_t warnings = 0, failures = 0;
  for (const auto& finding : findings.all()) {
    warnings += finding.grade == Grade::warning;
    failures += finding.grade == Grade::failure;
    const char* mark = finding.grade == Grade::good ? "  ok  " : finding.grade == Grade::warning ? " warn " : " FAIL ";
    auto found = finding.found;
    for (std::size_t at = 0; (at = found.find('\n', at)) != std::string::npos; ++at)
      found.replace(at, 1, "\n" + std::string(32, ' '));
    text += fmt::format("{}{:<25} {}\n", mark, finding.check, found);
    if (!finding.advice.empty()) text += fmt::format("{:32}-> {}\n", "", finding.advice);
  }
  return text + fmt::format("failures: {}, warnings: {}\n", failures, warnings);
}

std::string doctor_json(const Findings& findings, Utc utc) {
  nlohmann::ordered_json json;
  json["grade"] = name_of(findings.worst());
  json["utc"] = utc_text(std::chrono::floor<std::chrono::seconds>(utc));
  json["findings"] = nlohmann::ordered_json::array();
  for (const auto& finding : findings.all())
    json["findings"].push_back({{"check", finding.check},
                                {"grade", name_of(finding.grade)},
                                {"found", finding.found},
                                {"advice", finding.advice},
                                {"values", finding.values}});
  return text_of_json(json, 2) + "\n";
}

}  // namespace kasumi

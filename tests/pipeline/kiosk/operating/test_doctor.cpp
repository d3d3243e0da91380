// What the doctor makes of a running appliance, and all its checks on a kiosk with recordings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include "base/outside/json_text.hpp"
#include "tests/pipeline/kiosk/operating/simulated_machine.hpp"
#include "tests/pipeline/machine/fake_input.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;

// Of an appliance that runs with this status.
std::optional<Finding> running(const nlohmann::json& status, const char* check, const RunConfig& config = {}) {
  Findings findings;
  check_appliance(config, {4711, status.dump(), 0.2}, {4711, status.dump(), 0.2}, 3.0, findings);
  return has(findings, check) ? std::optional(found(findings, check)) : std::nullopt;
}

TEST(DoctorAppliance, SafeModeAndRefusedContentAreFailuresThatSayWhy) {
  const nlohmann::json status{
      {"shown", "still"},
      {"start", {{"safe_mode", true}, {"why", {"10 starts failed within 2 minutes, the last one while starting"}}}},
      {"content", {{"refused", {"kasumi.toml: nonsense: unknown key"}}, {"last_good_utc", "2026-06-20T12:00:00Z"}}}};
  EXPECT_EQ(running(status, "service")->grade, Grade::failure);
  EXPECT_THAT(running(status, "service")->found, HasSubstr("10 starts failed"));
  EXPECT_EQ(running(status, "content.refused")->grade, Grade::failure);
  EXPECT_THAT(running(status, "content.refused")->found, AllOf(HasSubstr("nonsense"), HasSubstr("2026-06-20")));
}

nlohmann::json healthy_status() {
  const nlohmann::json camera{{"up", true},
                              {"cause", ""},
                              {"good_frames", 1000},
                              {"bad_frames", nlohmann::json::object()},
                              {"reopened", nlohmann::json::object()},
                              {"condition", "normal"},
                              {"format", "MJPG"},
                              {"width", 1280},
                              {"height", 720},
                              {"mode", {{"frames_per_second", 25.0}, {"driver", "uvcvideo"}}}};
  return {{"shown", "live"},
          {"reason", ""},
          {"display",
           {{"up", true}, {"description", "card0 HDMI-A-1"}, {"flips", 5000}, {"flip_timeouts", 0}, {"resets", 0}}},
          {"scene_camera", camera},
          {"sky_camera", camera},
          {"turbidity", 2.4},
          {"sigma", 0.05},
          {"turbidity_age_s", 3.0},
          {"pid", 4711}};
}

TEST(DoctorAppliance, ReadsItsStatusTwiceAndComparesThem) {
  auto before = healthy_status(), later = healthy_status();
  later["scene_camera"]["good_frames"] = 1075;
  later["sky_camera"]["good_frames"] = 1030;
  later["display"]["flips"] = 5180;
  before["utc"] = "2026-06-21T03:00:00.25Z";
  later["utc"] = "2026-06-21T03:00:03.25Z";
  double age_s = 0.5;
  const auto judged = [&](const char* check) {
    return judged_by(check_appliance, check, RunConfig(), RunningAppliance{4711, before.dump(), 0.2},
                     RunningAppliance{4711, later.dump(), age_s}, 3.8);
  };
  EXPECT_EQ(judged("service").grade, Grade::good);
  EXPECT_EQ(judged("scene_camera.rate").grade, Grade::good);
  EXPECT_DOUBLE_EQ(judged("scene_camera.rate").values["frames_per_second"], 25.0);
  EXPECT_DOUBLE_EQ(judged("sky_camera.rate").values["frames_per_second"], 10.0);
  EXPECT_EQ(judged("sky_camera.rate").grade, Grade::warning) << "10 of 25";
  EXPECT_DOUBLE_EQ(judged("display.flips").values["flips_per_second"], 60.0);
  EXPECT_EQ(judged("air").grade, Grade::good);
  later["scene_camera"]["reopened"] = {{"unplugged", 2}};
  EXPECT_EQ(judged("scene_camera.outages").grade, Grade::warning);
  later["scene_camera"]["bad_frames"] = {{"truncated", 5}};
  EXPECT_EQ(judged("scene_camera.frames").values["bad_now"], 5.0);
  later["scene_camera"]["up"] = false;
  later["scene_camera"]["cause"] = "unplugged";
  EXPECT_EQ(judged("scene_camera.open").grade, Grade::failure);
  later["shown"] = "still";
  EXPECT_EQ(judged("service").grade, Grade::warning);
  later["display"] = {{"up", false}, {"cause", "no connector"}};
  EXPECT_EQ(judged("display.open").grade, Grade::failure);
  later["turbidity"] = nullptr;
  EXPECT_EQ(judged("air").grade, Grade::warning);
  age_s = 60.0;
  EXPECT_EQ(judged("service").grade, Grade::failure);
}

TEST(DoctorAppliance, SaysWhatTheCardsMakeOfTheLightAndWhenThatCannotBe) {
  auto status = healthy_status();
  const auto judged = [&] { return running(status, "air.cards"); };
  EXPECT_FALSE(judged());
  status["cards"] = {{"in_view", 2}, {"read", 0}, {"age_s", nullptr}, {"sun", {1, 1, 1}}, {"around", {1, 1, 1}}};
  ASSERT_TRUE(judged());
  EXPECT_EQ(judged()->grade, Grade::warning);
  EXPECT_THAT(judged()->found, HasSubstr("none of 2"));
  status["cards"] = {
      {"in_view", 2}, {"read", 2}, {"age_s", 3.0}, {"sun", {1.1, 1.05, 1.0}}, {"around", {0.9, 0.9, 0.9}}};
  EXPECT_EQ(judged()->grade, Grade::good);
  EXPECT_THAT(judged()->found, HasSubstr("sun 1.10 1.05 1.00, sky and ground 0.90 0.90 0.90"));
  status["cards"]["around"][2] = 1.6;
  EXPECT_EQ(judged()->grade, Grade::warning);
  EXPECT_THAT(judged()->advice, HasSubstr("reflectance"));
  status["cards"]["sun"] = {1, "x", nullptr};
  EXPECT_FALSE(judged()) << "a damaged status is harmless";
}

TEST(DoctorAppliance, WarnsOfLandmarksThatContradictTheCamerasColours) {
  auto status = healthy_status();
  RunConfig config;  // an unmeasured camera
  const auto judged = [&] { return running(status, "air.saturation", config); };
  EXPECT_FALSE(judged());
  status["visibility"] = {{"saturation", 1.65}, {"saturation_sigma", 0.15}};
  ASSERT_TRUE(judged());
  EXPECT_EQ(judged()->grade, Grade::good) << "it is learnt";
  config.installation.scene_quality.saturation = 1.3;
  EXPECT_EQ(judged()->grade, Grade::good) << "within 3 sigma";
  config.installation.scene_quality.saturation = 1.1;
  EXPECT_EQ(judged()->grade, Grade::warning);
  EXPECT_THAT(judged()->found, HasSubstr("1.65 +- 0.15; it is given as 1.10"));
  config.installation.scene_quality.saturation.reset();
  config.installation.scene.response = Response::linear();
  EXPECT_EQ(judged()->grade, Grade::warning) << "a measured camera shows colours as they are";
  config.installation.scene_tone_exponent = 1.2;
  EXPECT_EQ(judged()->grade, Grade::good) << "its curve was corrected, not measured";
  status["visibility"] = {{"saturation", "x"}, {"saturation_sigma", nullptr}};
  EXPECT_FALSE(judged()) << "a damaged status is harmless";
}

TEST(DoctorAppliance, WarnsOfLandmarksThatContradictTheResponse) {
  auto status = healthy_status();
  RunConfig config;
  const auto judged = [&] { return running(status, "air.tone", config); };
  EXPECT_FALSE(judged());
  status["visibility"] = {{"tone_exponent", 1.15}, {"tone_exponent_sigma", 0.08}};
  ASSERT_TRUE(judged());
  EXPECT_EQ(judged()->grade, Grade::good) << "within 3 sigma";
  status["visibility"] = {{"tone_exponent", 0.7}, {"tone_exponent_sigma", 0.05}};
  EXPECT_EQ(judged()->grade, Grade::warning);
  EXPECT_THAT(judged()->found, HasSubstr("0.70 +- 0.05, which contradicts"));
  EXPECT_THAT(judged()->advice, HasSubstr("tone_exponent = 0.70"));
  config.installation.scene.response = Response::linear();
  EXPECT_EQ(judged()->advice, "kasumi calibrate response") << "a measured curve takes no such key";
  config.installation.scene_tone_exponent = 1.2;
  EXPECT_THAT(judged()->advice, HasSubstr("tone_exponent = 0.84")) << "beside what is corrected already";
  status["visibility"] = {{"tone_exponent", nullptr}, {"tone_exponent_sigma", "x"}};
  EXPECT_FALSE(judged()) << "a damaged status is harmless";
}

TEST(DoctorAppliance, SaysWhoSeesTheAirAndWhenItIsSupposed) {
  auto status = healthy_status();
  const auto judged = [&](const char* check) { return running(status, check); };
  status["air"] = {{"supposed", false}, {"text", "aerosol .21 +- .03 by sky and landmarks"}};
  EXPECT_EQ(judged("air")->grade, Grade::good);
  EXPECT_THAT(judged("air")->found, HasSubstr("by sky and landmarks"));
  EXPECT_FALSE(judged("air.observers"));
  status["visibility"] = {{"finding", true}, {"words", "5.1 standard deviations apart"}};
  ASSERT_TRUE(judged("air.observers"));
  EXPECT_EQ(judged("air.observers")->grade, Grade::warning);
  EXPECT_THAT(judged("air.observers")->found, HasSubstr("apart"));
  status["air"] = {{"supposed", true}, {"text", "the air is supposed: aerosol .15, T 2.5"}};
  EXPECT_EQ(judged("air")->grade, Grade::warning);
  status["turbidity"] = nullptr;
  EXPECT_EQ(judged("air")->grade, Grade::warning);
  EXPECT_THAT(judged("air")->found, HasSubstr("supposed"));
  status["air"] = 7;
  EXPECT_EQ(judged("air")->grade, Grade::warning) << "a damaged status is harmless";
}

TEST(DoctorAppliance, ADamagedStatusIsHarmless) {
  for (const char* text : {"", "[]", "{\"pid\": 4711, \"scene_camera\": 3, \"display\": []}",
                           "{\"scene_camera\": {\"up\": true, \"bad_frames\": 7}}"}) {
    Findings findings;
    check_appliance({}, {4711, text, 0.0}, {4711, text, 0.0}, 3.0, findings);
    EXPECT_NE(findings.worst(), Grade::good) << text;
  }
}

TEST(RunningAppliance, IsFoundOnlyWhileItsProcessLives) {
  Machine machine("running");
  EXPECT_FALSE(find_running_appliance(machine.places.status_file, machine.places.proc));
  machine.run_appliance(healthy_status());
  ASSERT_TRUE(find_running_appliance(machine.places.status_file, machine.places.proc));
  EXPECT_EQ(find_running_appliance(machine.places.status_file, machine.places.proc)->pid, 4711);
  machine.write("proc/4711/comm", "bash\n");
  EXPECT_FALSE(find_running_appliance(machine.places.status_file, machine.places.proc))
      << "the process id belongs to another program now";
  machine.write("run/kasumi/status.json", "{");
  EXPECT_FALSE(find_running_appliance(machine.places.status_file, machine.places.proc));
}

TEST(RunningAppliance, IsFoundWhereProcHidesItIfSystemdNamesIt) {
  Machine machine("hidden");
  auto status = healthy_status();
  status["pid"] = ::getpid();  // lives
  machine.run_appliance(status);
  const auto named = [&](int pid) {
    ::setenv("MAINPID", std::to_string(pid).c_str(), 1);
    const bool is_found = find_running_appliance(machine.places.status_file, machine.places.proc).has_value();
    ::unsetenv("MAINPID");
    return is_found;
  };
  EXPECT_FALSE(find_running_appliance(machine.places.status_file, machine.places.proc));
  EXPECT_TRUE(named(::getpid()));
  EXPECT_FALSE(named(::getppid())) << "another one is its main process";
  status["pid"] = 1 << 23;  // more than the kernel gives
  machine.run_appliance(status);
  EXPECT_FALSE(named(1 << 23)) << "it has ended";
}

TEST(Doctor, ExaminesAStoppedKioskByOpeningItsDevices) {
  Machine machine("kiosk");
  const auto config = write_kiosk(operating_folder("examined"));
  SystemClock clock;
  const auto devices = machine_devices(clock);
  const auto findings = examine({config, 1s, machine.places}, *devices, clock);
  EXPECT_EQ(found(findings, "configuration").grade, Grade::good);
  EXPECT_EQ(found(findings, "service").grade, Grade::warning);
  EXPECT_TRUE(found(findings, "scene_camera.first_frame").values.contains("seconds"));
  EXPECT_GT(found(findings, "scene_camera.rate").values["frames_per_second"], 5.0) << "recorded at 20 a second";
  EXPECT_LT(found(findings, "scene_camera.rate").values["frames_per_second"], 25.0);
  EXPECT_EQ(found(findings, "display.open").grade, Grade::good);
  EXPECT_GT(found(findings, "content.model").values["triangles"], 100.0);
  EXPECT_EQ(found(findings, "content.still").grade, Grade::warning);
  EXPECT_EQ(found(findings, "sky_camera.calibration").grade, Grade::warning);
  for (const auto& finding : findings.all())
    EXPECT_EQ(finding.advice.empty(), finding.grade == Grade::good) << finding.check;

  const auto json = parse_json(doctor_json(findings, std::chrono::sys_days{std::chrono::year{2026} / 6 / 21}));
  EXPECT_EQ(json["findings"].size(), findings.all().size());
  EXPECT_EQ(json["utc"], "2026-06-21T00:00:00Z");
  for (const auto& finding : json["findings"])
    for (const char* key : {"check", "grade", "found", "advice", "values"})
      EXPECT_TRUE(finding.contains(key)) << finding;
  EXPECT_THAT(doctor_text(findings), HasSubstr("sudo systemctl start kasumi"));
}

// Devices that must not be touched.
class Untouchable final : public Devices {
 public:
  CameraOpening camera(CameraRole, const CameraOptions&) override {
    ADD_FAILURE() << "the appliance has the cameras";
    return {};
  }
  Result<std::unique_ptr<Display>> open_display(const DisplayOptions&) override {
    ADD_FAILURE() << "the appliance has the display";
    return fail(FaultKind::device, "busy");
  }
  std::unique_ptr<DisplayWatch> watch_displays() override { return nullptr; }
  Result<std::unique_ptr<CecDevice>> open_television(const std::filesystem::path&) override {
    return fail(FaultKind::disconnected, "no television");
  }
  Result<std::unique_ptr<InputDevice>> open_input(const std::filesystem::path& device) override {
    return open_fake_input(input, device);
  }
  void serve(std::shared_ptr<InputLink>) override { ADD_FAILURE() << "the appliance has the input devices"; }
  FakeInput input;
};

TEST(Doctor, WhileTheApplianceRunsItsStatusIsReadInstead) {
  Machine machine("busy");
  machine.run_appliance(healthy_status());
  const auto config = write_kiosk(operating_folder("examined-running"));
  SystemClock clock;
  Untouchable devices;
  const auto findings = examine({config, 100ms, machine.places}, devices, clock);
  EXPECT_EQ(found(findings, "service").grade, Grade::good);
  EXPECT_THAT(found(findings, "service").found, HasSubstr("pid 4711 shows: live"));
  EXPECT_TRUE(has(findings, "scene_camera.rate"));
}

TEST(Doctor, NamesEachOfTheVisitorsDevicesAsThereOrMissing) {
  Untouchable devices;
  devices.input.devices["/dev/input/by-id/usb-Knob-event-if00"].name = "Knob\n\x1b[2J";
  VisitorOptions options;
  options.devices = {"/dev/input/by-id/usb-Knob-event-if00", "/dev/input/by-id/usb-Lost-event-kbd"};
  Findings findings;
  check_visitor(options, devices, findings);
  ASSERT_EQ(findings.all().size(), 2U);
  EXPECT_EQ(findings.all()[0].grade, Grade::good);
  EXPECT_THAT(findings.all()[0].found, HasSubstr("Knob??[2J"));
  EXPECT_EQ(findings.all()[1].grade, Grade::warning);
  EXPECT_THAT(findings.all()[1].found, HasSubstr("usb-Lost-event-kbd: no such device now"));
  EXPECT_EQ(devices.input.devices.begin()->second.grabbed, 0) << "they are the appliance's";
}

TEST(Doctor, AnInvalidConfigurationIsAFailureAndTheMachineIsExaminedAnyway) {
  Machine machine("refused");
  const auto folder = operating_folder("refused");
  std::ofstream(folder / "kasumi.toml") << "[site]\nlatitude_deg = 134\n";
  SystemClock clock;
  Untouchable devices;
  const auto findings = examine({folder / "kasumi.toml", 100ms, machine.places}, devices, clock);
  EXPECT_EQ(findings.worst(), Grade::failure);
  EXPECT_THAT(found(findings, "configuration").found, HasSubstr("latitude_deg = 134"));
  EXPECT_EQ(found(findings, "disk.write").grade, Grade::good);
}

}  // namespace
}  // namespace kasumi

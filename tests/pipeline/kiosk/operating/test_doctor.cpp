// Each check on a machine simulated by files, and all of them on a kiosk with recordings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>
#include <nlohmann/json.hpp>

#include "pipeline/kiosk/doctor/checks.hpp"
#include "tests/pipeline/kiosk/operating/kiosk.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

// A folder that replaces /sys, /proc, /dev and /run.
class Machine {
 public:
  explicit Machine(const std::string& name) : folder_(operating_folder("machine-" + name)) {
    places.sys = folder_ / "sys";
    places.proc = folder_ / "proc";
    places.dev = folder_ / "dev";
    places.status_file = folder_ / "run/kasumi/status.json";
    places.state = folder_ / "state";
    places.displays = [] { return std::vector<ListedCard>(); };
    places.unit_properties = [this]() -> Result<std::string> { return unit; };
    std::filesystem::create_directories(places.state);
  }
  void write(const std::string& path, const std::string& text) {
    std::filesystem::create_directories((folder_ / path).parent_path());
    std::ofstream(folder_ / path) << text;
  }
  void link(const std::string& path, const std::string& to) {
    std::filesystem::create_directories((folder_ / path).parent_path());
    std::filesystem::create_directories((folder_ / to).parent_path());
    std::filesystem::create_symlink(folder_ / to, folder_ / path);
  }
  // As `kasumi run` would write it.
  void run_appliance(const nlohmann::json& status) {
    write("run/kasumi/status.json", status.dump());
    write("proc/4711/comm", "kasumi\n");
  }

  MachinePlaces places;
  std::string unit =
      "LoadState=loaded\nActiveState=active\nUnitFileState=enabled\nNRestarts=0\nWatchdogUSec=20s\nResult=success\n";

 private:
  std::filesystem::path folder_;
};

Finding found(const Findings& findings, const std::string& check) {
  for (const auto& finding : findings.all())
    if (finding.check == check) return finding;
  ADD_FAILURE() << "no finding " << check << " in\n" << doctor_text(findings);
  return {};
}
bool has(const Findings& findings, const std::string& check) {
  return std::any_of(findings.all().begin(), findings.all().end(), [&](const auto& f) { return f.check == check; });
}

TEST(DoctorAppliance, SafeModeAndRefusedContentAreFailuresThatSayWhy) {
  const nlohmann::json status{
      {"shown", "still"},
      {"start", {{"safe_mode", true}, {"why", {"10 starts failed within 2 minutes, the last one while starting"}}}},
      {"content", {{"refused", {"kasumi.toml: nonsense: unknown key"}}, {"last_good_utc", "2026-06-20T12:00:00Z"}}}};
  Findings findings;
  check_appliance({}, {4711, status.dump(), 0.2}, {4711, status.dump(), 0.2}, 3.0, findings);
  EXPECT_EQ(found(findings, "service").grade, Grade::failure);
  EXPECT_THAT(found(findings, "service").found, HasSubstr("10 starts failed"));
  EXPECT_EQ(found(findings, "content.refused").grade, Grade::failure);
  EXPECT_THAT(found(findings, "content.refused").found, HasSubstr("nonsense"));
  EXPECT_THAT(found(findings, "content.refused").found, HasSubstr("2026-06-20"));
}

constexpr Utc kNow = std::chrono::sys_days{std::chrono::year{2026} / 6 / 21};

TEST(DoctorClock, DistinguishesSynchronizedUnsynchronizedAndImpossibleClocks) {
  ClockOptions choice;
  choice.earliest = std::chrono::sys_days{std::chrono::year{2025} / 1 / 1};
  const auto grade = [&](bool synchronized, Utc now) {
    Findings findings;
    check_clock(choice, {synchronized, 0}, now, findings);
    return found(findings, "clock").grade;
  };
  EXPECT_EQ(grade(true, kNow), Grade::good);
  EXPECT_EQ(grade(false, kNow), Grade::warning);
  EXPECT_EQ(grade(true, Utc{}), Grade::failure) << "1970";
  choice.policy = ClockPolicy::trusted;
  EXPECT_EQ(grade(false, kNow), Grade::good);
}

TEST(DoctorTemperature, IsJudgedByTheZoneNearestToItsLimit) {
  Machine machine("heat");
  machine.write("sys/class/thermal/thermal_zone0/type", "acpitz\n");
  machine.write("sys/class/thermal/thermal_zone0/temp", "45000\n");
  machine.write("sys/class/thermal/thermal_zone1/type", "cpu-thermal\n");
  machine.write("sys/class/thermal/thermal_zone1/temp", "84500\n");
  machine.write("sys/class/thermal/thermal_zone1/trip_point_0_type", "critical\n");
  machine.write("sys/class/thermal/thermal_zone1/trip_point_0_temp", "110000\n");
  const auto judged = [&] {
    Findings findings;
    check_temperature(machine.places, findings);
    return found(findings, "temperature");
  };
  EXPECT_EQ(judged().grade, Grade::warning) << "75 degrees where a zone names no lower limit";
  EXPECT_THAT(judged().found, HasSubstr("cpu-thermal: 8"));
  EXPECT_DOUBLE_EQ(judged().values["celsius"], 84.5);
  machine.write("sys/class/thermal/thermal_zone1/temp", "60000\n");
  EXPECT_EQ(judged().grade, Grade::good);
  machine.write("sys/class/thermal/thermal_zone1/temp", "99000\n");
  EXPECT_EQ(judged().grade, Grade::failure);
  EXPECT_EQ(
      [] {
        Machine bare("no-sensor");
        Findings findings;
        check_temperature(bare.places, findings);
        return found(findings, "temperature").grade;
      }(),
      Grade::good);
}

// Bits as in Raspberry Pi's documentation of `vcgencmd get_throttled`: 0 and 16 under-voltage, 2 and 18 throttled.
TEST(DoctorThrottling, ReadsTheFirmwaresBits) {
  Machine machine("throttled");
  const auto judged = [&](const char* bits) {
    machine.write("sys/devices/platform/soc/soc:firmware/get_throttled", bits);
    Findings findings;
    check_throttling(machine.places, findings);
    return found(findings, "throttling");
  };
  EXPECT_EQ(judged("0\n").grade, Grade::good);
  EXPECT_EQ(judged("50000\n").grade, Grade::warning);
  EXPECT_THAT(judged("50000\n").found, HasSubstr("since boot: the supply's voltage is too low, throttled"));
  EXPECT_EQ(judged("50005\n").grade, Grade::failure);
  EXPECT_THAT(judged("50005\n").advice, HasSubstr("stronger supply"));
  EXPECT_THAT(judged("0x80008\n").found, HasSubstr("now: near the temperature limit"));
}

TEST(DoctorThrottling, CountsAPcsToo) {
  Machine machine("throttled-pc");
  machine.write("sys/devices/system/cpu/cpu0/thermal_throttle/package_throttle_count", "0\n");
  machine.write("sys/devices/system/cpu/cpu1/thermal_throttle/package_throttle_count", "7\n");
  Findings findings;
  check_throttling(machine.places, findings);
  EXPECT_EQ(found(findings, "throttling").grade, Grade::warning);
  EXPECT_EQ(found(findings, "throttling").values["times"], 7.0);
}

TEST(DoctorDisk, WritesToDiskAndLeavesNothingBehind) {
  Machine machine("disk");
  Findings findings;
  check_disk(machine.places.state, findings);
  EXPECT_EQ(found(findings, "disk.write").grade, Grade::good);
  EXPECT_GT(found(findings, "disk.space").values["free_bytes"], 0.0);
  EXPECT_TRUE(std::filesystem::is_empty(machine.places.state));
  Findings missing;
  check_disk(machine.places.state / "not-there", missing);
  EXPECT_EQ(found(missing, "disk.space").grade, Grade::failure);
}

// The folder is another account's, which root must not trust.
TEST(DoctorDisk, WritesThroughNoPlantedLinkAndNotAsRoot) {
  Machine machine("disk-links");
  const auto victim = machine.places.state.parent_path() / "victim.txt";
  ASSERT_TRUE(write_text_file(victim, "untouched"));
  for (const auto& name : {std::string(".doctor-probe"), fmt::format("..doctor-probe.{}.part", ::getpid()),
                           fmt::format(".doctor-probe.{}.part", ::getpid()), fmt::format(".probe.{}.part", ::getpid())})
    std::filesystem::create_symlink(victim, machine.places.state / name);
  Findings findings;
  check_disk(machine.places.state, findings);
  EXPECT_EQ(found(findings, "disk.write").grade, Grade::good) << found(findings, "disk.write").found;
  EXPECT_EQ(read_text_file(victim).value(), "untouched");
  int links = 0;
  for (const auto& entry : std::filesystem::directory_iterator(machine.places.state)) links += entry.is_symlink();
  EXPECT_EQ(links, 4) << "nor was any replaced";

  if (::geteuid() != 0) GTEST_SKIP() << "only root changes accounts";
  constexpr uid_t kOther = 65534;
  ASSERT_EQ(::chown(machine.places.state.c_str(), kOther, kOther), 0);
  ASSERT_EQ(::chmod(machine.places.state.c_str(), 0500), 0);
  Findings refused;
  check_disk(machine.places.state, refused);
  EXPECT_EQ(found(refused, "disk.write").grade, Grade::failure) << "as root it would have worked";
  EXPECT_THAT(found(refused, "disk.write").found, HasSubstr("may not be written"));
  ASSERT_EQ(::chmod(machine.places.state.c_str(), 0700), 0);
  Findings allowed;
  check_disk(machine.places.state, allowed);
  EXPECT_EQ(found(allowed, "disk.write").grade, Grade::good) << found(allowed, "disk.write").found;
}

TEST(DoctorWatchdog, RequiresSystemdsAndTheMachines) {
  Machine machine("watchdog");
  machine.write("sys/class/watchdog/watchdog0/identity", "Broadcom BCM2835 Watchdog timer\n");
  machine.write("sys/class/watchdog/watchdog0/state", "inactive\n");
  const auto checked = [&] {
    Findings findings;
    check_watchdogs(machine.places, findings);
    return findings;
  };
  EXPECT_EQ(found(checked(), "watchdog.service").grade, Grade::good);
  EXPECT_EQ(found(checked(), "watchdog.machine").grade, Grade::warning);
  EXPECT_THAT(found(checked(), "watchdog.machine").advice, HasSubstr("RuntimeWatchdogSec"));
  machine.write("sys/class/watchdog/watchdog0/state", "active\n");
  machine.write("sys/class/watchdog/watchdog0/timeout", "15\n");
  EXPECT_EQ(found(checked(), "watchdog.machine").grade, Grade::good);
  EXPECT_EQ(found(checked(), "service.unit").grade, Grade::good);

  machine.unit =
      "LoadState=loaded\nActiveState=failed\nUnitFileState=disabled\nNRestarts=3\nWatchdogUSec=0\n"
      "Result=exit-code\nExecMainStatus=78\n";
  EXPECT_EQ(found(checked(), "service.unit").grade, Grade::failure);
  EXPECT_THAT(found(checked(), "service.unit").advice, HasSubstr("--check"));
  EXPECT_EQ(found(checked(), "service.restarts").values["restarts"], 3.0);
  EXPECT_EQ(found(checked(), "watchdog.service").grade, Grade::warning);
  machine.unit = "LoadState=not-found\n";
  EXPECT_THAT(found(checked(), "service.unit").found, HasSubstr("not installed"));
  machine.places.unit_properties = []() -> Result<std::string> { return fail(FaultKind::unsupported, "no systemd"); };
  EXPECT_EQ(found(checked(), "service.unit").grade, Grade::warning);
}

V4l2Options usb_camera() {
  V4l2Options camera;
  camera.device = "/dev/v4l/by-id/usb-Sky-video-index0";
  camera.request.format = four_cc("YUYV");
  camera.request.width = 1280;
  camera.request.height = 720;
  camera.request.frames_per_second = 30.0;
  return camera;
}

TEST(DoctorUsb, ComparesTheCamerasDataRateWithTheBus) {
  Machine machine("usb");
  machine.write("dev/video2", "");
  machine.link("dev/v4l/by-id/usb-Sky-video-index0", "dev/video2");
  machine.write("sys/devices/pci/usb1/1-2/speed", "480\n");
  machine.write("sys/devices/pci/usb1/1-2/1-2:1.0/interface", "");
  machine.link("sys/class/video4linux/video2/device", "sys/devices/pci/usb1/1-2/1-2:1.0");
  auto camera = usb_camera();
  const auto judged = [&] {
    Findings findings;
    check_camera_usb(machine.places, "sky_camera", camera, findings);
    return found(findings, "sky_camera.usb");
  };
  EXPECT_EQ(judged().grade, Grade::warning) << "1280 x 720 x 2 bytes x 30 = 55 MB/s";
  EXPECT_THAT(judged().found, HasSubstr("takes 55 MB/s"));
  camera.request.format = kMjpg;
  EXPECT_EQ(judged().grade, Grade::good);
  EXPECT_EQ(judged().values["mbit_per_s"], 480.0);
  machine.write("sys/devices/pci/usb1/1-2/speed", "12\n");
  EXPECT_EQ(judged().grade, Grade::failure);
  camera = usb_camera();
  machine.write("sys/devices/pci/usb1/1-2/speed", "5000\n");
  EXPECT_EQ(judged().grade, Grade::good);
  machine.write("sys/devices/platform/csi/name", "");
  std::filesystem::remove(machine.places.sys / "class/video4linux/video2/device");
  machine.link("sys/class/video4linux/video2/device", "sys/devices/platform/csi");
  Findings none;
  check_camera_usb(machine.places, "sky_camera", camera, none);
  EXPECT_FALSE(has(none, "sky_camera.usb")) << "not on USB: no finding";
}

TEST(DoctorCamera, RecommendsAStableName) {
  Machine machine("path");
  machine.write("dev/video2", "");
  machine.link("dev/v4l/by-id/usb-Sky-video-index0", "dev/video2");
  auto camera = usb_camera();
  const auto judged = [&] {
    Findings findings;
    check_camera_path(machine.places, "sky_camera", camera, findings);
    return found(findings, "sky_camera.path");
  };
  EXPECT_EQ(judged().grade, Grade::good);
  EXPECT_THAT(judged().found, HasSubstr("is video2"));
  camera.device = "/dev/video2";
  EXPECT_EQ(judged().grade, Grade::warning);
  camera.device = "/dev/v4l/by-id/usb-Gone-video-index0";
  EXPECT_EQ(judged().grade, Grade::failure);
}

TEST(DoctorCamera, ComparesTheMeasurementWithTheRequest) {
  const CameraOptions choice = usb_camera();
  CameraMeasurement seen;
  seen.opened = true;
  seen.first_frame_s = 0.4;
  seen.good = 88;
  seen.lasted_s = 3.0;
  seen.mode = CameraMode{};
  seen.mode->format = four_cc("YUYV");
  seen.mode->frames_per_second = 30.0;
  const auto judged = [&](const char* check) {
    Findings findings;
    check_camera("scene_camera", choice, seen, findings);
    return found(findings, check);
  };
  EXPECT_EQ(judged("scene_camera.rate").grade, Grade::good) << "29.3 of 30";
  EXPECT_NEAR(judged("scene_camera.rate").values["frames_per_second"], 29.33, 0.01);
  EXPECT_EQ(judged("scene_camera.frames").grade, Grade::good);
  EXPECT_EQ(judged("scene_camera.mode").grade, Grade::good);
  seen.good = 45;
  EXPECT_EQ(judged("scene_camera.rate").grade, Grade::warning);
  seen.bad = {{"truncated", 2}};
  EXPECT_EQ(judged("scene_camera.frames").grade, Grade::warning);
  EXPECT_THAT(judged("scene_camera.frames").found, HasSubstr("2 truncated"));
  seen.mode->notes = {"exposure: the driver has none"};
  EXPECT_EQ(judged("scene_camera.mode").grade, Grade::warning);
  seen.first_frame_s.reset();
  seen.problem = "no good frame came in 4 s";
  EXPECT_EQ(judged("scene_camera.first_frame").grade, Grade::failure);
  seen.opened = false;
  seen.problem = "VIDIOC_STREAMON: in use by another program";
  EXPECT_EQ(judged("scene_camera.open").grade, Grade::failure);
}

ListedCard card() {
  ListedCard card;
  card.path = "/dev/dri/card0";
  card.driver = "vc4";
  card.atomic = true;
  card.connectors.push_back(
      {"HDMI-A-1", "connected", "DEL U2412M", "", "1920x1200@59.95", {"1920x1200@59.95", "1920x1080@60.00"}});
  card.connectors.push_back({"HDMI-A-2", "disconnected", "", "", "", {}});
  return card;
}

TEST(DoctorDisplay, NamesConnectorModeAndWhoHoldsTheScreen) {
  auto listed = card();
  listed.users = "Xorg (pid 812) is master";
  KmsDisplayOptions options;
  const auto judged = [&](const char* check) {
    Findings findings;
    check_connectors({listed}, options, findings);
    return found(findings, check);
  };
  EXPECT_EQ(judged("display.connector").grade, Grade::good);
  EXPECT_THAT(judged("display.connector").found, HasSubstr("HDMI-A-1 (connected, DEL U2412M)"));
  EXPECT_THAT(judged("display.master").found, HasSubstr("Xorg (pid 812) is master"));
  options.width = 1920;
  options.height = 1080;
  EXPECT_EQ(judged("display.modes").grade, Grade::good);
  options.width = 3840;
  EXPECT_EQ(judged("display.modes").grade, Grade::failure);
  EXPECT_THAT(judged("display.modes").advice, HasSubstr("1920x1080@60.00"));
  options.connector = "HDMI-A-2";
  EXPECT_EQ(judged("display.connector").grade, Grade::failure);
  options.connector = "DP-7";
  EXPECT_THAT(judged("display.connector").advice, HasSubstr("HDMI-A-1"));
  options = {};
  listed.connectors[0].modes.clear();
  EXPECT_EQ(judged("display.modes").grade, Grade::failure) << "connected, and lists no modes";
  Findings none;
  check_connectors({}, options, none);
  EXPECT_EQ(found(none, "display.card").grade, Grade::failure);
}

TEST(DoctorDisplay, TellsWhetherPicturesNeedTheGpu) {
  auto listed = card();
  const auto judged = [&] {
    Findings findings;
    check_connectors({listed}, {}, findings);
    return found(findings, "display.planes");
  };
  listed.no_planes = "the display has no overlay plane";
  EXPECT_EQ(judged().found, "/dev/dri/card0: the GPU composes each picture: the display has no overlay plane");
  EXPECT_EQ(judged().grade, Grade::good);
  listed.plane_formats = {"XR24", "NV12"};
  EXPECT_THAT(judged().found, HasSubstr("over pictures in XR24, NV12"));
}

TEST(DoctorDisplay, WarnsOfSoftwareGl) {
  GlInfo info;
  info.renderer = "llvmpipe (LLVM 15.0.6, 256 bits)";
  info.software = true;
  Findings findings;
  check_gl(info, findings);
  EXPECT_EQ(found(findings, "gl.renderer").grade, Grade::warning);
  info.software = false;
  Findings hardware;
  check_gl(info, hardware);
  EXPECT_EQ(found(hardware, "gl.renderer").grade, Grade::good);
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
  const RunConfig config;
  auto before = healthy_status(), later = healthy_status();
  later["scene_camera"]["good_frames"] = 1075;
  later["sky_camera"]["good_frames"] = 1030;
  later["display"]["flips"] = 5180;
  before["utc"] = "2026-06-21T03:00:00.25Z";
  later["utc"] = "2026-06-21T03:00:03.25Z";
  double age_s = 0.5;
  const auto judged = [&](const char* check) {
    Findings findings;
    check_appliance(config, {4711, before.dump(), 0.2}, {4711, later.dump(), age_s}, 3.8, findings);
    return found(findings, check);
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
  const auto judged = [&]() -> std::optional<Finding> {
    Findings findings;
    check_appliance({}, {4711, status.dump(), 0.2}, {4711, status.dump(), 0.2}, 3.0, findings);
    return has(findings, "air.cards") ? std::optional(found(findings, "air.cards")) : std::nullopt;
  };
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

TEST(DoctorAppliance, SaysWhoSeesTheAirAndWhenItIsSupposed) {
  auto status = healthy_status();
  const auto judged = [&](const char* check) {
    Findings findings;
    check_appliance({}, {4711, status.dump(), 0.2}, {4711, status.dump(), 0.2}, 3.0, findings);
    return has(findings, check) ? std::optional(found(findings, check)) : std::nullopt;
  };
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

  const auto json = nlohmann::json::parse(doctor_json(findings, kNow));
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

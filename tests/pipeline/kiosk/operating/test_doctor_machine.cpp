// Each check of the machine, its cameras and its display.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include "tests/pipeline/kiosk/operating/simulated_machine.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

constexpr Utc kNow = std::chrono::sys_days{std::chrono::year{2026} / 6 / 21};

TEST(DoctorClock, DistinguishesSynchronizedUnsynchronizedAndImpossibleClocks) {
  ClockRules choice;
  choice.earliest = std::chrono::sys_days{std::chrono::year{2025} / 1 / 1};
  const auto grade = [&](bool synchronized, Utc now) {
    return judged_by(check_clock, "clock", choice, ClockState{synchronized, 0}, now).grade;
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
  const auto judged = [&] { return judged_by(check_temperature, "temperature", machine.places); };
  EXPECT_EQ(judged().grade, Grade::warning) << "75 degrees where a zone names no lower limit";
  EXPECT_THAT(judged().found, HasSubstr("cpu-thermal: 8"));
  EXPECT_DOUBLE_EQ(judged().values["celsius"], 84.5);
  machine.write("sys/class/thermal/thermal_zone1/temp", "60000\n");
  EXPECT_EQ(judged().grade, Grade::good);
  machine.write("sys/class/thermal/thermal_zone1/temp", "99000\n");
  EXPECT_EQ(judged().grade, Grade::failure);
  EXPECT_EQ(judged_by(check_temperature, "temperature", Machine("no-sensor").places).grade, Grade::good);
}

// Bits as in Raspberry Pi's documentation of `vcgencmd get_throttled`: 0 and 16 under-voltage, 2 and 18 throttled.
TEST(DoctorThrottling, ReadsTheFirmwaresBits) {
  Machine machine("throttled");
  const auto judged = [&](const char* bits) {
    machine.write("sys/devices/platform/soc/soc:firmware/get_throttled", bits);
    return judged_by(check_throttling, "throttling", machine.places);
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
  auto judged = judged_by(check_throttling, "throttling", machine.places);
  EXPECT_EQ(judged.grade, Grade::warning);
  EXPECT_EQ(judged.values["times"], 7.0);
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
    return judged_by(check_camera_usb, "sky_camera.usb", machine.places, "sky_camera", camera);
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
    return judged_by(check_camera_path, "sky_camera.path", machine.places, "sky_camera", camera);
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
  OpeningTrial seen;
  seen.opened = true;
  seen.first_frame_s = 0.4;
  seen.good = 88;
  seen.lasted_s = 3.0;
  seen.mode = CameraMode{};
  seen.mode->format = four_cc("YUYV");
  seen.mode->frames_per_second = 30.0;
  const auto judged = [&](const char* check) { return judged_by(check_camera, check, "scene_camera", choice, seen); };
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
  EXPECT_THAT(judged("scene_camera.first_frame").advice, HasSubstr("replug it"));
  const auto of_recording = [&] {
    const CameraOptions recording = ReplayCamera{"/srv/recording"};
    return judged_by(check_camera, "scene_camera.first_frame", "scene_camera", recording, seen).advice;
  };
  EXPECT_THAT(of_recording(), HasSubstr("record it again")) << "no cable";
  seen.problem = "no frame can be used: 1280x720 instead of 960x540 (17)";
  EXPECT_THAT(judged("scene_camera.first_frame").advice, HasSubstr("calibrate"));
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
    return judged_by(check_connectors, check, std::vector{listed}, options);
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
  EXPECT_EQ(judged_by(check_connectors, "display.card", std::vector<ListedCard>(), options).grade, Grade::failure);
}

TEST(DoctorDisplay, TellsWhetherPicturesNeedTheGpu) {
  auto listed = card();
  const auto judged = [&] {
    return judged_by(check_connectors, "display.planes", std::vector{listed}, KmsDisplayOptions());
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
  EXPECT_EQ(judged_by(check_gl_context, "gl.renderer", info).grade, Grade::warning);
  info.software = false;
  EXPECT_EQ(judged_by(check_gl_context, "gl.renderer", info).grade, Grade::good);
}

}  // namespace
}  // namespace kasumi

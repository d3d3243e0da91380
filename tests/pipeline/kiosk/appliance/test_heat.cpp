// A machine that is too hot shows fewer pictures, never none (design: faults, row 25).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_text.hpp"
#include "pipeline/kiosk/doctor/checks.hpp"
#include "pipeline/machine/heat.hpp"
#include "tests/pipeline/kiosk/appliance/rig.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// A thermal zone and a Raspberry Pi's firmware as sysfs shows them.
class FakeHeat {
 public:
  explicit FakeHeat(std::filesystem::path sys) : sys_(std::move(sys)) {
    std::filesystem::create_directories(zone());
    write(zone() / "type", "cpu-thermal");
    write(zone() / "trip_point_0_type", "critical");
    write(zone() / "trip_point_0_temp", "110000");
    set(50.0);
  }
  void set(double celsius) { write(zone() / "temp", std::to_string(static_cast<int>(celsius * 1000.0))); }
  void set_bits(const char* bits) {
    const auto folder = sys_ / "devices/platform/soc/soc:firmware";
    std::filesystem::create_directories(folder);
    write(folder / "get_throttled", bits);
  }

 private:
  std::filesystem::path zone() const { return sys_ / "class/thermal/thermal_zone0"; }
  static void write(const std::filesystem::path& file, const std::string& line) {
    ASSERT_TRUE(write_text_file(file, line + "\n"));
  }
  std::filesystem::path sys_;
};

// The share of the camera's pictures that reached the screen meanwhile.
double share_shown(Rig& rig, Duration during) {
  const auto shown = rig.status().render.scene_frames, delivered = rig.status().scene_camera.health.good_frames;
  for (Duration turned{}; turned < during; turned += Rig::kTick) {
    rig.advance(Rig::kTick);
    EXPECT_EQ(rig.shown(), Shown::live) << "fewer pictures, never none";
  }
  return static_cast<double>(rig.status().render.scene_frames - shown) /
         static_cast<double>(rig.status().scene_camera.health.good_frames - delivered);
}

nlohmann::json heat_of(const Rig& rig) {
  rig.status();
  return parse_json(read_text_file(rig.folder / "status.json").value())["heat"];
}

TEST(Appliance, Row25AMachineThatIsTooHotShowsFewerPictures) {
  // Five pictures a second: late enough for a quarter of them.
  const auto rig =
      running({.name = "row25", .more_config = "\n[ladder]\nheld_s = 4.0\nlate_s = 2.0\n\n[heat]\nhold_s = 20.0\n"});
  FakeHeat machine(rig->folder / "sys");
  rig->advance(6s);
  EXPECT_EQ(heat_of(*rig)["pictures_share"], 1.0);
  EXPECT_EQ(heat_of(*rig)["zone"], "cpu-thermal");
  EXPECT_NEAR(share_shown(*rig, 6s), 1.0, 0.05);

  machine.set(76.0);
  rig->advance(6s);
  EXPECT_EQ(heat_of(*rig)["pictures_share"], 0.5);
  EXPECT_NEAR(share_shown(*rig, 8s), 0.5, 0.05);
  EXPECT_THAT(rig->notifier.lines.back(), HasSubstr("every second picture"));

  machine.set(86.0);
  rig->advance(6s);
  EXPECT_EQ(heat_of(*rig)["pictures_share"], 0.25);
  EXPECT_NEAR(share_shown(*rig, 8s), 0.25, 0.05);
  EXPECT_GT(heat_of(*rig)["spared"].get<int>(), 30);
  Findings findings;
  const auto status = read_text_file(rig->folder / "status.json").value();
  check_appliance({}, {4711, status, 0.1}, {4711, status, 0.1}, 3.0, findings);
  const auto& all = findings.all();
  const auto found =
      std::find_if(all.begin(), all.end(), [](const Finding& finding) { return finding.check == "heat"; });
  ASSERT_NE(found, all.end());
  EXPECT_EQ(found->grade, Grade::warning);
  EXPECT_THAT(found->found, HasSubstr("25 %"));

  machine.set(50.0);
  rig->advance(12s, 200ms);
  EXPECT_EQ(heat_of(*rig)["pictures_share"], 0.5) << "one step at a time";
  rig->advance(26s, 200ms);
  EXPECT_EQ(heat_of(*rig)["pictures_share"], 1.0);
  EXPECT_NEAR(share_shown(*rig, 6s), 1.0, 0.05);
}

TEST(Appliance, Row25APictureIsNeverSparedSoLongThatItIsHeld) {
  const auto rig = running({.name = "row25-slow"});  // five pictures a second, held after half a second
  FakeHeat machine(rig->folder / "sys");
  machine.set(90.0);
  rig->advance(6s);
  EXPECT_EQ(heat_of(*rig)["pictures_share"], 0.25);
  EXPECT_NEAR(share_shown(*rig, 6s), 0.5, 0.05);
}

TEST(Appliance, Row25HeatCanBeReportedOnly) {
  const auto rig = running({.name = "row25-off", .more_config = "\n[heat]\nfewer_pictures = false\n"});
  FakeHeat machine(rig->folder / "sys");
  machine.set(90.0);
  rig->advance(6s);
  EXPECT_EQ(heat_of(*rig)["pictures_share"], 1.0);
  EXPECT_EQ(heat_of(*rig)["celsius"], 90.0);
}

std::vector<ThermalZone> zone_at(double celsius) {
  return {{"cpu", celsius, 75.0, 85.0}, {"board", 30.0, 75.0, 85.0}};
}

TEST(HeatGovernor, ChangesDownAtOnceAndUpWithHysteresis) {
  HeatGovernor governor;
  const HeatLimits options;
  Instant now{1000s};
  EXPECT_EQ(governor.step(now, zone_at(74.9), false, options), 1);
  EXPECT_EQ(governor.step(now += 5s, zone_at(75.0), false, options), 2);
  EXPECT_EQ(governor.step(now += 5s, zone_at(85.0), false, options), 4);
  EXPECT_EQ(governor.step(now += 5min, zone_at(81.0), false, options), 4) << "not cool enough by a degree";
  EXPECT_EQ(governor.step(now += 5s, zone_at(79.0), false, options), 2);
  EXPECT_EQ(governor.step(now += 5min, zone_at(71.0), false, options), 2);
  EXPECT_EQ(governor.step(now += 5s, zone_at(69.0), false, options), 1);
}

TEST(HeatGovernor, DoesNotFlicker) {
  HeatGovernor governor;
  const HeatLimits options;
  Instant now{1000s};
  int changes = 0, last = 1;
  for (int i = 0; i < 720; ++i) {  // an hour around a limit, by much more than the hysteresis
    const int one_of = governor.step(now += 5s, zone_at(i % 2 ? 78.0 : 60.0), false, options);
    changes += std::exchange(last, one_of) != one_of;
  }
  EXPECT_LE(changes, 120) << "twice a minute at most";
  EXPECT_GE(changes, 1);
}

TEST(HeatGovernor, FollowsTheFirmwareWhereThereIsNoSensor) {
  HeatGovernor governor;
  const HeatLimits options;
  Instant now{1000s};
  EXPECT_EQ(governor.step(now, {}, true, options), 2);
  EXPECT_EQ(governor.step(now += 30s, {}, true, options), 2) << "half may be enough";
  EXPECT_EQ(governor.step(now += 31s, {}, true, options), 4);
  EXPECT_EQ(governor.step(now += 61s, {}, false, options), 2);
  EXPECT_EQ(governor.step(now += 61s, {}, false, options), 1);
}

TEST(Heat, ReadsTheKernelsZonesAndTheFirmwaresBits) {
  const auto sys = test_folder("heat-sys");
  std::filesystem::remove_all(sys);  // of an earlier run
  EXPECT_TRUE(read_thermal_zones(sys).empty());
  EXPECT_FALSE(read_throttling_bits(sys));
  FakeHeat machine(sys);
  machine.set(61.5);
  const auto zones = read_thermal_zones(sys);
  ASSERT_EQ(zones.size(), 1u);
  EXPECT_EQ(zones[0].name, "cpu-thermal");
  EXPECT_DOUBLE_EQ(zones[0].celsius, 61.5);
  EXPECT_DOUBLE_EQ(zones[0].hot_celsius, 85.0);
  machine.set(-273.0);
  EXPECT_TRUE(read_thermal_zones(sys).empty()) << "a sensor that is off";
  machine.set_bits("80008");
  EXPECT_TRUE(is_throttled(read_throttling_bits(sys).value()));
  machine.set_bits("d0000");
  EXPECT_FALSE(is_throttled(read_throttling_bits(sys).value())) << "since boot, not now";
  machine.set_bits("50001");
  EXPECT_FALSE(is_throttled(read_throttling_bits(sys).value())) << "a weak supply is not heat";
}

}  // namespace
}  // namespace kasumi

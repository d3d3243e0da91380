// What `kasumi bench --board` says of a machine, and what it does not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "pipeline/lab/bench/machine_board.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class BoardReport : public testing::Test {
 protected:
  void put(const std::filesystem::path& file, std::string_view text) {
    std::filesystem::create_directories((folder_ / file).parent_path());
    must(write_text_file(folder_ / file, text));
  }
  std::string text() const { return machine_text({folder_ / "sys", folder_ / "proc"}); }

  const std::filesystem::path folder_ =
      test_folder("board") / testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(BoardReport, NamesBoardProcessorSpeedAndMemory) {
  put("proc/device-tree/model", std::string_view("Raspberry Pi 4 Model B Rev 1.4\0", 31));
  put("proc/device-tree/serial-number", "10000000abcdef01");
  put("proc/cpuinfo", "processor\t: 0\nCPU implementer\t: 0x41\nCPU part\t: 0xd08\nSerial\t: 10000000abcdef01\n");
  put("proc/meminfo", "MemTotal:        3884376 kB\nMemFree:  1 kB\n");
  put("sys/devices/system/cpu/cpufreq/policy0/cpuinfo_max_freq", "1500000\n");
  put("sys/devices/system/cpu/cpufreq/policy0/scaling_governor", "ondemand\n");
  EXPECT_THAT(text(),
              AllOf(StartsWith("board: Raspberry Pi 4 Model B Rev 1.4\nkernel: Linux "),
                    HasSubstr("\nprocessor: 1 x CPU implementer 0x41, CPU part 0xd08\n"),
                    HasSubstr("\nspeed: 1500 MHz at most (ondemand)\nmemory: 3884376 kB\n"), Not(HasSubstr("abcdef"))));
}

TEST_F(BoardReport, APcIsNamedByItsFirmware) {
  put("sys/class/dmi/id/sys_vendor", "Beelink\n");
  put("sys/class/dmi/id/product_name", "EQ12\n");
  put("sys/class/dmi/id/product_serial", "S3R1AL\n");
  EXPECT_THAT(text(), AllOf(StartsWith("board: Beelink EQ12\n"), Not(HasSubstr("S3R1AL"))));
}

TEST_F(BoardReport, AMachineThatSaysNothingIsReportedAllTheSame) {
  std::filesystem::create_directories(folder_ / "empty");
  EXPECT_THAT(machine_text({folder_ / "empty", folder_ / "empty"}),
              AllOf(StartsWith("board: not known\n"), HasSubstr("\nprocessor: 0 x\n"), Not(HasSubstr("memory"))));
}

TEST(BoardDisplays, AreListedByPlanesAndPathNotByName) {
  ListedCard card;
  card.path = "/dev/dri/card1";
  card.by_path = "/dev/dri/by-path/platform-gpu-card";
  card.driver = "vc4";
  card.atomic = true;
  card.users = "kasumi (pid 411) is master";
  card.connectors = {{.name = "HDMI-A-1",
                      .connection = "connected",
                      .display = "DEL U2412M",
                      .mode_now = "1920x1080@60.00",
                      .preferred = "1920x1080@60.00",
                      .modes = {}}};
  card.planes = {"overlay: AR24 NV12; premultiplied; height 1 to 17"};
  card.plane_formats = {"XR24", "NV12"};
  EXPECT_EQ(displays_text({card}),
            "card: vc4, atomic\n"
            "connector: HDMI-A-1 connected, now 1920x1080@60.00, prefers 1920x1080@60.00\n"
            "plane: overlay: AR24 NV12; premultiplied; height 1 to 17\n"
            "planes: vc4 lays the building over pictures in XR24, NV12 by itself\n");
  card.plane_formats.clear();
  card.no_planes = "no plane converts nv12";
  EXPECT_THAT(displays_text({card}),
              HasSubstr("\nplanes: vc4: the GPU composes each picture: no plane converts nv12\n"));
  EXPECT_THAT(displays_text({}), StartsWith("planes: no graphics card"));
}

TEST(BoardDecoders, AreListedByTheirFormats) {
  EXPECT_EQ(decoders_text({{"bcm2835-codec", {"H264", "MJPG"}, {"NV12"}}}),
            "decoder: bcm2835-codec: H264 MJPG to NV12\n");
  EXPECT_THAT(decoders_text({}), StartsWith("decoder: none by V4L2"));
}

}  // namespace
}  // namespace kasumi

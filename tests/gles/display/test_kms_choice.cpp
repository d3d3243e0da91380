// Choice of connector and mode, reading a display's EDID, and finding who has a card open.
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gles/display/kms_choice.hpp"
#include "gles/display/kms_edid.hpp"
#include "tests/gles/display/kms_fake.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

const KmsConnector kTelevision =
    fake_connector(1, "HDMI-A-1",
                   {fake_mode(3840, 2160, 30, true), fake_mode(1920, 1080, 60.0), fake_mode(1920, 1080, 59.94),
                    fake_mode(1920, 1080, 50), fake_mode(1920, 1080, 60, false, true), fake_mode(720, 576, 50)});

Result<KmsMode> chosen(int width, int height, double refresh_hz) {
  KmsDisplayOptions options;
  options.width = width;
  options.height = height;
  options.refresh_hz = refresh_hz;
  return choose_mode(kTelevision, options);
}

TEST(KmsModes, DefaultToTheDisplaysPreferredMode) {
  EXPECT_EQ(chosen(0, 0, 0)->text(), "3840x2160@30.00");
}

TEST(KmsModes, PickTheFastestProgressiveModeOfASize) {
  EXPECT_EQ(chosen(1920, 1080, 0)->text(), "1920x1080@60.00");
}

TEST(KmsModes, PickTheNearestRefreshRate) {
  EXPECT_EQ(chosen(1920, 1080, 59.94)->text(), "1920x1080@59.94");
  EXPECT_EQ(chosen(1920, 1080, 50)->text(), "1920x1080@50.00");
  EXPECT_EQ(chosen(720, 576, 50.5)->text(), "720x576@50.00");
}

TEST(KmsModes, ListTheAvailableModesWhenNoneMatches) {
  for (const auto& refused : {chosen(1920, 1080, 75), chosen(1024, 768, 0), chosen(0, 0, 60)}) {
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, FaultKind::bad_input);
    EXPECT_THAT(refused.error().message,
                AllOf(HasSubstr("HDMI-A-1"), HasSubstr("3840x2160@30.00 (preferred)"), HasSubstr("1920x1080i@60.00")));
  }
  EXPECT_THAT(chosen(1024, 768, 0).error().message, HasSubstr("does not offer 1024x768;"));
  EXPECT_THAT(chosen(1920, 1080, 75).error().message, HasSubstr("1920x1080 at 75 Hz"));
  EXPECT_THAT(chosen(1920, 0, 0).error().message, HasSubstr("expected both or none"));
}

TEST(KmsModes, FallBackToTheKernelsFirstWhenNoneIsPreferred) {
  const KmsConnector plain = fake_connector(1, "VGA-1", {fake_mode(1024, 768, 60), fake_mode(800, 600, 60)});
  EXPECT_EQ(choose_mode(plain, {})->text(), "1024x768@60.00");
}

TEST(KmsConnectors, PickTheFirstConnectedOneWithModes) {
  const auto off = fake_connector(1, "HDMI-A-1", {}, KmsConnection::disconnected);
  const auto empty = fake_connector(2, "HDMI-A-2", {});
  const auto perhaps = fake_connector(3, "VGA-1", {fake_mode(800, 600, 60)}, KmsConnection::unknown);
  const auto good = fake_connector(4, "DP-1", {fake_mode(800, 600, 60)});
  EXPECT_EQ(choose_connector({off, empty, perhaps, good}, "")->name, "DP-1");
  EXPECT_EQ(choose_connector({off, empty, perhaps}, "")->name, "VGA-1");
  EXPECT_EQ(choose_connector({off, empty, perhaps, good}, "VGA-1")->name, "VGA-1");

  EXPECT_THAT(choose_connector({off, empty}, ""),
              FailsAs(FaultKind::disconnected,
                      AllOf(HasSubstr("HDMI-A-1: disconnected"), HasSubstr("HDMI-A-2: lists no modes"))));
  EXPECT_EQ(choose_connector({off, good}, "HDMI-A-1").error().kind, FaultKind::disconnected);
  EXPECT_EQ(choose_connector({empty, good}, "HDMI-A-2").error().kind, FaultKind::disconnected);
  const auto misspelt = choose_connector({off, good}, "HDMI-1");
  EXPECT_EQ(misspelt.error().kind, FaultKind::bad_input);
  EXPECT_THAT(misspelt.error().message, AllOf(HasSubstr("\"HDMI-1\""), HasSubstr("HDMI-A-1"), HasSubstr("DP-1")));
}

// By VESA E-EDID 1.4: three letters of five bits from byte 8 (big endian), product code at 10 (little endian),
// descriptors of 18 bytes from 54, tag 0xfc for the name, ended by a line feed and padded with blanks.
std::vector<std::uint8_t> edid_of_a_dell() {
  std::vector<std::uint8_t> edid(128);
  std::fill_n(edid.begin() + 1, 6, std::uint8_t{0xff});
  edid[8] = 0x10;  // D = 4, E = 5, L = 12: 0 00100 00101 01100
  edid[9] = 0xac;
  edid[10] = 0x7b;
  edid[11] = 0xa0;
  const std::string name = "DELL U2412M\n ";
  edid[54 + 18 + 3] = 0xfc;
  std::ranges::copy(name, edid.begin() + 54 + 18 + 5);
  edid[54] = 1;  // the first descriptor is a timing
  return edid;
}

TEST(Edids, NameMakerAndModel) {
  auto edid = edid_of_a_dell();
  EXPECT_EQ(edid_name(edid), "DEL DELL U2412M");
  edid[54 + 18 + 3] = 0xff;  // no name, but a serial number
  EXPECT_EQ(edid_name(edid), "DEL a07b");
}

TEST(Edids, AreNotTrusted) {
  auto edid = edid_of_a_dell();
  edid[54 + 18 + 5] = 0x1b;  // an escape sequence aimed at whoever reads the log
  EXPECT_EQ(edid_name(edid), "DEL ?ELL U2412M");
  EXPECT_EQ(edid_name(std::span(edid).first(127)), "");
  EXPECT_EQ(edid_name({}), "");
  EXPECT_EQ(edid_name(std::vector<std::uint8_t>(128, 0xff)), "");
}

TEST(Edids, TellDisplaysApart) {
  auto edid = edid_of_a_dell();
  const std::uint64_t one = edid_identity(edid);
  EXPECT_EQ(edid_identity(edid), one);
  edid[12] = 1;  // the serial number
  EXPECT_NE(edid_identity(edid), one);
  EXPECT_EQ(edid_identity({}), 0u);
}

TEST(CardUsers, AreListedWithTheMasterFirst) {
  const fs::path root = test_output_folder() / "card-users";
  fs::remove_all(root);
  const auto process = [&](int pid, const std::string& command, const std::string& opened) {
    fs::create_directories(root / "proc" / std::to_string(pid) / "fd");
    std::ofstream(root / "proc" / std::to_string(pid) / "comm") << command << "\n";
    fs::create_symlink(opened, root / "proc" / std::to_string(pid) / "fd" / "7");
  };
  const fs::path card = root / "dev" / "card1";
  fs::create_directories(root / "dev");
  std::ofstream(card) << "";
  process(3000001, "plymouthd", card.string());
  process(3000002, "Xorg", card.string());
  process(3000003, "bash", "/dev/null");
  EXPECT_THAT(card_users(card, root / "proc", root / "debug"),
              AllOf(HasSubstr("plymouthd (pid 3000001) has it open"), HasSubstr("Xorg (pid 3000002) has it open"),
                    testing::Not(HasSubstr("bash"))));

  // The kernel's list (drivers/gpu/drm/drm_debugfs.c), with a command that contains a blank.
  fs::create_directories(root / "debug" / "dri" / "1");
  std::ofstream(root / "debug" / "dri" / "1" / "clients")
      << "             command  tgid dev master a   uid      magic\n"
      << "        X org server 3000002   1   y    y     0          0\n"
      << "           plymouthd 3000001   1   n    y     0          0\n";
  EXPECT_EQ(card_users(card, root / "proc", root / "debug"),
            "Xorg (pid 3000002) is master, plymouthd (pid 3000001) has it open");
  EXPECT_EQ(card_users(root / "dev" / "card2", root / "proc", root / "debug"), "");
}

}  // namespace
}  // namespace kasumi

// The picture of the screen on its way from the glass to an operator's browser: a kiosk on its recording, its reporter, and who
// presses the button.
#include <gmock/gmock.h>

#include "pipeline/kiosk/snapshot/blurred_picture.hpp"
#include "tests/pipeline/kiosk/appliance/kiosk_process.hpp"
#include "tests/report/running_reporter.hpp"

namespace kasumi::report {
namespace {

using testing::HasSubstr;

TEST(ScreenPicture, ReachesWhoPressesTheButtonAndIsCounted) {
  const auto folder = process_folder("screen-picture");
  const auto allow = [&](const char* snapshot) {
    EXPECT_TRUE(write_text_file(folder / "kasumi.toml", read_text_file(folder / "kasumi.toml").value() + snapshot));
  };
  allow("\n[snapshot]\nscreen_picture = true\n");
  const Process kiosk(folder, {"run", "--config", (folder / "kasumi.toml").string()});
  ASSERT_TRUE(eventually([&] {
    const auto status = status_in(folder);
    return status.is_object() && status["shown"] == "live";
  })) << kiosk.log();

  const int port = free_port();
  ASSERT_TRUE(write_text_file(
      folder / "report.toml",
      fmt::format("[kiosk]\nstatus = \"{0}/status.json\"\nstate = \"{0}\"\n[http]\nport = {1}\nscreen_picture = true\n",
                  folder.string(), port)));
  const Child reporter({report_program(), "run", "--config", folder / "report.toml"}, folder / "report.log");
  const auto ask = [&](const std::string& method, const std::string& path) {
    const auto fd = connected(port);
    if (!fd ||
        !sent(fd, fmt::format("{} {} HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\nConnection: close\r\n\r\n",
                              method, path)))
      return std::string();
    return heard_from(fd, 15000);
  };
  std::string action;
  ASSERT_TRUE(eventually([&] { return !(action = form_action(ask("GET", "/"))).empty(); })) << ask("GET", "/");
  EXPECT_EQ(status_in(folder)["screen_picture"]["taken"], 0);

  const auto answer = ask("POST", action);
  const auto picture = picture_in(answer);
  ASSERT_FALSE(picture.empty()) << answer << kiosk.log();
  EXPECT_EQ(picture.width(), kBlurredPixels);
  EXPECT_EQ(picture.height(), 18);
  // Sky above, land below: no blank.
  EXPECT_GT(std::ranges::max(picture.elements(), {}, &Rgb8::b).b,
            std::ranges::min(picture.elements(), {}, &Rgb8::b).b + 30);
  EXPECT_THAT(ask("POST", action), HasSubstr("possible in</strong>"));
  EXPECT_TRUE(eventually([&] { return status_in(folder)["screen_picture"]["taken"] == 1; }));
  EXPECT_TRUE(
      eventually([&] { return ask("GET", "/").find("Taken since the kiosk’s start: 1") != std::string::npos; }));
  EXPECT_THAT(kiosk.log(), HasSubstr("a blurred picture for the state page was sent"));
}

}  // namespace
}  // namespace kasumi::report

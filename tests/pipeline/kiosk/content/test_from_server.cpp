// Sent in the evening, gone in the morning: a wrong bundle from a curator's desk over a web server to the kiosk, and back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/utc_text.hpp"
#include "report/page/state_page.hpp"
#include "report/web/content_pull.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/content/kiosk_rig.hpp"
#include "tests/pipeline/run_kasumi.hpp"
#include "tests/report/web_server.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

// The kiosk with its reporter's helper, and the desk with its web server.
struct FarKiosk : KioskRig {
  explicit FarKiosk(const std::string& name) : KioskRig(name) {
    report::make_certificates(folder);
    make_keys(folder, "curator");
    server.emplace(folder);
    pull.emplace(report::PullOptions{server->url("hill.kasumi"), 15min, folder / "ca.pem", folder / "report"},
                 quarters);
  }
  void send(const std::string& name, const std::string& from, const std::string& to) {
    const auto made = write_desk(desk / name);
    replace_in(made, from, to);
    ended(0, run_kasumi(fmt::format("content pack {} --out {}/{}.kasumi --name {} --key {}/curator.key", made.string(),
                                    folder.string(), name, name, folder.string())));
    fs::rename(folder / (name + ".kasumi"), folder / "www/hill.kasumi");
  }
  // What the reporter does every quarter of an hour, and kasumi-content.service whenever something has come.
  Outcome look_for_content() {
    quarters.advance(15min);
    const auto before = pull->fetched() + pull->unchanged() + pull->failed();
    EXPECT_TRUE(report::within(30, [&] {
      pull->turn();
      return pull->fetched() + pull->unchanged() + pull->failed() > before;
    }));
    EXPECT_EQ(pull->status().problem, "");
    auto done = run_kasumi(
        fmt::format("content install --newer {0}/incoming {0}/report/content --content {0}/content --keys {0}/keys "
                    "--status {0}/no-status.json",
                    folder.string()));
    if (done.out.find(": installed") != std::string::npos) hang_up();  // as the command does where it finds the process
    return done;
  }
  std::string page() {
    const auto told = report::parse_status(status());
    return report::state_page({"hill", {report::Contact::heard, *told, {}, {}}, {}, clock.utc(), 0min, pull->status()},
                              Language::english);
  }
  ManualClock quarters{clock.utc()};  // the reporter's, so that its waits do not stop the kiosk
  std::optional<report::WebServer> server;
  std::optional<report::ContentPull> pull;
};

TEST(FromServer, Row22AWrongBundleOfTheEveningIsGoneInTheMorning) {
  if (!has_minisign() || !report::has_nginx()) GTEST_SKIP() << "minisign or nginx is not installed";
  FarKiosk kiosk("from-server");
  kiosk.start();
  kiosk.pass(20s);
  ASSERT_EQ(kiosk.shown(), Shown::live);

  // In the evening. Nobody at the desk could know that the kiosk has no such camera.
  kiosk.send("Wrong", "[scene.camera]\nsource = \"replay\"\n",
             "[scene.camera]\nsource = \"v4l2\"\ndevice = \"/dev/v4l/by-id/not-there\"\n#");
  auto done = ended(0, kiosk.look_for_content());
  EXPECT_THAT(done.out, HasSubstr("signed by curator: installed"));
  kiosk.pass(60s);
  EXPECT_EQ(kiosk.shown(), Shown::still);
  EXPECT_EQ(kiosk.content()["generation"]["name"], "Wrong");
  EXPECT_THAT(kiosk.content()["arrived"]["words"].get<std::string>(), HasSubstr("Wrong ("));
  EXPECT_THAT(kiosk.page(), AllOf(HasSubstr("Wrong ("), HasSubstr("signed by curator: installed")));

  // At night.
  kiosk.pass(31min, kStep);
  kiosk.pass(5s);
  EXPECT_EQ(kiosk.shown(), Shown::live) << "the old content, by itself";
  EXPECT_EQ(kiosk.content()["went_back"]["name"], "Wrong");

  // In the morning it still lies on the server, and is left alone.
  done = kiosk.look_for_content();
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(kiosk.pull->unchanged(), 1u);
  EXPECT_THAT(done.out, AllOf(HasSubstr("went back on"), HasSubstr("for 0 of 30 minutes")));
  kiosk.pass(30s);
  EXPECT_EQ(kiosk.shown(), Shown::live);
  EXPECT_THAT(kiosk.page(), HasSubstr("it was shown before and went back on"));

  // Corrected.
  kiosk.send("Right", "The view returns in a moment.", "Right");
  done = kiosk.look_for_content();
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(kiosk.pull->fetched(), 2u);
  kiosk.pass(11min, kStep);
  kiosk.pass(5s);
  EXPECT_EQ(kiosk.content()["generation"]["name"], "Right");
  EXPECT_TRUE(kiosk.content()["generation"]["proven_utc"].is_string()) << kiosk.content().dump(1);
  EXPECT_EQ(kiosk.shown(), Shown::live);
}

// One that somebody else has signed, or that was damaged on the way, changes nothing, and is told.
TEST(FromServer, WhatNobodyTrustedSignedChangesNothing) {
  if (!has_minisign() || !report::has_nginx()) GTEST_SKIP() << "minisign or nginx is not installed";
  FarKiosk kiosk("from-server-strange");
  kiosk.start();
  kiosk.pass(20s);
  make_keys(kiosk.folder / "elsewhere", "stranger");
  fs::rename(kiosk.folder / "elsewhere/stranger.key", kiosk.folder / "curator.key");
  kiosk.send("Strange", "The view returns in a moment.", "Strange");
  EXPECT_THAT(ended(2, kiosk.look_for_content()).err, HasSubstr("not trusted here"));
  EXPECT_TRUE(kiosk.generations.all().empty()) << "nothing is unpacked of it";
  kiosk.pass(10s);
  EXPECT_THAT(kiosk.content()["arrived"]["words"].get<std::string>(),
              AllOf(HasSubstr("refused: "), HasSubstr("not trusted here")));
  EXPECT_EQ(kiosk.content()["arrived"]["taken"], false);
  EXPECT_EQ(kiosk.shown(), Shown::live);
}

}  // namespace
}  // namespace kasumi

// `kasumi content` as people and scripts run it: signed on the desk, carried over, shown by a running kiosk.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/kiosk/content/arrival.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/appliance/kiosk_process.hpp"
#include "tests/pipeline/kiosk/content/desk.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

struct Carried : testing::Test {
  void SetUp() override {
    if (!has_minisign()) GTEST_SKIP() << "minisign is not installed";
    folder = content_folder("command");
    config = write_desk(folder / "desk");
    make_keys(folder, "curator");
  }
  std::string place() const {
    return fmt::format("--content {0}/content --keys {0}/keys --status {0}/run/status.json", folder.string());
  }
  Outcome pack(const std::string& name, const std::string& more) {
    return run_kasumi(fmt::format("content pack {0} --out {1}/{2}.kasumi --name {2} {3}", config.string(),
                                  folder.string(), name, more));
  }
  std::string key() const { return "--key " + (folder / "curator.key").string(); }
  Outcome install(const std::string& name, const std::string& more = {}) {
    return run_kasumi(fmt::format("content install {}/{}.kasumi {} {}", folder.string(), name, place(), more));
  }
  fs::path folder, config;
};

TEST_F(Carried, SignedOnTheDeskAndTakenByTheKiosk) {
  const auto made = ended(0, pack("Spring", key()));
  EXPECT_THAT(made.out, AllOf(HasSubstr("files"), testing::Not(HasSubstr("not signed"))));
  // By tar and minisign, which know nothing of Kasumi.
  EXPECT_EQ(shell(fmt::format("cd {0} && tar -xf Spring.kasumi manifest.json manifest.json.minisig && minisign -V -p "
                              "keys/curator.pub -m manifest.json",
                              folder.string())),
            0);
  const auto verified =
      ended(0, run_kasumi(fmt::format("content verify {0}/Spring.kasumi --keys {0}/keys", folder.string())));
  EXPECT_THAT(verified.out, HasSubstr("signed by curator (Spring, "));
  const auto done = ended(0, install("Spring"));
  EXPECT_THAT(done.out, AllOf(HasSubstr("signed by curator: installed"), HasSubstr("the next start shows it")));
  EXPECT_THAT(install("Spring").out, HasSubstr("it is shown already"));
  const auto listed = run_kasumi(fmt::format("content list --content {}/content", folder.string()));
  EXPECT_THAT(listed.out, AllOf(HasSubstr("* "), HasSubstr("by curator  Spring: on probation")));
  ended(0, run_kasumi(fmt::format("content verify --content {}/content", folder.string())));
}

TEST_F(Carried, MinisignMaySignLater) {
  ASSERT_EQ(pack("Late", "").code, 0);
  EXPECT_THAT(install("Late").err, HasSubstr("it is not signed"));
  ASSERT_EQ(shell(fmt::format("cd {0} && tar -xf Late.kasumi manifest.json && minisign -S -s curator.key -m "
                              "manifest.json && tar -rf Late.kasumi manifest.json.minisig",
                              folder.string())),
            0);
  ended(0, install("Late"));
}

TEST_F(Carried, WhatNobodyTrustedSignedStaysOutside) {
  make_keys(folder / "elsewhere", "stranger");
  ASSERT_EQ(pack("Strange", "--key " + (folder / "elsewhere/stranger.key").string()).code, 0);
  EXPECT_THAT(ended(2, install("Strange")).err, HasSubstr("not trusted here"));
  EXPECT_EQ(install("Strange", "--unsigned").code, 2) << "signed by somebody else is not unsigned";
  EXPECT_FALSE(fs::exists(folder / "content"));
  ASSERT_EQ(pack("Plain", "").code, 0);
  EXPECT_EQ(install("Plain", "--unsigned").code, 0) << "an operator on the spot may";
}

// As a stick, a server or a folder brings it: nobody reads what is printed.
TEST_F(Carried, WhatCameByItselfIsNoted) {
  const auto newest = [&](const std::string& folders) {
    return run_kasumi("content install --newer " + folders + " " + place());
  };
  const auto arrived = [&] { return last_arrival(folder / "content").value_or(Arrival{}); };
  const auto stick = folder / "stick", server = folder / "server";
  for (const auto& each : {stick, server}) fs::create_directories(each);
  const auto both = fmt::format("{} {} {}/not-there", stick.string(), server.string(), folder.string());
  EXPECT_EQ(newest(both).code, 0) << "nothing to do is no failure";
  EXPECT_EQ(arrived().words, "no bundle there: expected NAME.kasumi");
  ASSERT_EQ(pack("Spring", key()).code, 0);
  fs::rename(folder / "Spring.kasumi", stick / "Spring.kasumi");
  ASSERT_TRUE(write_text_file(server / "Rubbish.kasumi", "rubbish"));
  // A link may lead to where only we may read.
  fs::create_symlink("/etc/passwd", server / "Link.kasumi");
  auto done = ended(0, newest(both));
  EXPECT_TRUE(arrived().taken);
  EXPECT_THAT(arrived().words, AllOf(HasSubstr("signed by curator: installed; "), HasSubstr("Rubbish.kasumi: "),
                                     testing::Not(HasSubstr("Link.kasumi"))));
  EXPECT_THAT(arrived().from, HasSubstr(stick.string()));
  // What came of it is to be read until there is other news.
  fs::remove(server / "Rubbish.kasumi");
  const auto before = arrived();
  for (const auto& folders : {both, server.string()}) {
    done = newest(folders);
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_TRUE(arrived().taken) << folders;
    EXPECT_EQ(arrived().words, before.words) << folders;
    EXPECT_EQ(arrived().utc, before.utc) << folders;
  }
  ASSERT_TRUE(write_text_file(server / "Rubbish.kasumi", "rubbish"));
  EXPECT_EQ(newest(server.string()).code, 2);
  EXPECT_THAT(arrived().words, AllOf(HasSubstr("refused: "), HasSubstr("Rubbish.kasumi: ")));
  EXPECT_FALSE(arrived().taken);
  // Without --newer one bundle is named, and what came of it is printed alone.
  EXPECT_EQ(run_kasumi(fmt::format("content install {0} {0} {1}", stick.string(), place())).code, 2);
  EXPECT_THAT(arrived().words, HasSubstr("Rubbish.kasumi: "));
}

TEST_F(Carried, AMistakeIsNamedBeforeItLeavesTheDesk) {
  ASSERT_TRUE(write_text_file(config, read_text_file(config).value() + "\nnonsense = 1\n"));
  EXPECT_THAT(ended(2, pack("Bad", key())).err, HasSubstr("nonsense"));
  EXPECT_FALSE(fs::exists(folder / "Bad.kasumi"));
}

// A running kiosk takes it between two pictures; what it refuses goes back at once; a person may go back, too.
TEST_F(Carried, Row22ARunningKioskShowsItOnProbation) {
  ASSERT_EQ(pack("Spring", key()).code, 0);
  replace_in(config, "distortion = [-0.6,", "distortion = [-0.59,");
  ASSERT_EQ(pack("Summer", key()).code, 0);
  const auto by_hand = write_desk(folder / "etc");
  fs::create_directories(folder / "run");
  Process kiosk(folder / "run", {"run", "--config", by_hand.string(), "--content", (folder / "content").string()}, {},
                folder / "state");
  const auto content = [&] { return status_in(folder / "run")["content"]; };
  ASSERT_TRUE(eventually([&] { return status_in(folder / "run")["shown"] == "live"; })) << kiosk.log();
  EXPECT_TRUE(content()["generation"].is_null());
  auto done = ended(0, install("Spring"));
  EXPECT_THAT(done.out, HasSubstr("shown now, on probation"));
  EXPECT_TRUE(eventually([&] { return content()["generation"].is_object(); })) << kiosk.log();
  EXPECT_EQ(content()["generation"]["name"], "Spring");
  EXPECT_EQ(content()["generation"]["signed_by"], "curator");
  const pid_t pid = status_in(folder / "run")["pid"];
  EXPECT_EQ(nice_of(pid, "proving"), nice_of(pid, "kasumi")) << "a busy machine must not stop a probation";
  ASSERT_EQ(install("Summer").code, 0);
  EXPECT_TRUE(eventually([&] { return content()["generation"]["name"] == "Summer"; })) << kiosk.log();
  const auto back =
      run_kasumi(fmt::format("content rollback --config {1} --content {0}/content --status {0}/run/status.json",
                             folder.string(), by_hand.string()));
  EXPECT_EQ(back.code, 0) << back.err;
  EXPECT_TRUE(eventually([&] { return content()["generation"].is_null(); })) << kiosk.log();
  EXPECT_EQ(content()["went_back"]["why"], "by hand");
  const auto spring =
      run_kasumi(fmt::format("content list --content {}/content --config {}", folder.string(), by_hand.string())).out;
  EXPECT_THAT(spring, AllOf(HasSubstr("Summer: went back"), HasSubstr("* " + by_hand.string() + ": set up by hand")));
  const auto nothing =
      run_kasumi(fmt::format("content list --content {0}/content --config {0}/absent.toml", folder.string())).out;
  EXPECT_THAT(nothing, AllOf(HasSubstr("* nothing"), testing::Not(HasSubstr("absent.toml"))));
  kiosk.send(SIGTERM);
  EXPECT_EQ(kiosk.wait(20s), 0);
}

// Installed it is; what becomes of it on the screen nobody knows yet.
TEST_F(Carried, AKioskThatDoesNotAnswerInTimeIsNotSaidToHaveRefused) {
  ASSERT_EQ(pack("Spring", key()).code, 0);
  const auto by_hand = write_desk(folder / "etc");
  fs::create_directories(folder / "run");
  Process kiosk(folder / "run", {"run", "--config", by_hand.string(), "--content", (folder / "content").string()}, {},
                folder / "state");
  ASSERT_TRUE(eventually([&] { return status_in(folder / "run")["shown"] == "live"; })) << kiosk.log();
  kiosk.send(SIGSTOP);
  const auto slow = ended(1, install("Spring", "--seconds 0.5"));
  EXPECT_THAT(slow.out, HasSubstr("signed by curator: installed"));
  EXPECT_THAT(slow.err, AllOf(HasSubstr("not been shown within 0.5 s: the kiosk shows it once it is prepared"),
                              HasSubstr("status.json")));
  kiosk.send(SIGCONT);
  EXPECT_TRUE(eventually([&] { return status_in(folder / "run")["content"]["generation"].is_object(); }))
      << kiosk.log();
  EXPECT_FALSE(Generations(folder / "content").current()->went_back);
}

}  // namespace
}  // namespace kasumi

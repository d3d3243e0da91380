// The appliance as a process: threads, signals, exit codes, notifications to the service manager.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/outside/this_boot.hpp"
#include "pipeline/kiosk/start/kept_content.hpp"
#include "pipeline/kiosk/start/start_log.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/appliance/kiosk_process.hpp"
#include "tests/pipeline/run_kasumi.hpp"
#include "tests/pipeline/service_manager.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// Runs all threads: the main test for the thread sanitizer.
TEST(Process, RunsReloadsContentAndEndsWithinTwoSecondsOfSigterm) {
  const auto folder = process_folder("run");
  ServiceManager manager;
  Process kasumi(folder, {"run", "--config", (folder / "kasumi.toml").string(), "--stats"}, manager.path());
  ASSERT_TRUE(eventually([&] { return manager.heard().find("READY=1") != std::string::npos; })) << kasumi.log();
  ASSERT_TRUE(eventually([&] {
    const auto status = status_in(folder);
    return status.is_object() && status["shown"] == "live" && status["turbidity"].is_number();
  })) << kasumi.log();

  kasumi.send(SIGHUP);
  ASSERT_TRUE(eventually([&] { return status_in(folder)["content"]["reloaded_utc"].is_string(); })) << kasumi.log();
  EXPECT_TRUE(eventually([&] { return manager.heard().find("RELOADING=1") != std::string::npos; })) << manager.heard();
  auto text = read_text_file(folder / "kasumi.toml").value();
  ASSERT_TRUE(write_text_file(folder / "kasumi.toml", text + "\nnonsense = 1\n"));
  kasumi.send(SIGHUP);
  ASSERT_TRUE(eventually([&] { return !status_in(folder)["content"]["problems"].empty(); })) << kasumi.log();
  EXPECT_THAT(status_in(folder)["content"]["problems"].dump(), HasSubstr("nonsense"));
  EXPECT_EQ(status_in(folder)["shown"], "live");

  manager.heard();
  const auto requested = SteadyClock::now();
  kasumi.send(SIGTERM);
  const auto code = must(kasumi.wait(20s));
  const auto took = std::chrono::duration<double>(SteadyClock::now() - requested).count();
  EXPECT_EQ(*code, 0) << kasumi.log();
  std::printf("ended %.2f s after SIGTERM\n", took);
  // A step in progress then may exceed the deadline for stuck drivers and disks where everything is slower.
  EXPECT_LE(took, kSlowness == 1 ? 2.0 : 60.0);
  EXPECT_THAT(manager.heard(), HasSubstr("WATCHDOG=1"));
  EXPECT_THAT(manager.heard(), HasSubstr("STATUS=live"));
  EXPECT_THAT(manager.heard(), HasSubstr("STOPPING=1"));
  if (kSlowness > 1 && kasumi.log().find("exiting without it") != std::string::npos) {
    std::puts("too slow to end in order: only the hard end was seen");
    return;
  }
  EXPECT_THAT(kasumi.log(), HasSubstr("capture to flip"));
  EXPECT_TRUE(std::filesystem::exists(folder / "state" / "turbidity.json"));
}

// No measure of speed, which is for `kasumi bench`: a start takes a second. The limit is on a fault, a wait for something
// that the first picture does not need, as the unit's TimeoutStartSec= is. The quickest of three starts counts, since a
// busy machine is not equally busy three times; under a sanitizer none is in time.
TEST(Process, TheFirstPictureWaitsForNothing) {
  constexpr double kLongest_s = 8.0;
  const auto folder = process_folder("first");
  const auto config = folder / "kasumi.toml";
  replace_in(config, "[scene.camera]\nsource = \"replay\"\nfixture",
             "[scene.camera]\nsource = \"v4l2\"\ndevice = \"/dev/kasumi-no-such-camera\"\n#");
  double quickest_s = 1e9;
  for (int start = 0; start < 3 && quickest_s > kLongest_s; ++start) {
    ServiceManager manager;
    std::filesystem::remove(folder / "status.json");
    const auto began = SteadyClock::now();
    Process kasumi(folder, {"run", "--config", config.string()}, manager.path());
    ASSERT_TRUE(eventually([&] { return manager.heard().find("READY=1") != std::string::npos; })) << kasumi.log();
    const double ready_s = std::chrono::duration<double>(SteadyClock::now() - began).count();
    std::printf("first picture %.2f s after the start\n", ready_s);
    quickest_s = std::min(quickest_s, ready_s);
    ASSERT_TRUE(eventually([&] {
      const auto status = status_in(folder);
      return status.is_object() && status["display"]["up"] == true && status["shown"] == "still";
    })) << kasumi.log();
    if (kSlowness > 1) return;
  }
  EXPECT_LE(quickest_s, kLongest_s);
}

TEST(Process, SigintEndsItAsWell) {
  const auto folder = process_folder("int");
  Process kasumi(folder, {"run", "--config", (folder / "kasumi.toml").string()});
  ASSERT_TRUE(eventually([&] { return status_in(folder).is_object(); })) << kasumi.log();
  kasumi.send(SIGINT);
  EXPECT_EQ(kasumi.wait(20s), 0);
}

TEST(Process, ABadConfigurationIsExitCode78WithEveryProblem) {
  const auto folder = process_folder("78");
  auto text = read_text_file(folder / "kasumi.toml").value();
  const auto put = [&](const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  put("[scene.camera]\nsource = \"replay\"", "[scene.camera]\nsource = \"replayed\"");
  put("kind = \"headless\"", "kind = \"kms\"\nmode = \"1920 by 1080\"");
  put("still.png", "still-that-is-not-there.png");
  put("language = \"en\"", "language = \"klingon\"");
  put("latitude_deg", "latitude_degrees");
  ASSERT_TRUE(write_text_file(folder / "kasumi.toml", text));
  for (const bool check : {false, true}) {
    std::vector<std::string> arguments{"run", "--config", (folder / "kasumi.toml").string()};
    if (check) arguments.push_back("--check");
    Process kasumi(folder, arguments);
    EXPECT_EQ(kasumi.wait(20s), 78);
    for (const char* problem : {"replayed", "1920 by 1080", "still-that-is-not-there.png", "klingon", "latitude_deg"})
      EXPECT_THAT(kasumi.log(), HasSubstr(problem));
  }
}

TEST(Process, Row31ContentThatCannotBeDrawnIsRefusedByTheCheckAndByTheReload) {
  const auto folder = process_folder("reload");
  const auto config = folder / "kasumi.toml";
  const auto good = read_text_file(config).value();
  Process kasumi(folder, {"run", "--config", config.string()});
  ASSERT_TRUE(eventually([&] { return status_in(folder)["shown"] == "live"; })) << kasumi.log();
  const auto reload = [&] {
    const auto own = folder / "reload";
    std::filesystem::create_directories(own);
    Process command(
        own, {"reload", "--status", (folder / "status.json").string(), "--seconds", std::to_string(50 * kSlowness)});
    const auto code = command.wait(60s);
    return std::pair(code.value_or(-1), command.log());
  };
  EXPECT_THAT(reload(), testing::Pair(0, HasSubstr("reloaded")));

  replace_in(config, "distortion = [-0.6,", "distortion = [-300.0,");
  EXPECT_THAT(reload(), testing::Pair(1, HasSubstr("folds the picture")));
  EXPECT_THAT(status_in(folder)["content"]["problems"].dump(), HasSubstr("folds the picture"));
  EXPECT_EQ(status_in(folder)["shown"], "live");
  Process check(process_folder("reload-check"), {"run", "--config", config.string(), "--check"});
  EXPECT_EQ(check.wait(60s), 78);
  EXPECT_THAT(check.log(), HasSubstr("folds the picture"));

  ASSERT_TRUE(write_text_file(config, good));
  EXPECT_THAT(reload(), testing::Pair(0, HasSubstr("reloaded")));
  kasumi.send(SIGTERM);
  EXPECT_EQ(kasumi.wait(20s), 0);
  EXPECT_THAT(reload(), testing::Pair(1, HasSubstr("no appliance is running")));
}

// In the evening an edit is refused by a reload that nobody looks at, in the night the power is cut.
TEST(Process, Row32ARefusedConfigurationStartsWithWhatWorkedLastAndSaysSo) {
  const auto folder = process_folder("last-good"), state = folder / "state";
  const auto config = folder / "kasumi.toml";
  ASSERT_TRUE(keep_content(*read_content(config).value(), state / "last-good", Utc{}));
  const auto text = read_text_file(config).value();
  ASSERT_TRUE(write_text_file(config, text + "\nnonsense = 1\n"));
  Process kasumi(folder, {"run", "--config", config.string()}, {}, state);
  ASSERT_TRUE(eventually([&] {
    const auto status = status_in(folder);
    return status.is_object() && status["shown"] == "live" && status["building_drawn"] == true;
  })) << kasumi.log();
  EXPECT_THAT(status_in(folder)["content"]["refused"].dump(), HasSubstr("nonsense"));
  EXPECT_THAT(status_in(folder)["content"]["last_good_utc"].dump(), HasSubstr("1970-01-01"));
  EXPECT_THAT(kasumi.log(), HasSubstr("the configured content is not used, shown is what worked"));

  ASSERT_TRUE(write_text_file(config, text));
  kasumi.send(SIGHUP);
  EXPECT_TRUE(eventually([&] { return status_in(folder)["content"]["refused"].empty(); })) << kasumi.log();
  EXPECT_TRUE(status_in(folder)["content"]["last_good_utc"].is_null());
}

// Content that is accepted and then kills the program, start after start.
TEST(Process, Row32AfterFiveFailedStartsTheContentThatWorkedLastIsShown) {
  const auto folder = process_folder("suspect"), state = folder / "state";
  const auto config = folder / "kasumi.toml";
  ASSERT_TRUE(keep_content(*read_content(config).value(), state / "last-good", Utc{}));
  ASSERT_TRUE(write_text_file(config, read_text_file(config).value() + "\n# an edit\n"));
  for (int start = 0; start < kStartsBeforeKeptContent; ++start)
    StartLog({state, {}}, boot_id(), since_boot_s()).doing("drawing the new model");
  Process kasumi(folder, {"run", "--config", config.string()}, {}, state);
  ASSERT_TRUE(eventually([&] { return !status_in(folder)["content"]["refused"].empty(); })) << kasumi.log();
  EXPECT_THAT(status_in(folder)["content"]["refused"].dump(), HasSubstr("starts in a row have failed"));
}

TEST(Process, Row34AfterThreeFailedBootsItIsSafeModeUntilSomebodyRestartsIt) {
  const auto folder = process_folder("safe"), state = folder / "state";
  for (const char* boot : {"a", "b", "c"}) StartLog({state, {}}, boot, 15.0).doing("opening cameras and display");
  const std::vector<std::string> arguments{"run", "--config", (folder / "kasumi.toml").string()};
  {
    ServiceManager manager;
    Process kasumi(folder, arguments, manager.path(), state);
    ASSERT_TRUE(eventually([&] { return manager.heard().find("READY=1") != std::string::npos; })) << kasumi.log();
    ASSERT_TRUE(eventually([&] { return status_in(folder)["display"]["up"] == true; })) << kasumi.log();
    const auto status = status_in(folder);
    EXPECT_EQ(status["shown"], "still");
    EXPECT_EQ(status["start"]["safe_mode"], true);
    EXPECT_THAT(status["start"]["why"].dump(), HasSubstr("opening cameras and display"));
    EXPECT_EQ(status["scene_camera"]["opened"], 0);
    EXPECT_THAT(kasumi.log(), HasSubstr("safe mode"));
    EXPECT_THAT(kasumi.log(), HasSubstr("opening cameras and display"));
    EXPECT_THAT(manager.heard(), HasSubstr("STATUS=still: safe mode"));
    const auto snapshot =
        ended(0, run_kasumi(fmt::format("snapshot --folder {0} --out {0}/safe.png", folder.string())));
    EXPECT_THAT(snapshot.out, HasSubstr("shown: still: safe mode"));
    kasumi.send(SIGTERM);
    EXPECT_EQ(kasumi.wait(20s), 0);
  }
  std::filesystem::remove(folder / "status.json");
  Process trial(folder, arguments, {}, state);
  ASSERT_TRUE(eventually([&] { return status_in(folder).is_object() && status_in(folder)["shown"] == "live"; }))
      << trial.log();
  EXPECT_EQ(status_in(folder)["start"]["trial"], true);
}

TEST(Process, CheckReportsAValidConfiguration) {
  const auto folder = process_folder("check");
  Process kasumi(folder, {"run", "--config", (folder / "kasumi.toml").string(), "--check"});
  EXPECT_EQ(kasumi.wait(60s), 0) << kasumi.log();
}

TEST(Process, ASnapshotIsGivenToWhoAsksOnThisMachine) {
  const auto folder = process_folder("snapshot");
  const auto ask = [&](const std::string& options) {
    return run_kasumi(fmt::format("snapshot --folder {} {}", folder.string(), options));
  };
  const auto none = ended(1, ask(""));
  EXPECT_THAT(none.err, HasSubstr("no appliance runs here"));
  EXPECT_THAT(none.err, HasSubstr("systemctl start kasumi"));

  Process kasumi(folder, {"run", "--config", (folder / "kasumi.toml").string()});
  ASSERT_TRUE(eventually([&] {
    const auto status = status_in(folder);
    return status.is_object() && status["shown"] == "live";
  })) << kasumi.log();
  const auto file = (folder / "now.png").string();
  const auto blurred = ask("--out " + file);
  ASSERT_EQ(blurred.code, 0) << blurred.err << kasumi.log();
  EXPECT_THAT(blurred.out, HasSubstr("shown: live"));
  EXPECT_THAT(blurred.out, HasSubstr("blurred to 32 x"));
  EXPECT_EQ(read_file(file).value().at(1), 'P');
  const auto piped = ask("--out -");
  EXPECT_EQ(piped.out.substr(1, 3), "PNG") << "for ssh";
  EXPECT_THAT(piped.err, HasSubstr("shown: live"));
  EXPECT_THAT(ended(2, ask("--sharp --out " + (folder / "sharp.png").string())).err,
              HasSubstr("sharp = true under [snapshot]"));
  EXPECT_FALSE(std::filesystem::exists(folder / "sharp.png"));
  EXPECT_EQ(ask("--out /nowhere/at/all.png").code, 1);

  const auto text = read_text_file(folder / "kasumi.toml").value();
  ASSERT_TRUE(write_text_file(folder / "kasumi.toml", text + "\n[snapshot]\nsharp = true\n"));
  kasumi.send(SIGHUP);
  ASSERT_TRUE(eventually([&] { return status_in(folder)["content"]["reloaded_utc"].is_string(); })) << kasumi.log();
  ASSERT_TRUE(eventually([&] { return ask("--sharp --out " + (folder / "sharp.png").string()).code == 0; }))
      << kasumi.log();
  EXPECT_GT(std::filesystem::file_size(folder / "sharp.png"), 1000u);
  EXPECT_THAT(kasumi.log(), HasSubstr("a sharp picture was sent"));

  kasumi.send(SIGTERM);
  ASSERT_EQ(kasumi.wait(60s), 0) << kasumi.log();
  EXPECT_THAT(ask("").err, HasSubstr("no appliance runs here"));
}

}  // namespace
}  // namespace kasumi

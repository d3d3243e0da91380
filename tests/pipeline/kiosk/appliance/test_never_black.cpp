// What a start and a reload do with a disk that does not answer, and with content that nobody can show: a picture and words
// come all the same, and the rest when it can.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include <sys/stat.h>

#include "base/unique_fd.hpp"
#include "pipeline/kiosk/start/kept_content.hpp"
#include "tests/pipeline/kiosk/appliance/kiosk_process.hpp"
#include "tests/pipeline/run_kasumi.hpp"
#include "tests/pipeline/service_manager.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// A sanitizer stands before the same calls.
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
constexpr bool kHasOwnCalls = true;
#else
constexpr bool kHasOwnCalls = false;
#endif

struct NeverBlack : testing::Test {
  std::filesystem::path folder, config, state, rule;
  std::optional<ServiceManager> manager;

  void make(const std::string& name) {
    folder = process_folder("never-black-" + name);
    config = folder / "kasumi.toml";
    state = folder / "state";
    rule = folder / "rule";
    manager.emplace();
  }
  // As the service, on a disk with these rules.
  std::unique_ptr<Process> run(std::vector<std::pair<std::string, std::string>> variables = {}) {
    const auto library = kasumi_program().parent_path() / "libhung_disk.so";
    if (!kHasOwnCalls)
      variables.insert(variables.end(), {{"LD_PRELOAD", library.string()}, {"KASUMI_HUNG_DISK", rule.string()}});
    return std::make_unique<Process>(folder, std::vector<std::string>{"run", "--config", config.string()},
                                     manager->path(), state, variables);
  }
  bool is_ready() {
    return eventually([&] { return manager->heard().find("READY=1") != std::string::npos; });
  }
  bool shows(const std::string& shown) {
    return eventually([&] {
      const auto status = status_in(folder);
      return status.is_object() && status["shown"] == shown;
    });
  }
  void fold_the_lens() const { replace_in(config, "distortion = [-0.6,", "distortion = [-300.0,"); }
};

TEST_F(NeverBlack, Row40ADiskWhoseWritesHangHoldsNoPictureUp) {
  if (kHasOwnCalls) GTEST_SKIP() << "a sanitizer's calls are not replaced";
  make("writes");
  ASSERT_TRUE(write_text_file(rule, fmt::format("told /state {0}/written\nfsync /state\n", folder.string())));
  const auto kasumi = run();
  ASSERT_TRUE(is_ready()) << kasumi->log();
  EXPECT_EQ(read_text_file(folder / "written").value_or(""), "") << "before the first picture";
  EXPECT_TRUE(shows("live")) << kasumi->log();
  EXPECT_TRUE(eventually([&] { return status_in(folder)["loops"]["state"]["up"] == false; }))
      << "and the status says so";
  EXPECT_NE(read_text_file(folder / "written").value_or(""), "");
  std::filesystem::remove(rule);
  EXPECT_TRUE(eventually([&] { return status_in(folder)["loops"]["state"]["up"] == true; }));
  kasumi->send(SIGTERM);
  EXPECT_EQ(kasumi->wait(20s), 0) << kasumi->log();
  EXPECT_TRUE(std::filesystem::exists(state / "starts.json"));
  EXPECT_EQ(status_in(folder)["reason"], "stopped");
}

// The runtime folder is memory, and yet a machine that swaps may wait for a disk there. Once with content, and once
// with words alone.
TEST_F(NeverBlack, Row53ARuntimeFolderThatHangsHoldsNoPictureUp) {
  if (kHasOwnCalls) GTEST_SKIP() << "a sanitizer's calls are not replaced";
  for (const std::string shown : {"live", "still"}) {
    SCOPED_TRACE(shown);
    make("runtime");
    std::string rules;
    for (const char* file : {".status.", "starts.", ".starts.", "clock.", ".clock.", "snapshot.sock"})
      rules += fmt::format("open {}/{}\n", folder.string(), file);
    ASSERT_TRUE(write_text_file(rule, rules));
    if (shown == "still") {
      ASSERT_TRUE(write_text_file(config, read_text_file(config).value() + "\n[nonsense]\na = 1\n"));
    }
    const auto kasumi = run();
    ASSERT_TRUE(is_ready()) << kasumi->log();
    EXPECT_TRUE(eventually([&] { return manager->heard().find("STATUS=" + shown) != std::string::npos; }))
        << kasumi->log();
    EXPECT_FALSE(std::filesystem::exists(folder / "status.json"));
    EXPECT_THAT(kasumi->log(), HasSubstr("the folder of status.json does not answer"));
    std::filesystem::remove(rule);
    EXPECT_TRUE(shows(shown)) << kasumi->log();
    EXPECT_TRUE(eventually([&] { return std::filesystem::exists(folder / "snapshot.sock"); }));
    kasumi->send(SIGTERM);
    EXPECT_EQ(kasumi->wait(20s), 0) << kasumi->log();
  }
}

// The driver reads its compiled shaders in the thread that shows pictures.
TEST_F(NeverBlack, Row54AShaderCacheWhoseDiskHangsHoldsNoPictureUp) {
  if (kHasOwnCalls) GTEST_SKIP() << "a sanitizer's calls are not replaced";
  make("shaders");
  ASSERT_TRUE(write_text_file(rule, fmt::format("open {}/shaders\n", folder.string())));
  const auto kasumi = run({{"MESA_SHADER_CACHE_DIR", (folder / "shaders").string()}});
  ASSERT_TRUE(is_ready()) << kasumi->log();
  EXPECT_TRUE(shows("live")) << kasumi->log();
  EXPECT_THAT(kasumi->log(), HasSubstr("shaders: does not answer: shaders are compiled anew"));
  kasumi->send(SIGTERM);
  EXPECT_EQ(kasumi->wait(20s), 0) << "with a thread left behind: " << kasumi->log();
}

// The kernel's answer to writing beyond a limit is a signal that ends a program.
TEST_F(NeverBlack, Row21ALimitOfTheSizeOfFilesIsNoEnd) {
  if (kHasOwnCalls) GTEST_SKIP() << "the thread sanitizer's memory is a file, which it must be able to make";
  make("file-size");
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &none), 0);
  const auto kasumi = run();
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_TRUE(is_ready());
  EXPECT_TRUE(eventually([&] { return manager->heard().find("STATUS=live") != std::string::npos; }));
  kasumi->send(SIGTERM);
  EXPECT_EQ(kasumi->wait(20s), 0);
}

// A machine at its limit of threads: words come in the program's own letters, and content at the next request.
TEST_F(NeverBlack, Row55AMachineWithoutAThreadLeftKeepsItsPicture) {
  if (kHasOwnCalls) GTEST_SKIP() << "a sanitizer's calls are not replaced";
  make("threads");
  ASSERT_TRUE(write_text_file(config, read_text_file(config).value() + "[snapshot]\nsharp = true\n"));
  const auto kasumi = run();
  ASSERT_TRUE(shows("live")) << kasumi->log();
  ASSERT_TRUE(write_text_file(rule, "no thread\n"));
  kasumi->send(SIGHUP);
  EXPECT_TRUE(eventually([&] { return status_in(folder)["content"]["problems"].size() > 0; })) << kasumi->log();
  EXPECT_THAT(status_in(folder)["content"]["problems"].dump(), HasSubstr("it cannot be read now"));
  const auto sharp = run_kasumi(fmt::format("snapshot --sharp --folder {0} --out {0}/now.png", folder.string()));
  EXPECT_EQ(sharp.code, 0) << "which is announced in words on the glass: " << sharp.err << kasumi->log();
  EXPECT_EQ(status_in(folder)["display"]["resets"], 0) << kasumi->log();
  EXPECT_EQ(status_in(folder)["shown"], "live");
  std::filesystem::remove(rule);
  kasumi->send(SIGHUP);
  EXPECT_TRUE(eventually([&] { return status_in(folder)["content"]["problems"].empty(); })) << kasumi->log();
  kasumi->send(SIGTERM);
  EXPECT_EQ(kasumi->wait(20s), 0) << kasumi->log();
  EXPECT_THAT(kasumi->log(), testing::Not(HasSubstr("exiting without"))) << "no thread was left behind";
}

// Words are drawn by the thread that shows pictures: it goes on in the program's own letters.
TEST_F(NeverBlack, Row50FontsWhoseDiskHangsHoldNoPictureUp) {
  if (kHasOwnCalls) GTEST_SKIP() << "a sanitizer's calls are not replaced";
  make("letters");
  ASSERT_TRUE(write_text_file(rule, "open fonts\n"));
  const auto kasumi = run();
  ASSERT_TRUE(is_ready()) << kasumi->log();
  EXPECT_TRUE(shows("live")) << kasumi->log();
  EXPECT_THAT(kasumi->log(), HasSubstr("drawn in plain letters: the fonts' disk does not answer"));
  kasumi->send(SIGTERM);
  EXPECT_EQ(kasumi->wait(30s), 0) << "with a thread left behind: " << kasumi->log();
}

// A journal that hangs reads nothing more; one that has ended is a broken pipe.
TEST_F(NeverBlack, Row51AJournalThatReadsNothingHoldsNoPictureUp) {
  make("journal");
  const auto log = folder / "log.txt";
  ASSERT_EQ(::mkfifo(log.c_str(), 0600), 0);
  UniqueFd journal(::open(log.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  ASSERT_TRUE(journal);
  const std::string page(4096, 'x');
  while (::write(journal.value(), page.data(), page.size()) > 0) {
  }
  const auto kasumi = run();
  EXPECT_TRUE(is_ready());
  EXPECT_TRUE(shows("live"));
  journal = UniqueFd();
  ASSERT_TRUE(write_text_file(config, read_text_file(config).value() + "\n[nonsense]\na = 1\n"));
  kasumi->send(SIGHUP);
  EXPECT_TRUE(eventually([&] { return status_in(folder)["content"]["problems"].size() > 0; }));
  EXPECT_EQ(status_in(folder)["shown"], "live");
  kasumi->send(SIGTERM);
  EXPECT_EQ(kasumi->wait(20s), 0);
  std::filesystem::remove(log);
}

// A program that asks again and again, while content takes a while to be read: it is read once at a time.
TEST_F(NeverBlack, Row36AStormOfReloadsReadsOneAtATime) {
  if (kHasOwnCalls) GTEST_SKIP() << "a sanitizer's calls are not replaced";
  make("storm");
  const auto kasumi = run();
  ASSERT_TRUE(shows("live")) << kasumi->log();
  std::size_t most = 0;
  const auto threads = [&] {
    std::error_code error;
    const std::filesystem::directory_iterator tasks(fmt::format("/proc/{}/task", kasumi->id()), error);
    return static_cast<std::size_t>(std::distance(begin(tasks), end(tasks)));
  };
  const auto before = threads();
  ASSERT_TRUE(write_text_file(rule, fmt::format("open {}/still.png\n", folder.string())));
  for (int i = 0; i < 300; ++i) {
    kasumi->send(SIGHUP);
    std::this_thread::sleep_for(10ms);
    most = std::max(most, threads());
  }
  std::filesystem::remove(rule);
  EXPECT_LE(most, before + 4) << "the content's, the model's and the stage's";
  EXPECT_TRUE(eventually([&] { return status_in(folder)["content"]["reloaded_utc"].is_string(); })) << kasumi->log();
  EXPECT_EQ(status_in(folder)["shown"], "live");
}

// Of the first one nobody hears again; the second is whole.
TEST_F(NeverBlack, Row40AReloadThatHangsIsAbandonedForTheNext) {
  if (kHasOwnCalls) GTEST_SKIP() << "a sanitizer's calls are not replaced";
  make("reload");
  const auto kasumi = run();
  ASSERT_TRUE(shows("live")) << kasumi->log();
  const auto still = folder / "another.png";
  std::filesystem::copy_file(folder / "still.png", still);
  const auto good = read_text_file(config).value();
  replace_in(config, "still.png", "another.png");
  ASSERT_TRUE(write_text_file(rule, "open another.png\n"));
  kasumi->send(SIGHUP);
  ASSERT_TRUE(eventually([&] { return status_in(folder)["content"]["reloading"] == "reading"; })) << kasumi->log();
  ASSERT_TRUE(write_text_file(config, good));
  kasumi->send(SIGHUP);
  EXPECT_TRUE(eventually([&] { return status_in(folder)["content"]["reloaded_utc"].is_string(); })) << kasumi->log();
  EXPECT_EQ(status_in(folder)["content"]["problems"].size(), 0U);
  EXPECT_EQ(status_in(folder)["shown"], "live");

  // A pipe is no file at all.
  ASSERT_EQ(::mkfifo((folder / "pipe.png").c_str(), 0600), 0);
  replace_in(config, "still.png", "pipe.png");
  kasumi->send(SIGHUP);
  EXPECT_TRUE(eventually([&] { return status_in(folder)["content"]["problems"].size() > 0; })) << kasumi->log();
  kasumi->send(SIGTERM);
  EXPECT_EQ(kasumi->wait(20s), 0) << "with a thread left behind: " << kasumi->log();
}

// Whatever a disk or a driver does to one thread: systemd does not have to kill it.
TEST_F(NeverBlack, AThreadThatHangsDoesNotKeepItFromEnding) {
  if (kHasOwnCalls) GTEST_SKIP() << "a sanitizer's calls are not replaced";
  make("hangs");
  ASSERT_TRUE(write_text_file(config, read_text_file(config).value() + kAWood));
  ASSERT_TRUE(write_text_file(state / "landmarks.json", "{}"));
  ASSERT_TRUE(write_text_file(rule, "open landmarks.json\n"));
  const auto kasumi = run();
  ASSERT_TRUE(shows("live")) << kasumi->log();
  std::this_thread::sleep_for(1s);
  kasumi->send(SIGTERM);
  EXPECT_EQ(kasumi->wait(30s), 0) << kasumi->log();
  EXPECT_THAT(kasumi->log(), HasSubstr("exiting without it"));
}

TEST_F(NeverBlack, Row41ContentThatOnlyTheGpuRefusesIsReplacedWithinOneStart) {
  make("gpu");
  ASSERT_TRUE(keep_content(*read_content(config).value(), state / "last-good", Utc{}));
  fold_the_lens();
  const auto kasumi = run();
  EXPECT_TRUE(is_ready()) << kasumi->log();
  EXPECT_TRUE(shows("live")) << kasumi->log();
  EXPECT_THAT(status_in(folder)["content"]["refused"].dump(), HasSubstr("folds the picture"));
  EXPECT_EQ(manager->heard().find("STOPPING=1"), std::string::npos);
}

TEST_F(NeverBlack, Row41WhereNoContentIsLeftTheStillAndWordsAreShownUntilThereIsSome) {
  make("nothing");
  const auto good = read_text_file(config).value();
  ASSERT_TRUE(keep_content(*read_content(config).value(), state / "last-good", Utc{}));
  for (const auto& entry : std::filesystem::recursive_directory_iterator(state / "last-good"))
    if (entry.path().filename() == "temple.glb") {
      ASSERT_TRUE(write_text_file(entry.path(), "damaged"));
    }
  ASSERT_TRUE(write_text_file(config, good + "\n[nonsense]\na = 1\n"));
  const auto kasumi = run();
  ASSERT_TRUE(is_ready()) << kasumi->log();
  ASSERT_TRUE(shows("still")) << kasumi->log();
  EXPECT_THAT(status_in(folder)["reason"].dump(), HasSubstr("the content is refused"));
  EXPECT_THAT(status_in(folder)["content"]["refused"].dump(), HasSubstr("nonsense"));
  ASSERT_TRUE(write_text_file(config, good));
  kasumi->send(SIGHUP);
  EXPECT_TRUE(shows("live")) << kasumi->log();
  kasumi->send(SIGTERM);
  EXPECT_EQ(kasumi->wait(20s), 0) << kasumi->log();
}

// Each file that a start reads, on a disk that fails or does not answer, and as a power cut leaves it. Without earlier
// content to go back to, what is of the content makes the still and words; what was only remembered is done without.
TEST_F(NeverBlack, Row40EveryFileOfAStartMayFailHangOrBeEmpty) {
  if (kHasOwnCalls) GTEST_SKIP() << "a sanitizer's calls are not replaced";
  for (const auto& [input, shown] : std::map<std::string, std::string>{
           {"/temple.glb", "still"}, {"/scene-mask.png", "still"}, {"/still.png", "still"}, {"/state/", "live"}})
    for (const std::string way : {"fail", "open", "empty"}) {
      SCOPED_TRACE(input + ", " + way);
      make("inputs");
      if (input == "/state/") {  // as an earlier start left them
        for (const char* name : {"turbidity.json", "landmarks.json", "ground.bin", "layer.bin", "starts.json"}) {
          ASSERT_TRUE(write_text_file(state / name, way == "empty" ? "" : "{}"));
        }
      } else if (way == "empty") {
        ASSERT_TRUE(write_text_file(folder / input.substr(1), ""));
      }
      if (way != "empty") {
        ASSERT_TRUE(write_text_file(rule, fmt::format("{} {}{}\n", way, folder.string(), input)));
      }
      const auto kasumi = run();
      EXPECT_TRUE(is_ready()) << kasumi->log();
      EXPECT_TRUE(shows(shown)) << kasumi->log();
      EXPECT_TRUE(kasumi->runs());
      kasumi->send(SIGTERM);
      EXPECT_EQ(kasumi->wait(20s), 0) << kasumi->log();
    }
}

// The configuration itself, however it was left.
TEST_F(NeverBlack, Row41EveryStateOfTheConfigurationShowsAPicture) {
  for (const char* way : {"absent", "empty", "unreadable", "pipe", "deep"}) {
    SCOPED_TRACE(way);
    make("configuration");
    std::filesystem::remove(config);
    if (way == std::string("empty")) {
      ASSERT_TRUE(write_text_file(config, ""));
    }
    if (way == std::string("unreadable")) make_unreadable(config);
    if (way == std::string("pipe")) {
      ASSERT_EQ(::mkfifo(config.c_str(), 0600), 0);
    }
    if (way == std::string("deep")) {
      std::string deep = "a";
      for (int i = 0; i < 26'200; ++i) deep += ".a";
      ASSERT_TRUE(write_text_file(config, deep + " = 1\n"));
    }
    const auto kasumi = run();
    EXPECT_TRUE(shows("still")) << kasumi->log();  // on whatever screen is found: here there is none
    EXPECT_TRUE(kasumi->runs());
    kasumi->send(SIGTERM);
    EXPECT_EQ(kasumi->wait(20s), 0) << kasumi->log();
  }
}

}  // namespace
}  // namespace kasumi

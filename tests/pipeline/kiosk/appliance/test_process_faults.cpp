// What the process outlives: files that the disk cannot read, threads without memory.
#include <gmock/gmock.h>

#include "pipeline/kiosk/start/remembered_state.hpp"
#include "tests/pipeline/kiosk/appliance/kiosk_process.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

std::vector<std::string> run_arguments(const std::filesystem::path& folder) {
  return {"run", "--config", (folder / "kasumi.toml").string()};
}

bool is_live(const std::filesystem::path& folder) {
  const auto status = status_in(folder);
  return status.is_object() && status["shown"] == "live" && status["turbidity"].is_number();
}

TEST(Process, Row37StateThatTheDiskCannotReadBeginsAnew) {
  const auto folder = process_folder("unreadable-state");
  make_unreadable(folder / "state" / "turbidity.json");
  make_unreadable(folder / "state" / "landmarks.json");
  const auto text = read_text_file(folder / "kasumi.toml").value();
  ASSERT_TRUE(write_text_file(folder / "kasumi.toml", text + kAWood));
  Process kasumi(folder, run_arguments(folder));
  ASSERT_TRUE(eventually([&] { return is_live(folder) || !kasumi.runs(); })) << kasumi.log();
  ASSERT_TRUE(kasumi.runs()) << kasumi.log();
  // Each is read by a thread of its own, which may be later than the picture.
  for (const std::string file : {"turbidity.json", "landmarks.json"}) {
    const auto said = file + ": cannot be read: Input/output error";
    EXPECT_TRUE(eventually([&] { return kasumi.log().find(said) != std::string::npos; })) << said << kasumi.log();
  }
  kasumi.send(SIGTERM);
  EXPECT_EQ(kasumi.wait(60s), 0) << kasumi.log();
  EXPECT_TRUE(load_turbidity_state(folder / "state"))
      << kasumi.log() << read_text_file(folder / "status.json").value_or("");
}

TEST(Process, Row37ContentThatTheDiskCannotReadIsKeptOutOnReloadAndTriedAgainAtTheStart) {
  const auto folder = process_folder("unreadable-content");
  const auto model = std::filesystem::path(folder / "temple.glb");
  ASSERT_TRUE(std::filesystem::exists(model));
  {
    Process kasumi(folder, run_arguments(folder));
    ASSERT_TRUE(eventually([&] { return is_live(folder) || !kasumi.runs(); })) << kasumi.log();
    make_unreadable(model);
    kasumi.send(SIGHUP);
    ASSERT_TRUE(eventually([&] {
      const auto status = status_in(folder);
      return !kasumi.runs() || (status.is_object() && !status["content"]["problems"].empty());
    })) << kasumi.log();
    ASSERT_TRUE(kasumi.runs()) << kasumi.log();
    EXPECT_THAT(status_in(folder)["content"]["problems"].dump(), HasSubstr("temple.glb: cannot be read: Input/output"));
    EXPECT_EQ(status_in(folder)["shown"], "live");
    kasumi.send(SIGTERM);
    EXPECT_EQ(kasumi.wait(60s), 0) << kasumi.log();
  }
  // 1, not 78: the service manager tries again.
  for (const auto& file : {model, folder / "kasumi.toml"}) {
    make_unreadable(file);
    Process kasumi(folder, run_arguments(folder));
    EXPECT_EQ(kasumi.wait(60s), 1) << kasumi.log();
    EXPECT_THAT(kasumi.log(), HasSubstr(file.string() + ": cannot be read: Input/output error"));
  }
}

// A sanitizer's allocator is not replaced.
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
constexpr bool kHasOwnAllocator = true;
#else
constexpr bool kHasOwnAllocator = false;
#endif

TEST(Process, Row37AThreadWithoutMemoryEndsOnlyWhatIsNotThePicture) {
  if (kHasOwnAllocator) GTEST_SKIP() << "a sanitizer's allocator is not replaced";
  const auto folder = process_folder("no-memory");
  const auto rule = folder / "no-memory";
  const auto library = kasumi_program().parent_path() / "libno_memory.so";
  ASSERT_TRUE(std::filesystem::exists(library));
  Process kasumi(folder, run_arguments(folder), {}, {},
                 {{"LD_PRELOAD", library.string()}, {"KASUMI_NO_MEMORY", rule.string()}});
  ASSERT_TRUE(eventually([&] { return is_live(folder) || !kasumi.runs(); })) << kasumi.log();

  struct Loop {
    const char* rule;
    const char* name;
  };
  for (const auto& [bytes, name] : {Loop{"status 2000 1", "status"},
                                    {"sky 20000 3", "sky camera's loop"},
                                    {"scene 50000 2", "scene camera's loop"}}) {
    SCOPED_TRACE(name);
    ASSERT_TRUE(write_text_file(rule, bytes));
    ASSERT_TRUE(eventually([&] {
      return !kasumi.runs() || kasumi.log().find(std::string(name) + ": failed, trying again") != std::string::npos;
    })) << kasumi.log();
    std::filesystem::remove(rule);
    ASSERT_TRUE(eventually([&] {
      return !kasumi.runs() ||
             (is_live(folder) && kasumi.log().find(std::string(name) + ": works again") != std::string::npos);
    })) << kasumi.log();
    ASSERT_TRUE(kasumi.runs()) << kasumi.log();
  }

  ASSERT_TRUE(write_text_file(rule, "reload 100000 1"));
  kasumi.send(SIGHUP);
  ASSERT_TRUE(eventually([&] {
    const auto status = status_in(folder);
    return !kasumi.runs() || (status.is_object() && !status["content"]["problems"].empty());
  })) << kasumi.log();
  ASSERT_TRUE(kasumi.runs()) << kasumi.log();
  EXPECT_TRUE(eventually([&] { return is_live(folder); })) << kasumi.log();
  std::printf("%s\n", status_in(folder)["content"]["problems"].dump().c_str());
  kasumi.send(SIGTERM);
  EXPECT_EQ(kasumi.wait(60s), 0) << kasumi.log();
}

}  // namespace
}  // namespace kasumi

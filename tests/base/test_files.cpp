#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <memory>
#include <new>
#include <set>
#include <thread>

#include <sys/stat.h>
#include <unistd.h>

#include "base/files.hpp"
#include "base/lasting_file.hpp"
#include "base/outside/abandonable.hpp"
#include "base/outside/json_depth.hpp"
#include "base/unfinished_file.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

std::filesystem::path folder() {
  const auto path = test_output_folder() / "files";
  std::filesystem::create_directories(path);
  return path;
}

TEST(Files, WhatIsWrittenIsReadBack) {
  const auto path = folder() / "a.txt";
  ASSERT_TRUE(write_text_file(path, "old"));
  ASSERT_TRUE(write_text_file(path, "new"));
  EXPECT_EQ(read_text_file(path).value(), "new");
}

TEST(Files, AFailedWriteLeavesTheOldFileAndNothingElse) {
  const auto path = folder() / "kept" / "b.txt";
  std::filesystem::remove_all(path.parent_path());
  std::filesystem::create_directories(path.parent_path());
  ASSERT_TRUE(write_text_file(path, "old"));
  const auto result = replace_file(path, [](const std::filesystem::path& temporary) -> Result<> {
    (void)write_text_file(temporary, "half");
    return fail(FaultKind::io, "disk full");
  });
  EXPECT_FALSE(result);
  EXPECT_EQ(read_text_file(path).value(), "old");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path.parent_path()), {}), 1);
}

TEST(Files, AMissingFileIsNamed) {
  const auto result = read_file("/nowhere/at-all");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, FaultKind::bad_input);
  EXPECT_NE(result.error().message.find("/nowhere/at-all"), std::string::npos);
}

TEST(Files, AFolderIsNotAFile) {
  EXPECT_EQ(read_file("/tmp").error().message, "/tmp: is a folder, expected a file");
}

// A process's own memory at address 0 opens and cannot be read, like a bad sector.
TEST(Files, WhatTheDiskCannotReadIsAFaultAndNoException) {
  const auto result = read_text_file("/proc/self/mem");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, FaultKind::io);
  EXPECT_EQ(result.error().message, "/proc/self/mem: cannot be read: Input/output error");
}

TEST(Files, AFileTooLargeForMemoryIsRefusedUnread) {
  const auto path = folder() / "large";
  ASSERT_TRUE(write_text_file(path, ""));
  std::filesystem::resize_file(path, std::uintmax_t{1} << 40);  // without a block on the disk
  EXPECT_EQ(read_file(path).error().message, path.string() + ": larger than 1073741824 bytes, the most expected");
  std::filesystem::remove(path);  // a copy of the folder might write the hole out
}

TEST(Files, WhatDoesNotTellItsSizeIsReadToTheEnd) {
  EXPECT_NE(read_text_file("/proc/self/maps").value().find("[stack]"), std::string::npos);
}

// Root writes into folders of accounts, who may put links there.
TEST(Files, Row44ALinkThatWasPutInTheWayIsNotFollowed) {
  const auto path = folder() / "planted";
  std::filesystem::remove_all(path);
  ASSERT_TRUE(create_folders(path));
  const auto target = path / "target";
  ASSERT_TRUE(write_text_file(target, "theirs"));
  std::filesystem::create_symlink(target, path / "state.json");
  std::set<std::string> names;
  for (int i = 0; i < 50; ++i) names.insert(unfinished_name(path / "state.json").filename());
  EXPECT_EQ(names.size(), 50U) << "nobody can know the name beforehand";
  ASSERT_TRUE(write_text_file(path / "state.json", "ours"));
  EXPECT_EQ(read_text_file(target).value(), "theirs");
  EXPECT_FALSE(std::filesystem::is_symlink(path / "state.json"));
}

// Whoever opens a pipe waits for its writer, and a device may never end.
TEST(Files, Row40WhatIsNoFileIsRefusedAtOnce) {
  const auto pipe = folder() / "pipe";
  std::filesystem::remove(pipe);
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(read_file(pipe).error().message, pipe.string() + ": is a pipe, expected a file");
  EXPECT_EQ(read_file("/dev/zero").error().message, "/dev/zero: is a device, expected a file");
  EXPECT_EQ(read_file("/dev/zero").error().kind, FaultKind::bad_input);
}

TEST(Files, WhatAPersonNamesMayBeAPipe) {
  const auto pipe = folder() / "named-pipe";
  std::filesystem::remove(pipe);
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(pipe) << "a list"; });
  EXPECT_EQ(read_text_file(pipe, {.or_pipe = true}).value(), "a list");
  writer.join();
}

TEST(Files, Row40WhatIsLargerThanItMayBeIsRefused) {
  const auto path = folder() / "eleven";
  ASSERT_TRUE(write_text_file(path, "eleven byte"));
  EXPECT_TRUE(read_file(path, {.most_bytes = 11}));
  EXPECT_FALSE(read_file(path, {.most_bytes = 10}));
}

TEST(Abandonable, WorkThatNeverEndsIsLeftBehind) {
  const auto go_on = std::make_shared<std::atomic<bool>>(false);
  Abandonable<int> work([go_on] {
    while (!*go_on) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return 7;
  });
  EXPECT_FALSE(work.take(std::chrono::milliseconds(20)));
  EXPECT_EQ(abandoned_threads, 1);
  *go_on = true;
  EXPECT_EQ(work.take(std::chrono::seconds(20)), 7);
  EXPECT_EQ(abandoned_threads, 0);
  EXPECT_THROW(within<int>(std::chrono::seconds(20), []() -> int { throw std::bad_alloc(); }), std::bad_alloc);
}

TEST(JsonDepth, Row40IsKnownBeforeItIsParsed) {
  EXPECT_EQ(json_depth(R"({"a": [1, {"b": "[[[[\"["}]})"), 3);
  EXPECT_GE(json_values(R"({"a": [1, {"b": "[,,,[\"["}]})"), 4u);
  EXPECT_LE(json_values(R"({"a": [1, {"b": "[,,,[\"["}]})"), 6u);
  EXPECT_EQ(modest_json("[[1]]", 5, 2), "[[1]]");
  EXPECT_EQ(modest_json("[[1]]", 4, 2), "") << "too large";
  EXPECT_EQ(modest_json("[[1]]", 5, 1), "") << "too deep";
  EXPECT_EQ(modest_json(std::string(1'000'000, '[')), "");
}

TEST(Files, WhatAKilledProcessLeftIsSweptByTheFirstWhoWritesThere) {
  const auto path = folder() / "swept";
  std::filesystem::remove_all(path);
  ASSERT_TRUE(create_folders(path));
  const auto own = std::to_string(::getpid());  // of an earlier boot, in which it meant another process
  for (const auto& name :
       {std::string(".a.999999999.part.json"), std::string(".b.c.999999999.part"), "." + own + "." + own + ".part.mp4"})
    std::ofstream(path / name) << "half";
  const std::set<std::string> others{".a.1.part.json",  "a.999999999.part.json", ".a.part.json",
                                     ".a.9x.part.json", ".a.999999999.partial",  ".999999999.part"};
  for (const auto& name : others) std::ofstream(path / name) << "whole";
  std::filesystem::create_directory(path / ".folder.999999999.part");
  const auto names = [&] {
    std::set<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(path)) found.insert(entry.path().filename());
    return found;
  };
  auto expected = others;
  expected.insert({".folder.999999999.part", "file"});
  ASSERT_TRUE(write_text_file(path / "file", "text"));
  EXPECT_EQ(names(), expected);

  const auto under_way = unfinished_name(path / "film.mp4");
  std::ofstream(under_way) << "half";
  expected.insert(under_way.filename());
  ASSERT_TRUE(write_text_file(path / "file", "other text"));
  EXPECT_EQ(names(), expected) << "what this process is writing stays";
}

TEST(Files, ATextThatIsThereAlreadyIsNotWrittenAgain) {
  const auto path = folder() / "same.txt";
  std::filesystem::remove(path);
  EXPECT_TRUE(update_text_file(path, "text").value());
  const auto written = std::filesystem::last_write_time(path);
  EXPECT_FALSE(update_text_file(path, "text").value());
  EXPECT_EQ(std::filesystem::last_write_time(path), written);
  for (const char* other : {"texts", "tex", "", "test"}) EXPECT_TRUE(update_text_file(path, other).value()) << other;
  EXPECT_EQ(read_text_file(path).value(), "test");
}

}  // namespace
}  // namespace kasumi

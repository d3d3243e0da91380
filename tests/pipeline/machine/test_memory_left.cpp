#include "pipeline/machine/memory_left.hpp"

#include <gtest/gtest.h>

#include "base/files.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

class MemoryLeft : public testing::Test {
 protected:
  void write(const std::filesystem::path& file, const std::string& text) const {
    std::filesystem::create_directories(file.parent_path());
    ASSERT_TRUE(write_text_file(file, text));
  }
  void SetUp() override {
    std::filesystem::remove_all(folder_);
    write(folder_ / "proc/meminfo", "MemTotal:        4000000 kB\nMemAvailable:    2500000 kB\n");
    write(folder_ / "proc/self/cgroup", "0::/system.slice/kasumi.service\n");
  }
  std::filesystem::path group() const { return folder_ / "cgroup/system.slice/kasumi.service"; }
  std::optional<std::uint64_t> left() const { return memory_left(folder_ / "proc", folder_ / "cgroup"); }

  const std::filesystem::path folder_ = test_output_folder() / "memory-left";
};

TEST_F(MemoryLeft, IsWhatTheMachineHasWhereTheServiceIsNotBounded) {
  EXPECT_EQ(left(), 2'500'000'000u / 1000 * 1024);
  write(group() / "memory.max", "max\n");
  write(group() / "memory.current", "1000\n");
  EXPECT_EQ(left(), 2'500'000'000u / 1000 * 1024);
}

TEST_F(MemoryLeft, IsWhatTheServiceMayTakeWhereThatIsLess) {
  write(group() / "memory.max", "1500000000\n");
  write(group() / "memory.current", "1100000000\n");
  EXPECT_EQ(left(), 400'000'000u);
  write(group() / "memory.stat", "anon 5\ninactive_file 100000000\nactive_file 7\n");
  EXPECT_EQ(left(), 500'000'000u) << "files that were read are given up";
}

TEST_F(MemoryLeft, IsNotKnownWithoutAnyOfIt) {
  EXPECT_FALSE(memory_left(folder_ / "nowhere", folder_ / "nowhere"));
}

}  // namespace
}  // namespace kasumi

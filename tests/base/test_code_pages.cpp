#include "base/outside/code_pages.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <link.h>
#include <unistd.h>

namespace kasumi {
namespace {

using Bytes = std::span<const std::byte>;

// Code and constants of the program and its libraries, without the kernel's own.
std::vector<Bytes> code_of_this_process() {
  std::vector<Bytes> found;
  const auto add = [](dl_phdr_info* object, std::size_t, void* to) {
    for (const auto& segment : std::span(object->dlpi_phdr, object->dlpi_phnum))
      if (segment.p_type == PT_LOAD && (segment.p_flags & (PF_W | PF_R)) == PF_R &&
          std::string_view(object->dlpi_name).find("vdso") == std::string_view::npos)
        static_cast<std::vector<Bytes>*>(to)->emplace_back(
            reinterpret_cast<const std::byte*>(object->dlpi_addr + segment.p_vaddr), segment.p_memsz);
    return 0;
  };
  ::dl_iterate_phdr(add, &found);
  return found;
}

// Reads every page.
std::size_t sum_of(const std::vector<Bytes>& all) {
  std::size_t sum = 0;
  for (const Bytes& bytes : all)
    sum = 31 * sum + std::hash<std::string_view>()({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return sum;
}

double resident_mb_of_files() {
  std::ifstream file("/proc/self/statm");
  long total = 0, resident = 0, of_files = 0;
  file >> total >> resident >> of_files;
  return static_cast<double>(of_files) * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

// Its address is written by the loader into a table of constants.
int answer() {
  return 42;
}
using Answer = int (*)();
volatile const Answer kAnswers[] = {answer, answer};

TEST(CodePages, LeaveTheProcessAndComeBackAsTheyWere) {
  const auto code = code_of_this_process();
  double code_mb = 0.0;
  for (const Bytes& bytes : code) code_mb += 1e-6 * static_cast<double>(bytes.size());
  const auto before = sum_of(code);
  const double all_mb = resident_mb_of_files();
  ASSERT_GT(all_mb, 0.8 * code_mb) << "all was just read";
  let_code_go();
  EXPECT_LT(resident_mb_of_files(), all_mb - 0.7 * code_mb);
  EXPECT_EQ(sum_of(code), before);
  EXPECT_EQ(kAnswers[1](), 42);
}

}  // namespace
}  // namespace kasumi

// Whole files through a power cut at any moment, with whatever was not written through lost.
#include <gtest/gtest.h>

#include <fcntl.h>
#include <unistd.h>

#include "base/files.hpp"
#include "base/lasting_file.hpp"
#include "base/unique_fd.hpp"
#include "tests/base/power_cut.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

std::filesystem::path fresh(const std::string& name) {
  const auto folder = test_output_folder() / "power-cut" / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

// Cuts after every call; `check` is told how many calls had returned, and gets the folder as the next boot finds it.
void at_every_cut(const PowerCut& power, const std::function<void(std::size_t, const std::filesystem::path&)>& check) {
  const auto found = fresh("found");
  for (const auto left : PowerCut::kAll)
    for (std::size_t calls = 0; calls <= power.calls(); ++calls) {
      SCOPED_TRACE(fmt::format("cut after {} of {} calls, left over {}", calls, power.calls(), static_cast<int>(left)));
      power.lay_out(calls, left, found);
      check(calls, found);
    }
}

TEST(PowerCut, AFileIsTheOldOneOrTheNewOneAndTheNewOneOnceItIsWritten) {
  const auto folder = fresh("replaced");
  ASSERT_TRUE(write_text_file(folder / "state", "old"));
  PowerCut power(folder);
  ASSERT_TRUE(write_text_file(folder / "state", "new"));
  EXPECT_GE(power.calls(), 4u) << "opened, written, written through, renamed";
  at_every_cut(power, [&](std::size_t calls, const std::filesystem::path& found) {
    const auto text = read_text_file(found / "state");
    ASSERT_TRUE(text) << text.error().message;
    EXPECT_TRUE(*text == "new" || (calls < power.calls() && *text == "old")) << *text;
  });
}

TEST(PowerCut, ANewFileInANewFolderIsThereOnceItIsWritten) {
  const auto folder = fresh("new");
  PowerCut power(folder);
  ASSERT_TRUE(create_folders(folder / "a" / "b/"));
  ASSERT_TRUE(write_text_file(folder / "a" / "b" / "file", "whole"));
  at_every_cut(power, [&](std::size_t calls, const std::filesystem::path& found) {
    const auto text = read_text_file(found / "a" / "b" / "file");
    if (calls == power.calls()) {
      ASSERT_TRUE(text) << text.error().message;
    }
    if (text) {
      EXPECT_EQ(*text, "whole");
    }
  });
}

TEST(PowerCut, SoIsWhatALibraryWroteThatKnowsNothingOfThis) {
  const auto folder = fresh("library");
  PowerCut power(folder);
  ASSERT_TRUE(replace_file(folder / "film.mp4", [](const std::filesystem::path& unfinished) -> Result<> {
    const UniqueFd fd(::open(unfinished.c_str(), O_WRONLY | O_CREAT, 0644));
    return ::write(fd.value(), "film", 4) == 4 ? Result<>{} : fail(FaultKind::io, "write");
  }));
  at_every_cut(power, [&](std::size_t calls, const std::filesystem::path& found) {
    const auto text = read_text_file(found / "film.mp4");
    if (calls == power.calls()) {
      ASSERT_TRUE(text) << text.error().message;
    }
    if (text) {
      EXPECT_EQ(*text, "film");
    }
  });
}

}  // namespace
}  // namespace kasumi

// Pictures inside of archives, and archives that are none.
#include <gmock/gmock.h>

#include <fstream>

#include "base/files.hpp"
#include "base/utc_text.hpp"
#include "pipeline/site/files/archive_members.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "pipeline/site/files/picture_times.hpp"
#include "pipeline/site/files/taken_at.hpp"
#include "tests/pipeline/recorded.hpp"
#include "tests/pipeline/site/files/packed.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class ArchiveMembers : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
  }
  std::string text_of(const std::string& name) const {
    const auto bytes = read_picture_bytes(path.string() + ":" + name);
    return bytes ? std::string(bytes->begin(), bytes->end()) : bytes.error().message;
  }
  const std::filesystem::path folder = test_folder("archive-members");
  const std::filesystem::path path = folder / (std::string("sky") + GetParam());
};

TEST_P(ArchiveMembers, AreReadInAnyOrder) {
  const std::string large(300'000, 'x');
  pack(path, {{"2025/06/a.jpg", "first"}, {"2025/06/b:c.jpg", large}, {"Himmel \u00fcber Bern.png", "third"}});
  EXPECT_THAT(members_of(path).value(), ElementsAre("2025/06/a.jpg", "2025/06/b:c.jpg", "Himmel \u00fcber Bern.png"));
  for (int pass = 0; pass < 2; ++pass) {
    EXPECT_EQ(text_of("2025/06/a.jpg"), "first");
    EXPECT_EQ(text_of("2025/06/b:c.jpg"), large);
    EXPECT_EQ(text_of("Himmel \u00fcber Bern.png"), "third");
    EXPECT_EQ(text_of("2025/06/b:c.jpg"), large);
    EXPECT_THAT(text_of("2025/06/d.jpg"), HasSubstr("has no member 2025/06/d.jpg"));
  }
}

TEST_P(ArchiveMembers, AnArchiveCutAnywhereIsRefusedInWords) {
  std::string noise;
  for (unsigned i = 1, value = 1; i < 40'000; ++i)
    noise += static_cast<char>((value = value * 1103515245u + 12345u) >> 24);
  pack(path, {{"a.jpg", noise}, {"b.jpg", noise}});
  const auto whole = read_file(path).value();
  for (std::size_t cut = 1; cut < 20; ++cut) {
    const auto part = std::span(whole).first(whole.size() * cut / 20 / 2);
    ASSERT_TRUE(write_file(path, part));
    const auto found = text_of("b.jpg");
    EXPECT_THAT(found,
                AllOf(HasSubstr(path.string()), testing::AnyOf(HasSubstr("cannot be read as tar or zip: "),
                                                               HasSubstr("has no member b.jpg"), HasSubstr("b.jpg: "))))
        << cut;
  }
  ASSERT_TRUE(write_text_file(path, std::string(2000, 'n')));
  EXPECT_THAT(members_of(path).error().message, HasSubstr("cannot be read as tar or zip: "));
}

// What a process has read from its disk so far.
std::size_t bytes_read() {
  std::ifstream io("/proc/self/io");
  std::string word;
  std::size_t count = 0;
  return io >> word >> count ? count : 0;
}

// Backwards: of a plain tar the places are known, of a compressed one what was passed over is kept, and of a zip only the
// members' headers are passed again.
TEST_P(ArchiveMembers, AreNotReadFromTheStartForEachOne) {
  constexpr int kMembers = 100;
  std::vector<std::pair<std::string, std::string>> members;
  unsigned value = 1;
  for (int i = 0; i < kMembers; ++i) {
    std::string noise(50'000, ' ');
    for (auto& c : noise) c = static_cast<char>((value = value * 1103515245u + 12345u) >> 24);
    members.emplace_back(fmt::format("{}.jpg", i), noise);
  }
  pack(path, members);
  const auto size = std::filesystem::file_size(path);
  const auto before = bytes_read();
  for (int i = kMembers - 1; i >= 0; --i) {
    const auto& [name, bytes] = members[static_cast<std::size_t>(i)];
    ASSERT_EQ(text_of(name), bytes) << name;
  }
  EXPECT_LT(bytes_read() - before, (path.extension() == ".zip" ? 50 : 5) * size);
}

INSTANTIATE_TEST_SUITE_P(Formats, ArchiveMembers, testing::Values(".tar", ".tar.gz", ".zip"));

TEST(ArchiveMember, IsNamedBehindItsArchive) {
  const auto member = archive_member("/nowhere/a:b/sky.TAR:in/it.png");
  ASSERT_TRUE(member);
  EXPECT_EQ(member->archive, "/nowhere/a:b/sky.TAR");
  EXPECT_EQ(member->name, "in/it.png");
  EXPECT_EQ(member->path(), "/nowhere/a:b/sky.TAR:in/it.png");
  EXPECT_FALSE(archive_member("/nowhere/sky 2018-01-29_11:09:20 x.jpg"));
  EXPECT_FALSE(archive_member("/nowhere/sky.tar"));
  EXPECT_THAT(read_picture_bytes("/nowhere/sky.tar:a.png").error().message,
              HasSubstr("/nowhere/sky.tar: no such archive"));
}

TEST(ArchiveMember, AFilesOwnNameComesFirst) {
  const auto folder = test_folder("archive-colon");
  std::filesystem::create_directories(folder);
  ASSERT_TRUE(write_text_file(folder / "sky.tar:a.png", "own"));
  EXPECT_FALSE(archive_member(folder / "sky.tar:a.png"));
}

// Some kilobytes that become more than a picture may be.
TEST(ArchiveMember, ABombIsRefused) {
  const auto folder = test_folder("archive-bomb");
  std::filesystem::create_directories(folder);
  const auto path = folder / "bomb.tar.gz";
  {
    const auto made = begin_archive(path);
    begin_member(made.get(), "bomb.png", kMostMemberBytes + 1);
    const std::string piece(1 << 20, '\0');
    for (std::size_t done = 0; done <= kMostMemberBytes; done += piece.size())
      archive_write_data(made.get(), piece.data(), piece.size());
    EXPECT_EQ(archive_write_close(made.get()), 0);
  }
  EXPECT_LT(std::filesystem::file_size(path), 2'000'000u);
  EXPECT_THAT(read_photograph(path.string() + ":bomb.png").error().message,
              HasSubstr("bomb.tar.gz:bomb.png: more than 268435456 bytes"));
}

TEST(ArchiveMember, IsAPhotographAsItsFileIs) {
  const auto folder = test_folder("archive-photograph");
  std::filesystem::create_directories(folder);
  const auto frame = source_folder() / "fixtures/demo/sky/frame-000000.jpg";
  pack(folder / "sky.zip", {{"20180129_110920.jpg", read_text_file(frame).value()}});
  const auto alone = read_photograph(frame).value(),
             packed = read_photograph(folder / "sky.zip:20180129_110920.jpg").value();
  EXPECT_EQ(alone.encoded.elements(), packed.encoded.elements());
  EXPECT_EQ(utc_text(picture_time(folder / "sky.zip:20180129_110920.jpg", {}).value()), "2018-01-29T11:09:20Z");
}

TEST(PictureBegin, IsAllThatATimeNeeds) {
  const auto folder = test_folder("picture-begin");
  std::filesystem::create_directories(folder);
  ASSERT_TRUE(write_text_file(folder / "large.jpg", std::string(8 << 20, 'x')));
  const auto before = bytes_read();
  EXPECT_FALSE(picture_time(folder / "large.jpg", {}));
  EXPECT_LT(bytes_read() - before, kTakenAtBytes + 4096);
}

}  // namespace
}  // namespace kasumi

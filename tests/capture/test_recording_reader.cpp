// Looking through a recording: what counts as a picture, and which are taken when not all are wanted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/recording_reader.hpp"
#include "tests/capture/recording.hpp"

namespace kasumi {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct Looked {
  Result<PicturesRead> read;
  std::vector<std::uint32_t> sequences;
};

Looked look_through(const std::filesystem::path& folder, const ReadingOptions& options = {}) {
  std::vector<std::uint32_t> sequences;
  auto read = for_each_picture(folder, options, [&](const PictureView& view, const FrameMetadata& metadata) {
    EXPECT_EQ(view.width, metadata.width);
    sequences.push_back(metadata.sequence);
  });
  return {std::move(read), std::move(sequences)};
}

// One row a second, each a whole picture.
std::string good_rows(int count) {
  std::string rows;
  for (int i = 0; i < count; ++i)
    rows += fmt::format("{},2026-06-21T03:00:{:02}Z,{},YUYV,2,2,4,8,,,,a.yuyv\n", 1'000'000'000ll * i, i, i);
  return rows;
}

TEST(RecordingReader, EveryPictureIsHandedOverInOrder) {
  const auto [read, sequences] = look_through(folder_with_index("reader_whole", good_rows(4)));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_THAT(sequences, ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(read->good, 4);
  EXPECT_EQ(read->damaged, 0);
  EXPECT_EQ(read->last - read->first, 3s);
}

TEST(RecordingReader, WhatIsDamagedIsCountedAndPassedOverWhateverTheReason) {
  const auto folder = folder_with_index("reader_damaged",
                                        "0,2026-06-21T03:00:00Z,0,YUYV,2,2,4,8,,,error,a.yuyv\n"  // flagged
                                        "1,2026-06-21T03:00:01Z,1,YUYV,2,2,4,7,,,,a.yuyv\n"       // cut short
                                        "2,2026-06-21T03:00:02Z,2,YUYV,2,2,4,8,,,,a.yuyv\n"       // good
                                        "3,2026-06-21T03:00:03Z,3,YUYV,2,2,4,0,,,,\n"             // nothing
                                        "4,2026-06-21T03:00:04Z,4,MJPG,2,2,0,8,,,,a.yuyv\n"       // no JPEG
                                        "5,2026-06-21T03:00:05Z,5,GREY,4,2,4,8,,,,a.yuyv\n"       // another size
                                        "6,2026-06-21T03:00:06Z,,,,,,,,,disconnected,\n"          // no picture
                                        "7,2026-06-21T03:00:07Z,7,YUYV,2,2,4,8,,,,gone.yuyv\n"    // vanishes
                                        "8,2026-06-21T03:00:08Z,8,YUYV,2,2,4,8,,,,a.yuyv\n");     // good
  ASSERT_FALSE(look_through(folder).read) << "a payload that was never there makes no recording";
  ASSERT_TRUE(write_file(folder / "gone.yuyv", std::vector<std::uint8_t>(8)));
  std::vector<std::uint32_t> sequences;
  const auto read =
      for_each_picture(folder, {.width = 2, .height = 2}, [&](const PictureView&, const FrameMetadata& metadata) {
        sequences.push_back(metadata.sequence);
        std::filesystem::remove(folder / "gone.yuyv");
      });
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_THAT(sequences, ElementsAre(2, 8));
  EXPECT_EQ(read->good, 2);
  EXPECT_EQ(read->damaged, 6);
  EXPECT_EQ(read->last - read->first, 6s) << "of the good ones";
}

TEST(RecordingReader, SomeOfManyAreTheFirstGoodOnesOfEqualStretches) {
  const auto whole = folder_with_index("reader_most", good_rows(10));
  EXPECT_THAT(look_through(whole, {.most = 3}).sequences, ElementsAre(0, 4, 7));
  EXPECT_EQ(look_through(whole, {.most = 30}).sequences.size(), 10u);
  auto rows = good_rows(10);
  rows.replace(rows.find(",8,,,,"), 6, ",7,,,,");  // the first is cut short
  const auto damaged = look_through(folder_with_index("reader_most_damaged", rows), {.most = 3});
  EXPECT_THAT(damaged.sequences, ElementsAre(1, 4, 7));
  EXPECT_EQ(damaged.read->damaged, 1);
}

TEST(RecordingReader, WhatIsDeclinedIsNeitherGoodNorDamaged) {
  const auto folder = folder_with_index("reader_wanted", good_rows(5));
  ReadingOptions options;
  options.wanted = [](const FrameMetadata& metadata) { return metadata.sequence % 2 == 1; };
  const auto odd = look_through(folder, options);
  EXPECT_THAT(odd.sequences, ElementsAre(1, 3));
  EXPECT_EQ(odd.read->damaged, 0);
  options.wanted = [](const FrameMetadata&) { return false; };
  const auto none = look_through(folder, options);
  ASSERT_TRUE(none.read) << none.read.error().message;
  EXPECT_EQ(none.read->good, 0);
}

TEST(RecordingReader, ARecordingWithoutAGoodPictureIsRefused) {
  for (const char* rows : {"", "0,2026-06-21T03:00:00Z,0,YUYV,2,2,4,8,,,error,a.yuyv\n",
                           "0,2026-06-21T03:00:00Z,,,,,,,,,disconnected,\n"}) {
    const auto [read, sequences] = look_through(folder_with_index("reader_none", rows));
    ASSERT_FALSE(read) << rows;
    EXPECT_EQ(read.error().kind, FaultKind::bad_input);
    EXPECT_THAT(read.error().message, HasSubstr("no picture of it can be read"));
  }
  EXPECT_FALSE(look_through(fresh_folder("reader_nothing")).read) << "no index";
}

}  // namespace
}  // namespace kasumi

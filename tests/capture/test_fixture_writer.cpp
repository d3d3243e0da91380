#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>

#include <sys/resource.h>

#include "capture/fixture_writer.hpp"
#include "capture/replay_source.hpp"
#include "recording.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

std::vector<Frame> replayed(const std::filesystem::path& folder) {
  UnhurriedClock clock{Utc{}};
  auto source = open_replay(folder, clock);
  EXPECT_TRUE(source) << source.error().message;
  std::vector<Frame> frames;
  while (source) {
    auto frame = (*source)->next(clock.now() + 1s);
    if (frame)
      frames.push_back(std::move(*frame));
    else if (frame.error().kind == FaultKind::end_of_stream)
      break;
  }
  return frames;
}

void expect_same(const FrameMetadata& a, const FrameMetadata& b) {
  EXPECT_EQ(a.captured_at, b.captured_at);
  EXPECT_EQ(a.utc, b.utc);
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.format, b.format);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.stride, b.stride);
  EXPECT_EQ(a.bytes_used, b.bytes_used);
  EXPECT_EQ(a.exposure_s, b.exposure_s);
  EXPECT_EQ(a.gain, b.gain);
  EXPECT_EQ(a.status, b.status);
}

std::size_t payload_files(const std::filesystem::path& folder) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) count += entry.path().extension() != ".csv";
  return count;
}

TEST(FixtureWriter, WhatIsWrittenIsReplayedBitForBitInEveryFormat) {
  const auto folder = fresh_folder("writer");
  std::vector<Frame> frames;
  for (const char* code : {"MJPG", "YUYV", "UYVY", "NV12", "YU12", "RGB3", "BGR3", "XR24", "AB24", "GREY"})
    frames.push_back(frame_at(frames.size() * 33333333ns, 4 * static_cast<std::uint32_t>(frames.size()),
                              parse_four_cc(code).value()));
  frames[1].metadata.exposure_s = 1.0 / 250.0;
  frames[2].metadata.gain = 2.7;
  frames[3].metadata.status = FrameStatus::flagged;
  frames[4].metadata.captured_at -= 1s / 10;  // runs backwards
  frames[5].metadata.status = FrameStatus::truncated;
  frames[5].metadata.bytes_used = 10;
  frames[5].payload = payload_of(std::vector<std::uint8_t>(10));
  frames[6].metadata.status = FrameStatus::truncated;
  frames[6].payload = payload_of(std::vector<std::uint8_t>(7));  // fewer than bytes_used says
  frames[7].metadata.status = FrameStatus::truncated;
  frames[7].metadata.bytes_used = 0;
  frames[7].payload = payload_of(std::vector<std::uint8_t>());

  auto writer = FixtureWriter::create(folder).value();
  for (const auto& frame : frames) ASSERT_TRUE(writer.append(frame));
  EXPECT_EQ(writer.row_count(), 10);

  const auto back = replayed(folder);
  ASSERT_EQ(back.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    SCOPED_TRACE(i);
    expect_same(back[i].metadata, frames[i].metadata);
    EXPECT_TRUE(std::ranges::equal(back[i].payload.bytes, frames[i].payload.bytes));
  }
}

TEST(FixtureWriter, EqualPayloadsAreStoredOnceUnlessToldOtherwise) {
  for (const bool share : {true, false}) {
    const auto folder = fresh_folder("writer");
    auto writer = FixtureWriter::create(folder, {.share_equal_payloads = share}).value();
    auto other = frame_at(1s, 1);
    other.payload = payload_of(std::vector<std::uint8_t>(other.payload.bytes.size(), std::uint8_t{5}));
    ASSERT_TRUE(writer.append(frame_at(0s, 0)));
    ASSERT_TRUE(writer.append(other));
    ASSERT_TRUE(writer.append(frame_at(2s, 2)));
    EXPECT_EQ(payload_files(folder), share ? 2u : 3u);
    EXPECT_TRUE(std::ranges::equal(replayed(folder)[2].payload.bytes, frame_at(2s, 2).payload.bytes));
  }
}

TEST(FixtureWriter, ACutAfterAnyByteOfTheIndexLeavesEveryWholeRow) {
  const auto folder = fresh_folder("writer");
  auto writer = FixtureWriter::create(folder).value();
  for (std::uint32_t i = 0; i < 12; ++i) {  // frame-000001 and frame-000010 begin alike
    auto frame = frame_at(i * 40ms, i);
    frame.payload = payload_of(std::vector<std::uint8_t>(frame.payload.bytes.size(), static_cast<std::uint8_t>(i)));
    ASSERT_TRUE(writer.append(frame));
  }
  ASSERT_TRUE(writer.append_disconnect(Instant{1s}, Utc{1s}));
  const auto whole = read_index(folder).value();
  const auto text = read_text_file(folder / "index.csv").value();
  ASSERT_EQ(whole.size(), 13u);
  for (std::size_t length = text.size() + 1; length-- > 0;) {
    const auto cut = std::string_view(text).substr(0, length);
    std::filesystem::resize_file(folder / "index.csv", length);
    const auto rows = read_index(folder);
    ASSERT_TRUE(rows) << "after " << length << " bytes: " << rows.error().message;
    const auto lines = static_cast<std::size_t>(std::ranges::count(cut, '\n'));
    ASSERT_EQ(rows->size(), lines == 0 ? 0 : lines - 1) << "after " << length << " bytes";
    for (std::size_t i = 0; i < rows->size(); ++i) {
      ASSERT_EQ((*rows)[i].payload, whole[i].payload);
      ASSERT_EQ((*rows)[i].metadata.captured_at, whole[i].metadata.captured_at);
    }
  }
}

TEST(FixtureWriter, ARowNeverNamesAPayloadThatIsNotThere) {
  const auto folder = fresh_folder("writer");
  auto writer = FixtureWriter::create(folder).value();
  ASSERT_TRUE(writer.append(frame_at(0s, 0)));
  std::filesystem::create_directory(folder / "frame-000001.yuyv");  // in the way of the next payload
  std::ofstream(folder / "frame-000001.yuyv" / "x") << "x";
  auto frame = frame_at(1s, 1);
  frame.payload = payload_of(std::vector<std::uint8_t>(frame.payload.bytes.size(), std::uint8_t{5}));
  const auto refused = writer.append(frame);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::io);
  EXPECT_EQ(writer.row_count(), 1);
  EXPECT_EQ(replayed(folder).size(), 1u);
}

TEST(FixtureWriter, AnImpossibleFrameIsRefusedAndLeavesNoTrace) {
  const auto folder = fresh_folder("writer");
  auto writer = FixtureWriter::create(folder).value();
  auto frame = frame_at(0s, 0);
  frame.metadata.width = 0;
  EXPECT_THAT(writer.append(frame).error().message, HasSubstr("size 0x6"));
  EXPECT_EQ(payload_files(folder), 0u);
  EXPECT_TRUE(read_index(folder)->empty());
}

TEST(FixtureWriter, ARecordingIsNotOverwritten) {
  const auto folder = fresh_folder("writer");
  {
    auto writer = FixtureWriter::create(folder).value();
    ASSERT_TRUE(writer.append(frame_at(0s, 0)));
  }
  const auto refused = FixtureWriter::create(folder);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::bad_input);
  EXPECT_EQ(replayed(folder).size(), 1u);
}

// A limit on the size of files makes a write stop half way, as a full disk does.
class SmallDisk {
 public:
  explicit SmallDisk(std::uintmax_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  ~SmallDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = nullptr;
};

TEST(FixtureWriter, AFullDiskLeavesWholeRowsAndTheRecordingGoesOnWhenThereIsSpace) {
  const auto folder = fresh_folder("writer");
  auto writer = FixtureWriter::create(folder).value();
  ASSERT_TRUE(writer.append(frame_at(0s, 0)));
  Result<> refused;
  {
    const SmallDisk disk(std::filesystem::file_size(folder / "index.csv") + 10);  // room for a part of the next row
    refused = writer.append(frame_at(1s, 1));
  }
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::io);
  EXPECT_EQ(replayed(folder).size(), 1u);
  ASSERT_TRUE(writer.append(frame_at(2s, 2)));
  const auto frames = replayed(folder);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames.back().metadata.sequence, 2u);
}

}  // namespace
}  // namespace kasumi

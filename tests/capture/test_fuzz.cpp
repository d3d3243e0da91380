// Thousands of damaged inputs with a fixed seed: each is refused with a message or gives a picture of the announced
// size. Run under the address and undefined sanitizers this says that no byte of a file can lead outside its buffer.
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "capture/replay_source.hpp"
#include "exotic_jpeg.hpp"
#include "recording.hpp"

namespace kasumi {
namespace {

class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}
  std::size_t below(std::size_t limit) { return static_cast<std::size_t>(random_() % std::max<std::size_t>(1, limit)); }

  // Flips bits, overwrites, cuts, removes, repeats; one to four times.
  template <class Sequence>
  Sequence damaged(Sequence data) {
    for (auto times = 1 + below(4); times > 0 && !data.empty(); --times) {
      const auto at = static_cast<std::ptrdiff_t>(below(data.size()));
      const auto length = std::min<std::ptrdiff_t>(std::ssize(data) - at, 1 + static_cast<std::ptrdiff_t>(below(16)));
      const auto first = data.begin() + at;
      using Element = typename Sequence::value_type;
      switch (below(6)) {
        case 0: *first = static_cast<Element>(*first ^ (1 << below(8))); break;
        case 1: *first = static_cast<Element>(random_()); break;
        case 2: *first = static_cast<Element>(below(2) == 0 ? 0xFF : 0x00); break;
        case 3: data.erase(first, data.end()); break;
        case 4: data.erase(first, first + length); break;
        case 5: {
          const Sequence copy(first, first + length);
          data.insert(data.begin() + at, copy.begin(), copy.end());
          break;
        }
      }
    }
    return data;
  }

 private:
  std::mt19937_64 random_;
};

// Reads every pixel, so that a plane that reaches out of its buffer is caught.
void expect_picture_or_message(const Frame& frame, int& pictures) {
  const auto picture = decode(frame, YuvEncoding::bt601_full);
  if (!picture) {
    ASSERT_EQ(picture.error().kind, FaultKind::bad_input);
    ASSERT_FALSE(picture.error().message.empty());
    return;
  }
  ASSERT_EQ(picture->view().width, frame.metadata.width);
  ASSERT_EQ(picture->view().height, frame.metadata.height);
  if (std::int64_t{frame.metadata.width} * frame.metadata.height < 100'000) {
    ASSERT_EQ(to_rgb(picture->view()).width(), frame.metadata.width);
  }
  ++pictures;
}

TEST(Fuzz, DamagedJpegs) {
  Mutator mutator(20260621);
  const auto image = test_picture(48, 40);
  const std::vector<std::vector<std::uint8_t>> seeds{
      encode_jpeg(image, 85, ChromaSubsampling::s420).value(),
      encode_jpeg(image, 85, ChromaSubsampling::s422).value(),
      encode_jpeg(image, 85, ChromaSubsampling::grey).value(),
      without_huffman_tables(encode_jpeg(image, 85, ChromaSubsampling::s444).value()),
      exotic_jpeg(image, [](jpeg_compress_struct& info) { info.restart_interval = 1; }),
      exotic_jpeg(image, [](jpeg_compress_struct& info) { jpeg_simple_progression(&info); }),
  };
  int pictures = 0;
  constexpr int kRounds = 6000;
  for (int round = 0; round < kRounds; ++round)
    ASSERT_NO_FATAL_FAILURE(expect_picture_or_message(
        frame_with(kMjpg, 48, 40, 0, mutator.damaged(seeds[mutator.below(seeds.size())])), pictures));
  EXPECT_GT(pictures, kRounds / 20) << "damage in the tables or pixels often leaves a decodable picture";
  EXPECT_LT(pictures, kRounds * 19 / 20) << "damage must be noticed";
}

TEST(Fuzz, UncompressedFramesWithDamagedMetadata) {
  Mutator mutator(7);
  int pictures = 0;
  const auto wild = [&](std::int64_t sane) -> std::int64_t {
    switch (mutator.below(16)) {
      case 0: return 0;
      case 1: return -1;
      case 2: return std::int64_t{1} << mutator.below(33);
      case 3: return sane + 1;
      case 4: return sane - 1;
      case 5: return 2 * sane;
      default: return sane;
    }
  };
  constexpr int kRounds = 6000;
  for (int round = 0; round < kRounds; ++round) {
    const char* codes[] = {"YUYV", "UYVY", "NV12", "YU12", "RGB3", "BGR3", "XR24", "AB24", "GREY", "MJPG"};
    const auto format = parse_four_cc(codes[mutator.below(10)]).value();
    auto frame = encode_frame(test_picture(9, 7), format).value();
    frame.metadata.width = static_cast<int>(wild(frame.metadata.width));
    frame.metadata.height = static_cast<int>(wild(frame.metadata.height));
    frame.metadata.stride = static_cast<std::uint32_t>(wild(frame.metadata.stride));
    frame.metadata.bytes_used = static_cast<std::uint32_t>(wild(frame.metadata.bytes_used));
    ASSERT_NO_FATAL_FAILURE(expect_picture_or_message(frame, pictures));
  }
  EXPECT_GT(pictures, kRounds / 20);
  EXPECT_LT(pictures, kRounds * 19 / 20);
}

TEST(Fuzz, DamagedIndexes) {
  Mutator mutator(11);
  const auto folder = fresh_folder("fuzz");
  const auto jpeg = encode_jpeg(test_picture(8, 6), 85, ChromaSubsampling::s420).value();
  ASSERT_TRUE(write_file(folder / "a.jpg", jpeg));
  ASSERT_TRUE(write_file(folder / "b.yuyv", frame_at(0s, 0).payload.bytes));
  const std::string index = std::string(kIndexHeader) +
                            "\n1000000000,2026-06-21T03:00:00Z,0,YUYV,8,6,16,96,0.004,1,,b.yuyv\n"
                            "1040000000,2026-06-21T03:00:00.040Z,1,MJPG,8,6,0," +
                            std::to_string(jpeg.size()) +
                            ",,,,a.jpg\n"
                            "1080000000,2026-06-21T03:00:00.080Z,,,,,,,,,disconnected,\n"
                            "1200000000,2026-06-21T03:00:00.200Z,5,YUYV,8,6,16,96,,,error,b.yuyv\n";
  constexpr int kRounds = 3000;
  int refused = 0, frames = 0, pictures = 0;
  for (int round = 0; round < kRounds; ++round) {
    {
      // A new file each time: waiting for the disk, as replacing one does, would take most of the time.
      std::filesystem::remove(folder / "index.csv");
      std::ofstream file(folder / "index.csv", std::ios::binary);
      file << mutator.damaged(index);
    }
    UnhurriedClock clock{Utc{}};
    const auto source = open_replay(folder, clock, {.loop = mutator.below(4) == 0});
    if (!source) {
      ASSERT_FALSE(source.error().message.empty());
      ++refused;
      continue;
    }
    for (int call = 0; call < 12; ++call) {
      const auto frame = (*source)->next(clock.now() + std::chrono::hours{24 * 400});
      if (!frame && frame.error().kind == FaultKind::end_of_stream) break;
      if (!frame) continue;
      ++frames;
      ASSERT_NO_FATAL_FAILURE(expect_picture_or_message(*frame, pictures));
    }
  }
  EXPECT_GT(refused, kRounds / 10);
  EXPECT_GT(frames, kRounds / 10);
  EXPECT_GT(pictures, kRounds / 10);
}

}  // namespace
}  // namespace kasumi

// Shared by the capture tests: frames of known content, and folders to record them in.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/files.hpp"
#include "capture/codec/encode.hpp"
#include "capture/fixture/fixture.hpp"
#include "tests/places.hpp"

namespace kasumi {

using namespace std::chrono_literals;

inline std::filesystem::path fresh_folder(std::string_view name) {
  const auto path = test_output_folder() / "capture" / name;
  std::filesystem::remove_all(path);
  std::filesystem::create_directories(path);
  return path;
}

// Colour changes slowly, brightness from pixel to pixel, and nothing reaches 0 or 255: chroma filtering then has no
// visible effect, but a shifted plane has.
inline Image<Rgb8> test_picture(int width, int height) {
  Image<Rgb8> image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int detail = (x * 7 + y * 13) % 23;
      image.at(x, y) = {60 + x / 2 + detail, 90 + y / 2 + detail, 150 - x / 4 + detail};
    }
  return image;
}

inline Frame frame_with(FourCc format, int width, int height, std::uint32_t stride, std::vector<std::uint8_t> bytes) {
  Frame frame;
  frame.metadata.format = format;
  frame.metadata.width = width;
  frame.metadata.height = height;
  frame.metadata.stride = stride;
  frame.metadata.bytes_used = static_cast<std::uint32_t>(bytes.size());
  frame.payload = payload_of(std::move(bytes));
  return frame;
}

inline Frame frame_at(Duration recorded, std::uint32_t sequence, FourCc format = four_cc("YUYV")) {
  auto frame = encode_frame(test_picture(8, 6), format).value();
  frame.metadata.captured_at = Instant{recorded};
  frame.metadata.utc = std::chrono::sys_days{std::chrono::June / 21 / 2026} + 3h + recorded;
  frame.metadata.sequence = sequence;
  return frame;
}

// A folder with the header, the rows as given and a payload a.yuyv of 2x2 pixels (8 bytes).
inline std::filesystem::path folder_with_index(std::string_view name, std::string_view rows) {
  const auto folder = fresh_folder(name);
  (void)write_file(folder / "a.yuyv", std::vector<std::uint8_t>{10, 20, 30, 40, 50, 60, 70, 80});
  (void)write_text_file(folder / "index.csv", std::string(kIndexHeader) + "\n" + std::string(rows));
  return folder;
}

}  // namespace kasumi

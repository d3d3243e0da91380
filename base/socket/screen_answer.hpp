// The picture of the screen that the appliance sends to kasumi-report over a socket beside its runtime folder: blurred,
// and no larger than the blur leaves detail for. Each connection gets one answer; nothing is read from it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "base/clock.hpp"
#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"

namespace kasumi {

// In a folder of its own, whose permissions say which accounts may connect: /run/kasumi-screen beside /run/kasumi. Not
// within it: root creates the folder for another group, and within its own folder the appliance could redirect that by
// a link.
std::filesystem::path screen_socket(const std::filesystem::path& runtime_folder);
// Along a side: what an answer can hold at all.
constexpr int kMostScreenPixels = 32;
// From one picture to the next.
constexpr std::chrono::minutes kScreenPause{1};

struct ScreenAnswer {
  Image<Rgb8> picture;  // at most 32 x 32 pixels, sRGB; empty: there is none
  Utc utc{};            // when it was taken, in whole seconds
  // Why there is none: it is too soon after the last. Without it nothing is on the glass.
  std::optional<std::chrono::seconds> wait;
};

// "picture 32 18 2026-06-21T12:00:00Z", "wait 37" or "nothing" and a line end; after the first the picture's bytes, R G
// B by rows.
std::string screen_answer_bytes(const ScreenAnswer& answer);
constexpr std::size_t kLongestScreenLine = 64;
// What the line says, without its end; the picture has its size and is black. Errors: bad_input.
Result<ScreenAnswer> parse_screen_line(std::string_view line);

}  // namespace kasumi

#include "base/socket/screen_answer.hpp"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "base/utc_text.hpp"

namespace kasumi {
namespace {

// Up to the next space, which is left out.
std::string_view take_word(std::string_view& line) {
  const auto word = line.substr(0, line.find(' '));
  line.remove_prefix(std::min(word.size() + 1, line.size()));
  return word;
}

// Digits alone; empty: not a number from 1 to `most`.
std::optional<int> count_of(std::string_view word, int most) {
  int value = 0;
  const auto* end = word.data() + word.size();
  const auto read = std::from_chars(word.data(), end, value);
  if (read.ec != std::errc() || read.ptr != end || value < 1 || value > most) return std::nullopt;
  return value;
}

}  // namespace

std::filesystem::path screen_socket(const std::filesystem::path& runtime_folder) {
  auto folder = runtime_folder;
  folder += "-screen";
  return folder / "screen.sock";
}

std::string screen_answer_bytes(const ScreenAnswer& answer) {
  const auto& picture = answer.picture;
  if (picture.empty()) return answer.wait ? fmt::format("wait {}\n", answer.wait->count()) : "nothing\n";
  auto bytes = fmt::format("picture {} {} {}\n", picture.width(), picture.height(),
                           utc_text(std::chrono::floor<std::chrono::seconds>(answer.utc)));
  for (const Rgb8& pixel : picture.elements())
    for (const std::uint8_t value : {pixel.r, pixel.g, pixel.b}) bytes += static_cast<char>(value);
  return bytes;
}

Result<ScreenAnswer> parse_screen_line(std::string_view line) {
  ScreenAnswer answer;
  if (line == "nothing") return answer;
  const auto kind = take_word(line);
  if (kind == "wait") {
    const auto seconds = count_of(line, std::chrono::seconds(kScreenPause).count());
    if (seconds) answer.wait.emplace(*seconds);
    if (seconds) return answer;
  } else if (kind == "picture") {
    const auto width = count_of(take_word(line), kMostScreenPixels),
               height = count_of(take_word(line), kMostScreenPixels);
    const auto utc = parse_utc(line);
    if (width && height && utc) answer.picture = Image<Rgb8>(*width, *height);
    if (!answer.picture.empty()) answer.utc = *utc;
    if (!answer.picture.empty()) return answer;
  }
  return fail(FaultKind::bad_input,
              "an answer that is none: expected a picture of at most {0} x {0}, a wait, or nothing", kMostScreenPixels);
}

}  // namespace kasumi

// index.csv of a recording, and the frames of its rows.
#include <array>

#include "capture/fixture/fixture.hpp"
#include "capture/fixture/replay_source.hpp"
#include "tests/fuzz/scratch.hpp"

void kasumi::try_input(std::span<const std::uint8_t> input) {
  static const Scratch scratch;
  static const auto payload = scratch.file("a.yuyv", std::array<std::uint8_t, 64>{});
  scratch.file("index.csv", input);
  const auto rows = read_index(scratch.folder());
  expect_value_or_sentence(rows);
  if (!rows) return;
  FastForwardClock clock{Utc{}};
  const auto source = open_replay(scratch.folder(), clock);
  expect_value_or_sentence(source);
  for (std::size_t i = 0; source && i < 2 * rows->size() + 2; ++i) {
    const auto frame = (*source)->next(clock.now() + std::chrono::hours(1));
    expect_value_or_sentence(frame);
    if (!frame) continue;
    const auto picture = decode(*frame, YuvEncoding::bt601_full);
    expect_value_or_sentence(picture);
    if (picture && frame->metadata.width * std::int64_t{frame->metadata.height} < 4096) to_rgb(picture->view());
  }
}

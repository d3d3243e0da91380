// People who pass in front of the building.
#include <optional>

#include "capture/codec/encode.hpp"
#include "tests/pipeline/show/scene/compositors.hpp"

namespace kasumi {
namespace {

// A land of stripes and spots; each picture has noise of its own. Somebody in red stands at `left`, `top`, where asked.
Frame picture_at(int second, std::optional<glm::ivec2> left_top = std::nullopt) {
  constexpr int kWidth = 480, kHeight = 270;  // as the fixture
  Image<Rgb8> picture(kWidth, kHeight);
  std::uint32_t noise = static_cast<std::uint32_t>(second) + 1;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      noise = noise * 1664525U + 1013904223U;
      const int land = 90 + 40 * (x / 9 % 2) + 20 * (y / 7 % 2) + static_cast<int>(noise >> 30U);
      picture.at(x, y) = Rgb8(land, land + 10, land - 20);
    }
  if (left_top)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 16; ++x) picture.at(left_top->x + x, left_top->y + y) = {200, 30, 30};
  Frame frame = encode_frame(picture, four_cc("RGB3")).value();
  frame.metadata.captured_at = Instant{} + std::chrono::seconds(second);
  return frame;
}

TEST_F(Compositors, KeepWhoPassesInFrontWhereThatIsAskedFor) {
  constexpr int kLearnt_s = 140;
  Compositor over = make();
  installation_.people_in_front = true;
  Compositor behind = make();
  for (int second = 0; second < kLearnt_s; ++second) {
    drawn(behind, picture_at(second));
    if (second == 10) {
      ASSERT_EQ(behind.around().passers()->state, PassersState::learning);
    }
  }
  ASSERT_EQ(behind.around().passers()->state, PassersState::watching);
  drawn(behind, picture_at(kLearnt_s));
  EXPECT_EQ(behind.look()->passers, 0U);

  const PixelBox box = behind.object_box();
  const glm::ivec2 at{(box.left + box.right) / 2 - 8, (box.top + box.bottom) / 2 - 20};
  const Frame somebody = picture_at(kLearnt_s + 1, at);
  const auto painted = drawn(over, somebody), kept = drawn(behind, somebody);
  EXPECT_EQ(over.around().passers(), nullptr);
  EXPECT_NE(behind.look()->passers, 0U);
  const Image<Rgb8> camera = to_rgb(decode(somebody, YuvEncoding::bt601_full)->view());
  int painted_over = 0, lost = 0;
  for (int y = 2; y < 38; ++y)
    for (int x = 2; x < 14; ++x) {
      painted_over += painted.at(at.x + x, at.y + y) != camera.at(at.x + x, at.y + y);
      lost += kept.at(at.x + x, at.y + y) != camera.at(at.x + x, at.y + y);
    }
  EXPECT_GT(painted_over, 100);  // the building covers him there
  EXPECT_EQ(lost, 0);
}

}  // namespace
}  // namespace kasumi

// A watch under pictures as bad cameras deliver them: any layout, odd sizes, buildings cut by the picture's edge, nothing
// but noise, clocks that jump. What it leaves out is always a part of the picture. The address sanitizer looks on.
#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "estimator/passers/passers.hpp"
#include "fixtures/noise/random.hpp"

namespace kasumi {
namespace {

using fixtures::Random;

// Planes of their very size, so that no byte beyond them can be read unnoticed.
struct OddPicture {
  std::array<std::vector<std::uint8_t>, 3> planes;
  PictureView view;
  OddPicture(PixelLayout layout, int width, int height) : view{layout, YuvEncoding::bt601_full, width, height, {}} {
    for (int i = 0; i < plane_count(layout); ++i) {
      const auto at = static_cast<std::size_t>(i);
      const auto size = plane_size(layout, width, height, i);
      planes[at].resize(size.row_bytes * static_cast<std::size_t>(size.rows));
      view.planes[at] = {planes[at].data(), size.row_bytes};
    }
  }
  // A scene that is always the same but for its noise; or somebody in its middle; or something else altogether.
  void expose(Random& random, double kind) {
    for (int p = 0; p < plane_count(view.layout); ++p) {
      auto& plane = planes[static_cast<std::size_t>(p)];
      const auto row_bytes = view.planes[static_cast<std::size_t>(p)].stride, rows = plane.size() / row_bytes;
      for (std::size_t i = 0; i < plane.size(); ++i) {
        const std::size_t x = i % row_bytes, y = i / row_bytes;
        const bool middle = x > row_bytes * 2 / 5 && x < row_bytes / 2 && y > rows / 3 && y < rows * 3 / 5;
        const double usual = 90.0 + static_cast<double>(i * 7 % 50) + 2.0 * random.normal();
        const double value = kind < 0.60   ? usual
                             : kind < 0.94 ? (middle ? 230.0 : usual)
                             : kind < 0.96 ? 255.0 * random.uniform()
                             : kind < 0.98 ? 0.0
                                           : 255.0;
        plane[i] = static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
      }
    }
  }
};

class PassersInOddPictures : public testing::TestWithParam<PixelLayout> {};

TEST_P(PassersInOddPictures, LeaveOutPartsOfThePictureAlone) {
  Random random(fixtures::mix(11, static_cast<int>(GetParam()), 0));
  const auto below = [&](int most) { return static_cast<int>(random.uniform() * most); };
  int found = 0;
  for (int round = 0; round < 6; ++round) {
    const int width = 40 + below(90), height = 30 + below(60);
    const int left = below(width / 2) - 10, top = below(height / 2) - 10;
    const PartPlace place = part_around(left, top, left + 8 + below(60), top + 8 + below(60), below(24), width, height);
    Passers watch(place);
    Instant at{};
    for (int i = 0; i < 220; ++i) {
      // One camera in five is exchanged for another for a picture.
      const int cut = random.uniform() < 0.02 ? 7 : 0;
      OddPicture picture(GetParam(), width - cut, height - cut);
      picture.expose(random, i < 130 ? 0.0 : random.uniform());
      const double jump = i < 130 ? 1.0 : random.uniform();
      at += jump < 0.010   ? -std::chrono::seconds(400)
            : jump < 0.015 ? std::chrono::seconds(4000)
                           : std::chrono::seconds(1);
      const PassersLook& look = watch.look(picture.view, at);
      ASSERT_TRUE(look.covered_share >= 0.0 && look.covered_share <= 1.0) << look.covered_share;
      const PassersInFront& in_front = look.in_front;
      if (in_front.empty()) continue;
      ++found;
      const int right = in_front.left + in_front.pixels.width(), bottom = in_front.top + in_front.pixels.height();
      ASSERT_TRUE(in_front.left >= place.left - 1 && right <= place.left + place.width + 1);
      ASSERT_TRUE(in_front.top >= place.top - 1 && bottom <= place.top + place.height + 1);
      for (int x = 0; x < in_front.pixels.width(); ++x) {
        ASSERT_EQ(in_front.pixels.at(x, 0).a, 255);
        ASSERT_EQ(in_front.pixels.at(x, in_front.pixels.height() - 1).a, 255);
      }
    }
  }
  EXPECT_GT(found, 20) << "somebody is to be found";
}
INSTANTIATE_TEST_SUITE_P(OfEveryLayout, PassersInOddPictures,
                         testing::Values(PixelLayout::rgb8, PixelLayout::rgba8, PixelLayout::bgra8, PixelLayout::grey8,
                                         PixelLayout::yuyv, PixelLayout::uyvy, PixelLayout::nv12, PixelLayout::i420,
                                         PixelLayout::i422, PixelLayout::i444),
                         [](const auto& layout) { return std::string(name_of(layout.param)); });

}  // namespace
}  // namespace kasumi

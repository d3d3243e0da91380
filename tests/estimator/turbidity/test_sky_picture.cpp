#include <gtest/gtest.h>

#include "estimator/turbidity/sky_picture.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

TEST(SkyPicture, PicksPixelsAndKnowsWhereTheyAre) {
  const Camera camera = test::upward_camera(1000);
  Image<Rgb8> image(1000, 1000);
  for (int y = 0; y < 1000; ++y)
    for (int x = 0; x < 1000; ++x)
      image.at(x, y) = {static_cast<std::uint8_t>(x % 256), static_cast<std::uint8_t>(y % 256), 7};
  const auto picture = must(sky_picture(view_of(image), camera));
  EXPECT_LE(picture->encoded.width(), kSkyPictureSide);
  EXPECT_GT(picture->encoded.width(), kSkyPictureSide / 2);
  for (const auto& [x, y] :
       {std::pair{0, 0}, {17, 211}, {picture->encoded.width() - 1, picture->encoded.height() - 1}}) {
    const glm::ivec2 pixel(picture->camera_pixel(x, y));
    ASSERT_TRUE(image.contains(pixel.x, pixel.y));
    EXPECT_FLOAT_EQ(picture->encoded.at(x, y).r * 255.0f, image.at(pixel.x, pixel.y).r);
    EXPECT_FLOAT_EQ(picture->encoded.at(x, y).g * 255.0f, image.at(pixel.x, pixel.y).g);
  }
  EXPECT_DOUBLE_EQ(picture->quantum, 1.0 / 255.0);
}

TEST(SkyPicture, KeepsASmallPictureWhole) {
  const Camera camera = test::upward_camera(101);
  const auto picture = must(sky_picture(Image<glm::vec3>(101, 101, glm::vec3{0.25f}), 1.0 / 65535, camera));
  EXPECT_EQ(picture->encoded.width(), 101);
  EXPECT_EQ(picture->camera_pixel(3, 5), (glm::dvec2{3, 5}));
}

TEST(SkyPicture, RefusesASizeThatIsNotTheCameras) {
  const auto picture = sky_picture(Image<glm::vec3>(320, 240), 0.0, test::upward_camera(500));
  ASSERT_FALSE(picture);
  EXPECT_EQ(picture.error().kind, FaultKind::bad_input);
  EXPECT_NE(picture.error().message.find("320 x 240"), std::string::npos);
  EXPECT_NE(picture.error().message.find("500 x 500"), std::string::npos);
}

}  // namespace
}  // namespace kasumi

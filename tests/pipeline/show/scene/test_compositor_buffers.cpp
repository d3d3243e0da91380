// The scene camera's frames on the GPU: copied, or read in the driver's own buffers.
#include "tests/pipeline/show/scene/compositors.hpp"

namespace kasumi {
namespace {

TEST_F(Compositors, ReadALentFrameInPlaceAndDrawTheSameBits) {
  const Buffer buffer(PixelLayout::nv12, installation_.scene.yuv_encoding, kWidth, kHeight, 0, 1);
  bool returned = false;
  Compositor importing = make(with_test_images()), copying = make();
  Frame frame = lent(buffer, returned);
  const auto in_place = drawn(importing, frame), copy = drawn(copying, copied(frame));
  EXPECT_EQ(in_place.elements(), copy.elements());
  EXPECT_EQ(importing.frames().imported, 1u);
  EXPECT_EQ(importing.frames().uploaded, 0u) << "copies";
  EXPECT_EQ(copying.frames().uploaded, 1u);
  EXPECT_GE(importing.layer().drawn(), 1u);
}

TEST_F(Compositors, KeepALentBufferUntilTheNextFrame) {
  const Buffer first(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  const Buffer second(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 2);
  bool first_returned = false, second_returned = false;
  Compositor compositor = make(with_test_images());
  drawn(compositor, lent(first, first_returned));
  EXPECT_FALSE(first_returned);
  drawn(compositor, lent(second, second_returned));
  EXPECT_TRUE(first_returned);
  EXPECT_FALSE(second_returned);
}

TEST_F(Compositors, ShowAPictureAgainWithoutKeepingTheDriversBuffer) {
  Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  bool returned = false;
  Compositor compositor = make(with_test_images());
  const auto before = drawn(compositor, lent(buffer, returned));
  EXPECT_EQ(drawn_again(compositor).elements(), before.elements());
  EXPECT_TRUE(returned) << "an unplugged camera comes back only when its buffers are released";
  buffer.fill(17);  // the driver may reuse it now
  EXPECT_EQ(drawn_again(compositor).elements(), before.elements());
  EXPECT_EQ(compositor.frames().uploaded, 1u) << "one copy, however often it is shown";
}

// A driver frees no memory that the GPU has imported: a camera that is gone for hours, or one that needs its memory
// again, must get it back at once.
TEST_F(Compositors, GiveTheBuffersOfACameraBackThatIsGone) {
  Buffer first(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  Buffer second(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 2);
  bool first_returned = false, second_returned = false;
  Compositor compositor = make(with_test_images());
  drawn(compositor, lent(first, first_returned));
  const auto before = drawn(compositor, lent(second, second_returned));
  EXPECT_EQ(calls_.destroyed, 0);
  EXPECT_TRUE(compositor.drop_camera_buffers());
  EXPECT_EQ(static_cast<std::size_t>(calls_.destroyed), calls_.made.size()) << "no image holds the driver's memory";
  EXPECT_TRUE(second_returned);
  second.fill(17);
  EXPECT_EQ(drawn_again(compositor).elements(), before.elements()) << "the last picture stays";
  EXPECT_TRUE(compositor.drop_camera_buffers()) << "nothing is left to give back";
  const auto after = drawn(compositor, lent(first, first_returned));
  EXPECT_NE(after.elements(), before.elements()) << "the camera is back";
  EXPECT_EQ(compositor.frames().imported, 3u);
}

TEST_F(Compositors, CopyWhatTheGpuCannotImport) {
  calls_.refused = {"*"};
  const Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  bool returned = false;
  Compositor compositor = make(with_test_images()), copying = make();
  const Frame frame = lent(buffer, returned);
  EXPECT_EQ(drawn(compositor, frame).elements(), drawn(copying, copied(frame)).elements());
  EXPECT_EQ(compositor.frames().uploaded, 1u);
  EXPECT_THAT(compositor.notes(), testing::Contains(testing::HasSubstr("copied")));
}

}  // namespace
}  // namespace kasumi

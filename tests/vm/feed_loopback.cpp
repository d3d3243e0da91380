// feed_loopback CAMERA_FOLDER DEVICE: plays one camera of a fixture into a v4l2loopback device in a loop, in real time.
// During a recorded outage nothing is written, so that the device's reader waits.
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/unique_fd.hpp"
#include "capture/fixture/replay_source.hpp"

namespace kasumi {

namespace {

Result<> begin(int device, const FrameMetadata& frame) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  auto& picture = format.fmt.pix;
  picture.width = static_cast<std::uint32_t>(frame.width);
  picture.height = static_cast<std::uint32_t>(frame.height);
  const auto& code = frame.format.code;
  picture.pixelformat = v4l2_fourcc(code[0], code[1], code[2], code[3]);
  picture.field = V4L2_FIELD_NONE;
  picture.bytesperline = frame.stride;
  picture.sizeimage = frame.bytes_used;
  picture.colorspace = V4L2_COLORSPACE_SRGB;
  const auto wanted = picture;
  if (ioctl(device, VIDIOC_S_FMT, &format) < 0)
    return fail(FaultKind::device, "the format {} {}x{}: {}", frame.format.text(), frame.width, frame.height,
                std::strerror(errno));
  if (picture.pixelformat != wanted.pixelformat || picture.width != wanted.width || picture.height != wanted.height)
    return fail(FaultKind::device, "the device does not accept {} {}x{}", frame.format.text(), frame.width,
                frame.height);
  // write() alone would work, but without STREAMON the device does not notice when its writer closes: it then is neither
  // camera nor sink and accepts no other writer.
  int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  if (ioctl(device, VIDIOC_STREAMON, &type) < 0)
    return fail(FaultKind::device, "VIDIOC_STREAMON: {}", std::strerror(errno));
  return {};
}

Result<> feed(const char* camera_folder, const char* device_path) {
  SystemClock clock;
  auto source = open_replay(camera_folder, clock, {.loop = true});
  if (!source) return fail(source.error());
  UniqueFd device(open(device_path, O_WRONLY | O_CLOEXEC));
  if (!device) return fail(FaultKind::device, "{}: {}", device_path, std::strerror(errno));
  for (bool begun = false;;) {
    const auto frame = (*source)->next(clock.now() + std::chrono::seconds{1});
    if (!frame && (frame.error().kind == FaultKind::timeout || frame.error().kind == FaultKind::disconnected)) continue;
    if (!frame) return fail(frame.error());
    if (!std::exchange(begun, true))
      if (const auto said = begin(device.value(), frame->metadata); !said) return said;
    const auto bytes = frame->payload.bytes;
    if (write(device.value(), bytes.data(), bytes.size()) < 0)
      return fail(FaultKind::device, "{}: {}", device_path, std::strerror(errno));
  }
}

}  // namespace

}  // namespace kasumi

int main(int count, char** arguments) {
  if (count != 3) {
    fmt::print(stderr, "usage: feed_loopback CAMERA_FOLDER DEVICE\n");
    return 2;
  }
  const auto fed = kasumi::feed(arguments[1], arguments[2]);
  fmt::print(stderr, "feed_loopback: {}\n", fed.error().message);
  return 1;
}

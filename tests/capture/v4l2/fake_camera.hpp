// A fake camera behind the boundary of system calls: behaves as the kernel's videobuf2 does, with false answers where a
// test asks for them. Its memory is on the heap, so that the address sanitizer detects reads after unmapping.
#pragma once

#include <linux/videodev2.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "capture/v4l2/v4l2_source.hpp"
#include "capture/v4l2/video_device.hpp"

namespace kasumi {

struct FakeMode {
  std::uint32_t code = 0;  // V4L2_PIX_FMT_*
  int width = 0;
  int height = 0;
  std::vector<v4l2_fract> intervals{{1, 30}};
  std::uint32_t padding = 0;  // bytes at the end of each row
};

struct FakeControl {
  std::int32_t least = 0, most = 0, step = 1, value = 0;
  std::set<std::int32_t> items{};  // of a menu control
};

// What a dequeued buffer contains.
struct FakeAnswer {
  std::uint32_t number = 0;  // of the frame, from the start of the stream
  v4l2_buffer buffer{};
  std::vector<v4l2_plane> planes{};  // one; buffer's fields are set from it when single-planar
};

class FakeCamera {
 public:
  FakeCamera(std::vector<FakeMode> modes, Clock& clock);
  ~FakeCamera();

  std::unique_ptr<VideoDevice> open();

  // The camera's properties; set before it is opened.
  bool multiplanar = false;
  bool keeps_orphans = true;  // allows freeing buffers that are still mapped
  std::string driver = "fake";
  bool shared = false;  // as v4l2loopback: fills the buffers in turn, even those in use
  bool exports = true;
  Duration interval = std::chrono::milliseconds(40);
  Duration latency{};  // from a frame's timestamp to when it can be dequeued
  std::uint32_t most_buffers = 32;
  v4l2_colorspace colour_space = V4L2_COLORSPACE_SRGB;
  v4l2_ycbcr_encoding ycbcr_encoding = V4L2_YCBCR_ENC_DEFAULT;
  v4l2_quantization quantization = V4L2_QUANTIZATION_DEFAULT;
  bool enumerates_sizes = true;
  std::map<std::uint32_t, FakeControl> controls;
  // The bytes of a frame, one vector for each memory plane; if empty, each byte is the frame's number.
  std::function<std::vector<std::vector<std::uint8_t>>(std::uint32_t number)> content;

  // Faults; may be set at any time from the test's thread.
  void refuse(unsigned long request, int error, int times = 1 << 30);        // times 0: none
  void tamper(std::function<void(FakeAnswer&)> change);                      // for each dequeued buffer
  void lie(std::function<void(unsigned long request, void* argument)> lie);  // after any other call
  void stop_filling(bool stopped);                                           // streams, but no frame arrives
  void fail_queue();  // vb2_queue_error: EIO until the stream is restarted
  void announce_source_change();
  void unplug();
  void plug_in();
  bool plugged_in() const;

  // Resources in use now, and calls made so far.
  int opened() const;      // devices
  int mapped() const;      // mappings
  bool allocated() const;  // buffers exist
  bool streaming() const;
  int with_driver() const;  // buffers queued
  std::vector<unsigned long> calls() const;

 private:
  friend class FakeVideoDevice;
  struct Memory {
    std::uint32_t length = 0;
    std::shared_ptr<std::vector<std::uint8_t>> bytes;
  };
  enum class State { idle, queued, done };
  struct Buffer {
    std::vector<Memory> planes;
    State state = State::idle;
    FakeAnswer answer{};
  };

  int control(const VideoDevice* caller, unsigned long request, void* argument);
  int dispatch(const VideoDevice* caller, unsigned long request, void* argument);
  int enumerate_format(v4l2_fmtdesc& entry) const;
  int enumerate_size(v4l2_frmsizeenum& entry) const;
  int enumerate_interval(v4l2_frmivalenum& entry) const;
  int set_format(v4l2_format& format);
  int request_buffers(const VideoDevice* caller, v4l2_requestbuffers& request);
  int query_buffer(v4l2_buffer& buffer);
  int export_buffer(v4l2_exportbuffer& request);
  int queue(v4l2_buffer& buffer);
  int dequeue(v4l2_buffer& buffer);
  int start_stream(bool on);
  int control_value(unsigned long request, void* argument);
  VideoEvents wait(Duration longest);
  std::span<const std::uint8_t> map(std::size_t length, std::int64_t offset, int& error);
  void unmap(std::span<const std::uint8_t> mapped);
  void close(const VideoDevice* caller);

  void fill_due();
  void fill(std::uint32_t number, Instant at);
  std::vector<std::uint32_t> plane_strides() const;
  std::vector<std::uint32_t> plane_sizes() const;
  const FakeMode* mode_of(std::uint32_t code, std::uint32_t width, std::uint32_t height) const;
  std::uint32_t type() const { return multiplanar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE; }

  const std::vector<FakeMode> modes_;
  Clock& clock_;
  mutable std::mutex mutex_;
  FakeMode now_;
  v4l2_fract per_frame_{1, 30};
  std::vector<Buffer> buffers_;
  std::vector<std::uint32_t> done_;
  const VideoDevice* owner_ = nullptr;
  std::set<const VideoDevice*> devices_;
  std::map<const std::uint8_t*, std::shared_ptr<std::vector<std::uint8_t>>> mappings_;
  bool streaming_ = false, failed_ = false, stopped_ = false, plugged_in_ = true, event_ = false, subscribed_ = false;
  Instant started_{};
  std::uint32_t next_number_ = 0;
  std::map<unsigned long, std::pair<int, int>> refusals_;
  std::function<void(FakeAnswer&)> change_;
  std::function<void(unsigned long, void*)> lie_;
  std::vector<unsigned long> calls_;
};

}  // namespace kasumi

#include <algorithm>
#include <span>

#include "capture/codec/jpeg.hpp"
#include "capture/frame.hpp"

namespace kasumi {

namespace {

PictureView view_in_place(const FrameMetadata& metadata, PixelLayout layout, YuvEncoding encoding,
                          const std::uint8_t* bytes) {
  PictureView view{layout, encoding, metadata.width, metadata.height, {}};
  std::size_t offset = 0;
  for (int plane = 0; plane < plane_count(layout); ++plane) {
    const std::size_t stride = stride_of_plane(layout, metadata.stride, plane);
    view.planes[static_cast<std::size_t>(plane)] = {bytes + offset, stride};
    offset += stride * static_cast<std::size_t>(plane_size(layout, metadata.width, metadata.height, plane).rows);
  }
  return view;
}

}  // namespace

Result<DecodedPicture> decode(const Frame& frame, YuvEncoding encoding) {
  const auto& metadata = frame.metadata;
  if (metadata.status != FrameStatus::good)
    return fail(FaultKind::bad_input, "the frame is {}", name_of(metadata.status));
  if (auto possible = check_geometry(metadata); !possible) return fail(possible.error());
  const std::size_t bytes = std::min<std::size_t>(frame.payload.bytes.size(), metadata.bytes_used);
  if (const auto needed = bytes_needed(metadata); bytes < needed)
    return fail(FaultKind::bad_input, "{} bytes: expected at least {} for {} {}x{} with stride {}", bytes, needed,
                metadata.format.text(), metadata.width, metadata.height, metadata.stride);

  DecodedPicture picture;
  if (const auto layout = layout_of(metadata.format)) {
    picture.view_ = view_in_place(metadata, *layout, encoding, frame.payload.bytes.data());
    picture.keep_ = frame.payload;
    return picture;
  }
  auto planes = decode_jpeg(frame.payload.bytes.first(bytes), metadata.width, metadata.height);
  if (!planes) return fail(planes.error());
  picture.view_ = planes->view;
  picture.keep_.holder = std::move(planes->samples);
  picture.jpeg_steps_ = std::make_shared<const JpegSteps>(planes->steps);
  return picture;
}

}  // namespace kasumi

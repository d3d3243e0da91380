#include "capture/recording_reader.hpp"

#include <algorithm>

#include "capture/fixture.hpp"
#include "capture/payload_cache.hpp"

namespace kasumi {
namespace {

Result<DecodedPicture> read_picture(PayloadCache& payloads, const IndexRow& row, const ReadingOptions& options) {
  auto payload = payloads.read(row.payload, row.metadata.bytes_used, false);
  if (!payload) return fail(payload.error());
  Frame frame{row.metadata, std::move(*payload)};
  frame.metadata.status = judge(row.metadata, frame.payload.bytes.size(), row.metadata.status == FrameStatus::flagged);
  auto picture = decode(frame, options.yuv_encoding);
  if (!picture) return picture;
  const int width = picture->view().width, height = picture->view().height;
  if ((options.width > 0 && width != options.width) || (options.height > 0 && height != options.height))
    return fail(FaultKind::bad_input, "{} x {}, expected {} x {}", width, height, options.width, options.height);
  return picture;
}

}  // namespace

Result<PicturesRead> for_each_picture(const std::filesystem::path& camera_folder, const ReadingOptions& options,
                                      const std::function<void(const PictureView&, const FrameMetadata&)>& use) {
  const auto rows = read_index(camera_folder);
  if (!rows) return fail(rows.error());
  const auto stretches = std::min(rows->size(), options.most ? static_cast<std::size_t>(*options.most) : rows->size());
  PayloadCache payloads(camera_folder);
  PicturesRead read;
  bool declined = false;
  std::size_t next_stretch = 0;
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const auto& row = (*rows)[i];
    const auto stretch = i * stretches / rows->size();
    if (stretch < next_stretch || row.disconnected) continue;
    if (options.wanted && !options.wanted(row.metadata)) {
      declined = true;
      continue;
    }
    const auto picture = read_picture(payloads, row, options);
    if (!picture) {
      ++read.damaged;
      continue;
    }
    next_stretch = stretch + 1;
    if (read.good++ == 0) read.first = row.metadata.utc;
    read.last = row.metadata.utc;
    use(picture->view(), row.metadata);
  }
  if (read.good == 0 && (read.damaged > 0 || !declined))
    return fail(FaultKind::bad_input, "{}: no picture of it can be read", camera_folder.string());
  return read;
}

}  // namespace kasumi

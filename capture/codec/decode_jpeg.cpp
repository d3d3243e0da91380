#include <array>
#include <optional>

#include "base/picture_files/jpeg_input.hpp"
#include "capture/codec/jpeg.hpp"

namespace kasumi {

namespace {

class JpegReader : JpegInput {
 public:
  Result<JpegPlanes> read(std::span<const std::uint8_t> bytes, int width, int height);

 private:
  static constexpr int kMaxRows = 4 * DCTSIZE;  // of a plane in one call; sampling factors go up to 4

  Result<PixelLayout> layout() const;
  std::optional<std::string_view> foreign();
  JpegSteps steps() const;
  void read_planes(const PictureView& view, std::uint8_t* samples);
  tl::unexpected<Fault> damaged() const { return fail(FaultKind::bad_input, "damaged JPEG: {}", errors_.message()); }
};

// ffmpeg writes 4:4:4 as 1x2,1x2,1x2 and 4:2:2 as 2x2,1x2,1x2, so only the ratios count.
Result<PixelLayout> JpegReader::layout() const {
  const auto* planes = info_.comp_info;
  if (info_.num_components == 1 && info_.jpeg_color_space == JCS_GRAYSCALE) return PixelLayout::grey8;
  if (info_.num_components != 3 || info_.jpeg_color_space != JCS_YCbCr)
    return fail(FaultKind::bad_input, "JPEG with {} components that are not YCbCr or grey", info_.num_components);
  const auto shares = [&](int horizontal, int vertical) {
    const auto half = [&](const jpeg_component_info& chroma) {
      return planes[0].h_samp_factor == horizontal * chroma.h_samp_factor &&
             planes[0].v_samp_factor == vertical * chroma.v_samp_factor;
    };
    return half(planes[1]) && half(planes[2]);
  };
  if (shares(2, 2)) return PixelLayout::i420;
  if (shares(2, 1)) return PixelLayout::i422;
  if (shares(1, 1)) return PixelLayout::i444;
  return fail(FaultKind::bad_input, "JPEG with sampling {}x{},{}x{},{}x{}: expected 4:2:0, 4:2:2 or 4:4:4",
              planes[0].h_samp_factor, planes[0].v_samp_factor, planes[1].h_samp_factor, planes[1].v_samp_factor,
              planes[2].h_samp_factor, planes[2].v_samp_factor);
}

std::optional<std::string_view> JpegReader::foreign() {
  // Many scans in few bytes could take unlimited memory and time; cameras send a single scan.
  if (info_.progressive_mode || jpeg_has_multiple_scans(&info_))
    return "JPEG in several scans (progressive): expected baseline JPEG";
  if (info_.arith_code) return "arithmetic coded JPEG: expected Huffman codes";
  return std::nullopt;
}

// Of the first plane, and of the second: cameras quantise both colour differences alike.
JpegSteps JpegReader::steps() const {
  JpegSteps found;
  const auto take = [&](int component, std::array<std::uint16_t, 64>& steps) {
    const auto* table = info_.comp_info[component].quant_table;
    for (std::size_t i = 0; table && i < steps.size(); ++i) steps[i] = static_cast<std::uint16_t>(table->quantval[i]);
  };
  take(0, found.luma);
  take(info_.num_components > 1 ? 1 : 0, found.chroma);
  return found;
}

Result<JpegPlanes> JpegReader::read(std::span<const std::uint8_t> bytes, int width, int height) {
  if (!read_header(bytes)) return damaged();
  if (info_.image_width != static_cast<JDIMENSION>(width) || info_.image_height != static_cast<JDIMENSION>(height))
    return fail(FaultKind::bad_input, "JPEG size {}x{}: expected {}x{}", info_.image_width, info_.image_height, width,
                height);
  if (const auto reason = foreign()) return fail(FaultKind::bad_input, "{}", *reason);
  const auto found = layout();
  if (!found) return fail(found.error());

  JpegPlanes planes{{*found, YuvEncoding::bt601_full, width, height, {}}, nullptr, {}};
  if (!errors_.guard([&] {
        info_.raw_data_out = TRUE;
        info_.dct_method = JDCT_ISLOW;
        jpeg_start_decompress(&info_);
      }))
    return damaged();

  // libjpeg writes whole blocks, so planes are padded to them.
  std::array<std::size_t, 3> offsets{};
  std::size_t size = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(info_.num_components); ++i) {
    const auto& component = info_.comp_info[i];
    const auto stride = static_cast<std::size_t>(component.width_in_blocks) * DCTSIZE;
    const auto rows =
        static_cast<std::size_t>(info_.total_iMCU_rows) * static_cast<std::size_t>(component.v_samp_factor * DCTSIZE);
    planes.view.planes[i].stride = stride;
    offsets[i] = size;
    size += stride * rows;
  }
  auto samples = std::make_shared<std::vector<std::uint8_t>>(size);
  for (std::size_t i = 0; i < static_cast<std::size_t>(info_.num_components); ++i)
    planes.view.planes[i].data = samples->data() + offsets[i];
  if (!errors_.guard([&] { read_planes(planes.view, samples->data()); })) return damaged();
  planes.steps = steps();
  planes.samples = std::move(samples);
  return planes;
}

void JpegReader::read_planes(const PictureView& view, std::uint8_t* samples) {
  std::array<std::array<JSAMPROW, kMaxRows>, 3> rows{};
  std::array<JSAMPARRAY, 3> planes{rows[0].data(), rows[1].data(), rows[2].data()};
  for (JDIMENSION band = 0; info_.output_scanline < info_.output_height; ++band) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(info_.num_components); ++i) {
      const auto count = static_cast<std::size_t>(info_.comp_info[i].v_samp_factor * DCTSIZE);
      auto* first = samples + (view.planes[i].data - samples) + band * count * view.planes[i].stride;
      for (std::size_t row = 0; row < count; ++row) rows[i][row] = first + row * view.planes[i].stride;
    }
    jpeg_read_raw_data(&info_, planes.data(), static_cast<JDIMENSION>(info_.max_v_samp_factor * DCTSIZE));
  }
}

}  // namespace

Result<JpegPlanes> decode_jpeg(std::span<const std::uint8_t> bytes, int width, int height) {
  JpegReader reader;
  return reader.read(bytes, width, height);
}

}  // namespace kasumi

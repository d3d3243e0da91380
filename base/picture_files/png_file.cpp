#include <algorithm>
#include <bit>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <utility>

#include <libdeflate.h>
#include <png.h>

#include "base/c_ptr.hpp"
#include "base/picture_files/picture_file.hpp"

namespace kasumi {

namespace {

constexpr int kBestSpeed = 1;                                                  // of libdeflate's levels
constexpr std::size_t kLargestChunk = 1u << 30;                                // PNG's limit is 2^31 - 1
constexpr bool kBytesAreSwapped = std::endian::native == std::endian::little;  // PNG's 16 bits are big-endian

// libpng's errors, whose handler must not return.
class PngErrors {
 public:
  // Runs `calls`; false when libpng reported an error. Errors longjmp out of it, so it may hold nothing with a
  // destructor.
  template <class Calls>
  bool guard(png_structp png, Calls&& calls) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    calls();
    return true;
  }
  static void failed(png_structp png, png_const_charp text) {
    auto* errors = static_cast<PngErrors*>(png_get_error_ptr(png));
    std::snprintf(errors->message_, sizeof errors->message_, "%s", text);
    png_longjmp(png, 1);
  }
  static void warned(png_structp, png_const_charp) {}
  const char* message() const { return message_; }

 private:
  char message_[200] = "";
};

class PngReader {
 public:
  explicit PngReader(std::span<const std::uint8_t> file) : rest_(file) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &errors_, PngErrors::failed, PngErrors::warned);
    if (png_) info_ = png_create_info_struct(png_);
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }

  Result<DecodedFile> read() {
    if (!info_) return fail(FaultKind::io, "no memory for a PNG");
    if (!errors_.guard(png_, [this] { read_header(); })) return damaged();
    const std::size_t row_bytes = png_get_rowbytes(png_, info_), height = png_get_image_height(png_, info_);
    DecodedFile file{static_cast<int>(png_get_image_width(png_, info_)),
                     static_cast<int>(height),
                     png_get_channels(png_, info_),
                     png_get_bit_depth(png_, info_),
                     {}};
    file.samples.resize(row_bytes * height);
    rows_.resize(height);
    for (std::size_t y = 0; y < height; ++y) rows_[y] = file.samples.data() + y * row_bytes;
    if (!errors_.guard(png_, [this] {
          png_read_image(png_, rows_.data());
          png_read_end(png_, nullptr);
        }))
      return damaged();
    return file;
  }

 private:
  tl::unexpected<Fault> damaged() const { return fail(FaultKind::bad_input, "damaged PNG: {}", errors_.message()); }

  // Palettes and few bits become whole samples; a palette's or a colour's transparency becomes alpha.
  void read_header() {
    png_set_read_fn(png_, this, [](png_structp png, png_bytep to, png_size_t count) {
      auto& rest = static_cast<PngReader*>(png_get_io_ptr(png))->rest_;
      if (count > rest.size()) png_error(png, "the file ends too early");
      std::memcpy(to, rest.data(), count);
      rest = rest.subspan(count);
    });
    // The header's size is what the caller checked. A chunk before it, which libpng would skip, makes this no PNG.
    if (rest_.size() >= 16 && std::memcmp(rest_.data() + 12, "IHDR", 4) != 0) png_error(png_, "it begins with no size");
    // Remarks and profiles are skipped: libpng takes memory for all that such a chunk says it holds, up to 2 GB.
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_read_info(png_, info_);
    const auto colour = png_get_color_type(png_, info_);
    if (colour & PNG_COLOR_MASK_COLOR)
      png_set_expand(png_);
    else
      png_set_expand_gray_1_2_4_to_8(png_);
    if (colour == PNG_COLOR_TYPE_GRAY_ALPHA) png_set_gray_to_rgb(png_);
    if (kBytesAreSwapped) png_set_swap(png_);
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
  }

  std::span<const std::uint8_t> rest_;
  std::vector<png_bytep> rows_;
  PngErrors errors_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

struct PngSamples {
  int width, height, colour, bits;
  std::span<const std::uint8_t> rows;  // as PNG has them, without gaps
};

// Each row less the one above it, which its first byte says: quick, and below the others' size for cameras' pictures.
std::vector<std::uint8_t> less_the_row_above(const PngSamples& picture) {
  const auto height = static_cast<std::size_t>(picture.height);
  const std::size_t row_bytes = picture.rows.size() / height;
  std::vector<std::uint8_t> filtered((row_bytes + 1) * height);
  for (std::size_t y = 0; y < height; ++y) {
    const std::uint8_t* row = picture.rows.data() + y * row_bytes;
    std::uint8_t* to = filtered.data() + y * (row_bytes + 1);
    *to++ = y > 0 ? PNG_FILTER_VALUE_UP : PNG_FILTER_VALUE_NONE;
    if (y == 0)
      std::copy_n(row, row_bytes, to);
    else
      std::transform(row, row + row_bytes, row - row_bytes, to,
                     [](std::uint8_t here, std::uint8_t above) { return static_cast<std::uint8_t>(here - above); });
  }
  return filtered;
}

// As zlib compresses; empty: no memory.
std::vector<std::uint8_t> compressed(std::span<const std::uint8_t> bytes) {
  const CPtr<libdeflate_compressor, libdeflate_free_compressor> compressor(libdeflate_alloc_compressor(kBestSpeed));
  if (!compressor) return {};
  std::vector<std::uint8_t> made(libdeflate_zlib_compress_bound(compressor.get(), bytes.size()));
  made.resize(libdeflate_zlib_compress(compressor.get(), bytes.data(), bytes.size(), made.data(), made.size()));
  return made;
}

// libpng writes the chunks, libdeflate compresses the samples: in half of the time that libpng takes for it by zlib.
class PngWriter {
 public:
  PngWriter() {
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, &errors_, PngErrors::failed, PngErrors::warned);
    if (png_) info_ = png_create_info_struct(png_);
  }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }

  Result<std::vector<std::uint8_t>> write(const PngSamples& picture, const PngChunks& marks) {
    if (picture.width < 1 || picture.height < 1) return fail(FaultKind::bad_input, "a picture without pixels");
    const auto samples = compressed(less_the_row_above(picture));
    if (samples.empty()) return fail(FaultKind::io, "the picture cannot be encoded as PNG: no memory");
    if (!info_ || !errors_.guard(png_, [&] { write_chunks(picture, marks, samples); }))
      return fail(FaultKind::io, "the picture cannot be encoded as PNG: {}", errors_.message());
    return std::move(bytes_);
  }

 private:
  void write_chunks(const PngSamples& picture, const PngChunks& marks, std::span<const std::uint8_t> samples) {
    constexpr png_byte kSamples[] = "IDAT", kEnd[] = "IEND";
    png_set_write_fn(png_, &bytes_, append, nullptr);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(picture.width), static_cast<png_uint_32>(picture.height),
                 picture.bits, picture.colour, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (marks.srgb) png_set_sRGB(png_, info_, PNG_sRGB_INTENT_RELATIVE);
    if (!marks.exif.empty())
      png_set_eXIf_1(png_, info_, static_cast<png_uint_32>(marks.exif.size()),
                     const_cast<png_bytep>(marks.exif.data()));
    png_write_info(png_, info_);
    for (; !samples.empty(); samples = samples.subspan(std::min(samples.size(), kLargestChunk)))
      png_write_chunk(png_, kSamples, samples.data(), std::min(samples.size(), kLargestChunk));
    png_write_chunk(png_, kEnd, nullptr, 0);
  }
  static void append(png_structp png, png_bytep from, png_size_t count) {
    auto& bytes = *static_cast<std::vector<std::uint8_t>*>(png_get_io_ptr(png));
    bool kept = true;
    try {
      bytes.insert(bytes.end(), from, from + count);
    } catch (const std::bad_alloc&) {
      kept = false;
    }
    if (!kept) png_error(png, "no memory");  // no exception passes through libpng, which is C
  }

  std::vector<std::uint8_t> bytes_;
  PngErrors errors_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

template <class T>
Result<std::vector<std::uint8_t>> encode_samples(const Image<T>& image, int colour, int bits,
                                                 const PngChunks& marks = {}) {
  const void* first = image.elements().data();
  PngSamples samples{image.width(),
                     image.height(),
                     colour,
                     bits,
                     {static_cast<const std::uint8_t*>(first), image.elements().size() * sizeof(T)}};
  std::vector<std::uint8_t> swapped;
  if (bits == 16 && kBytesAreSwapped) {
    swapped.assign(samples.rows.begin(), samples.rows.end());
    for (std::size_t i = 0; i + 1 < swapped.size(); i += 2) std::swap(swapped[i], swapped[i + 1]);
    samples.rows = swapped;
  }
  PngWriter writer;
  return writer.write(samples, marks);
}

}  // namespace

Result<DecodedFile> decode_png(std::span<const std::uint8_t> file) {
  PngReader reader(file);
  return reader.read();
}

Result<std::vector<std::uint8_t>> encode_png(const Image<Rgb8>& picture, const PngChunks& marks) {
  return encode_samples(picture, PNG_COLOR_TYPE_RGB, 8, marks);
}

Result<std::vector<std::uint8_t>> encode_png(const Image<glm::u16vec3>& picture, const PngChunks& marks) {
  return encode_samples(picture, PNG_COLOR_TYPE_RGB, 16, marks);
}

Result<std::vector<std::uint8_t>> encode_png(const Image<glm::u8vec4>& picture) {
  return encode_samples(picture, PNG_COLOR_TYPE_RGB_ALPHA, 8);
}

Result<std::vector<std::uint8_t>> encode_png(const Image<std::uint8_t>& grey) {
  return encode_samples(grey, PNG_COLOR_TYPE_GRAY, 8);
}

}  // namespace kasumi

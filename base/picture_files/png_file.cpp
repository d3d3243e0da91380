#include <bit>
#include <csetjmp>
#include <cstdio>
#include <cstring>

#include <png.h>

#include "base/picture_files/picture_file.hpp"

namespace kasumi {

namespace {

constexpr int kBestSpeed = 1, kRunLengths = 3;                                 // zlib's Z_BEST_SPEED, Z_RLE
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
  const std::uint8_t* first;
  std::size_t row_bytes;
};

class PngWriter {
 public:
  PngWriter() {
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, &errors_, PngErrors::failed, PngErrors::warned);
    if (png_) info_ = png_create_info_struct(png_);
  }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }

  Result<std::vector<std::uint8_t>> write(const PngSamples& picture, const PictureMarks& marks) {
    if (picture.width < 1 || picture.height < 1) return fail(FaultKind::bad_input, "a picture without pixels");
    if (!info_ || !errors_.guard(png_, [&] { write_all(picture, marks); }))
      return fail(FaultKind::io, "the picture cannot be encoded as PNG: {}", errors_.message());
    return std::move(bytes_);
  }

 private:
  void write_all(const PngSamples& picture, const PictureMarks& marks) {
    png_set_write_fn(png_, &bytes_, append, nullptr);
    png_set_filter(png_, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_set_compression_level(png_, kBestSpeed);
    png_set_compression_strategy(png_, kRunLengths);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(picture.width), static_cast<png_uint_32>(picture.height),
                 picture.bits, picture.colour, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (marks.srgb) png_set_sRGB(png_, info_, PNG_sRGB_INTENT_RELATIVE);
    if (!marks.exif.empty())
      png_set_eXIf_1(png_, info_, static_cast<png_uint_32>(marks.exif.size()),
                     const_cast<png_bytep>(marks.exif.data()));
    png_write_info(png_, info_);
    if (picture.bits == 16 && kBytesAreSwapped) png_set_swap(png_);
    for (int y = 0; y < picture.height; ++y)
      png_write_row(png_, picture.first + static_cast<std::size_t>(y) * picture.row_bytes);
    png_write_end(png_, info_);
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
                                                 const PictureMarks& marks = {}) {
  PngWriter writer;
  const void* first = image.elements().data();
  return writer.write({image.width(), image.height(), colour, bits, static_cast<const std::uint8_t*>(first),
                       static_cast<std::size_t>(image.width()) * sizeof(T)},
                      marks);
}

}  // namespace

Result<DecodedFile> decode_png(std::span<const std::uint8_t> file) {
  PngReader reader(file);
  return reader.read();
}

Result<std::vector<std::uint8_t>> encode_png(const Image<Rgb8>& picture, const PictureMarks& marks) {
  return encode_samples(picture, PNG_COLOR_TYPE_RGB, 8, marks);
}

Result<std::vector<std::uint8_t>> encode_png(const Image<glm::u16vec3>& picture, const PictureMarks& marks) {
  return encode_samples(picture, PNG_COLOR_TYPE_RGB, 16, marks);
}

Result<std::vector<std::uint8_t>> encode_png(const Image<glm::u8vec4>& picture) {
  return encode_samples(picture, PNG_COLOR_TYPE_RGB_ALPHA, 8);
}

Result<std::vector<std::uint8_t>> encode_png(const Image<std::uint8_t>& grey) {
  return encode_samples(grey, PNG_COLOR_TYPE_GRAY, 8);
}

}  // namespace kasumi

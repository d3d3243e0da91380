// PNG and JPEG files, decoded and encoded by libpng and libjpeg themselves: all that an appliance needs.
// Other formats: decode_picture.hpp; films: rare_files.hpp.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"

namespace kasumi {

// Rows from the top, without gaps between them.
struct DecodedFile {
  int width = 0, height = 0;
  int channels = 0;  // 1: grey; 3: R G B; 4: R G B A
  int bits = 8;      // of a sample: 8, or 16 in this machine's order of bytes
  std::vector<std::uint8_t> samples;
  bool whole = false;  // a JPEG of which no pixel was missing; false says nothing
};

// Values as they stand in the file: no gamma, no colour profile, no EXIF orientation. The caller has checked its size
// (base/picture_header.hpp). Errors (bad_input): damaged.
Result<DecodedFile> decode_png(std::span<const std::uint8_t> file);
// Missing parts of the picture become grey (capture's check_jpeg detects them). Errors: bad_input (no picture can be
// made of it), unsupported (four colours, as for print).
Result<DecodedFile> decode_jpeg_file(std::span<const std::uint8_t> file);

// What a PNG says beside its samples.
struct PngChunks {
  bool srgb = false;
  std::vector<std::uint8_t> exif;  // a TIFF of tags; empty: none
};

// Quickly rather than small: pictures are written while others wait. Errors: bad_input (no pixels), io.
Result<std::vector<std::uint8_t>> encode_png(const Image<Rgb8>& picture, const PngChunks& marks = {});
Result<std::vector<std::uint8_t>> encode_png(const Image<glm::u16vec3>& picture, const PngChunks& marks = {});
Result<std::vector<std::uint8_t>> encode_png(const Image<glm::u8vec4>& picture);
Result<std::vector<std::uint8_t>> encode_png(const Image<std::uint8_t>& grey);

}  // namespace kasumi

// Films, and the picture formats that the appliance does not need: TIFF, EXR, HDR, WebP, PNM, FITS, HEIF. OpenCV reads
// and writes them by some two hundred libraries, so they stand in a module beside the program, which is loaded when the
// first such file is asked for.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "base/picture_files/embedded_tags.hpp"
#include "base/result.hpp"

namespace kasumi {

class FilmDecoder {
 public:
  virtual ~FilmDecoder() = default;
  virtual bool read(cv::Mat& bgr) = 0;  // false: there are no more
  virtual double frames_per_second() const = 0;
};

class FilmEncoder {
 public:
  virtual ~FilmEncoder() = default;
  // Each: what is wrong; empty: nothing.
  virtual std::string write(const cv::Mat& rgb) = 0;
  virtual std::string finish() = 0;
};

// What the module does. It may throw cv::Exception.
class RareFiles {
 public:
  virtual ~RareFiles() = default;
  // Samples as they are, in OpenCV's order of channels; empty: not a picture that can be read.
  virtual cv::Mat decode(std::span<const std::uint8_t> file) const = 0;
  // An EXR's channels, "ViewLayer.Depth.Z", of all its parts but deep ones.
  virtual std::vector<std::string> exr_channels(std::span<const std::uint8_t> file) const = 0;
  // One of them as floats; empty: it cannot be read.
  virtual cv::Mat exr_channel(std::span<const std::uint8_t> file, const std::string& name) const = 0;
  virtual cv::Mat decode_heif(std::span<const std::uint8_t> file) const = 0;
  // What stands beside its samples.
  virtual EmbeddedTags heif_tags(std::span<const std::uint8_t> file) const = 0;
  // From an ICC profile's colours to sRGB (colour_profile.hpp). What is wrong; empty: nothing.
  virtual std::string to_srgb(cv::Mat& picture, std::span<const std::uint8_t> profile) const = 0;
  // sRGB's, as ICC profile.
  virtual std::vector<std::uint8_t> srgb_profile() const = 0;
  // By the name's ending, ".tiff"; false: not one that can be written.
  virtual bool encode(const std::string& ending, const cv::Mat& bgr, std::vector<std::uint8_t>& file) const = 0;
  // Null: cannot be opened.
  virtual std::unique_ptr<FilmDecoder> open_film(const std::string& file) const = 0;
  // H.264 where available, else MPEG-4; of even size. Null: neither.
  virtual std::unique_ptr<FilmEncoder> make_film(const std::string& file, double frames_per_second,
                                                 cv::Size size) const = 0;
};

// Loads the module at the first call: from where the program lies, or from ../lib/kasumi as installed. Any thread may
// call it. Errors: unsupported (it is not there, or a library that it needs is not).
Result<const RareFiles*> rare_files();

}  // namespace kasumi

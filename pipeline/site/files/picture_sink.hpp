// Where finished pictures go: a folder of PNGs or one film.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"

namespace kasumi {

Result<> write_png(const std::filesystem::path& path, const Image<Rgb8>& picture);
// Grey, as a mask that any paint program edits.
Result<> write_png(const std::filesystem::path& path, const Image<std::uint8_t>& grey);

class PictureSink {
 public:
  virtual ~PictureSink() = default;
  Result<> put(const Image<Rgb8>& picture) { return put(pictures_++, picture); }
  // The same for several threads, which number the pictures from 0: at_once() of them at a time.
  virtual Result<> put(std::size_t number, const Image<Rgb8>& picture) = 0;
  virtual std::size_t at_once() const = 0;
  // The film appears under its name only after this.
  virtual Result<> finish() = 0;

 private:
  std::size_t pictures_ = 0;
};

// frame-000000.png, frame-000001.png, ... in a folder, which is made; pictures of an earlier run are removed.
Result<std::unique_ptr<PictureSink>> open_picture_folder(const std::filesystem::path& folder);
// H.264 where this machine's FFmpeg offers it, else MPEG-4; the film is written under a temporary name and renamed.
Result<std::unique_ptr<PictureSink>> open_film(const std::filesystem::path& file, double frames_per_second);

}  // namespace kasumi

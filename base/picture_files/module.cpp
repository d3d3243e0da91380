// The module itself: OpenCV's pictures and films, and others'.
#include <cstdlib>

#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "base/fits_header.hpp"
#include "base/picture_files/colour_profile.hpp"
#include "base/picture_files/exr_channels.hpp"
#include "base/picture_files/film_encoder.hpp"
#include "base/picture_files/fits_picture.hpp"
#include "base/picture_files/heif_picture.hpp"
#include "base/picture_files/rare_files.hpp"
#include "base/picture_files/silenced_errors.hpp"

namespace kasumi {

namespace {

class OpenCvFilmDecoder final : public FilmDecoder {
 public:
  explicit OpenCvFilmDecoder(const std::string& file) { capture_.open(file, cv::CAP_FFMPEG); }
  bool is_open() const { return capture_.isOpened(); }
  bool read(cv::Mat& bgr) override { return capture_.read(bgr); }
  double frames_per_second() const override { return capture_.get(cv::CAP_PROP_FPS); }

 private:
  cv::VideoCapture capture_;
};

template <class T, class Base, class... Arguments>
std::unique_ptr<Base> opened(const Arguments&... arguments) {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // callers report errors themselves
  auto made = std::make_unique<T>(arguments...);
  if (!made->is_open()) return nullptr;
  return made;
}

class OpenCvFiles final : public RareFiles {
 public:
  cv::Mat decode(std::span<const std::uint8_t> file) const override {
    if (is_fits(file)) return read_fits(file);
    // OpenCV only reads from it.
    const cv::Mat bytes(1, static_cast<int>(file.size()), CV_8UC1, const_cast<std::uint8_t*>(file.data()));
    const SilencedErrors silenced;
    cv::Mat picture = cv::imdecode(bytes, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
    // OpenCV 4.6 gives a PAM's channels as the file has them, R first.
    if (file.size() > 2 && file[0] == 'P' && file[1] == '7' && picture.channels() >= 3)
      cv::cvtColor(picture, picture, picture.channels() == 3 ? cv::COLOR_RGB2BGR : cv::COLOR_RGBA2BGRA);
    return picture;
  }
  std::vector<std::string> exr_channels(std::span<const std::uint8_t> file) const override {
    return names_of_exr_channels(file);
  }
  cv::Mat exr_channel(std::span<const std::uint8_t> file, const std::string& name) const override {
    return read_exr_channel(file, name);
  }
  cv::Mat decode_heif(std::span<const std::uint8_t> file) const override { return read_heif(file); }
  EmbeddedTags heif_tags(std::span<const std::uint8_t> file) const override { return read_heif_tags(file); }
  std::string to_srgb(cv::Mat& picture, std::span<const std::uint8_t> profile) const override {
    return profile_to_srgb(picture, profile);
  }
  std::vector<std::uint8_t> srgb_profile() const override { return profile_of_srgb(); }
  bool encode(const std::string& ending, const cv::Mat& bgr, std::vector<std::uint8_t>& file) const override {
    setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 0);  // OpenCV writes EXR only when this variable is set
    return cv::imencode(ending, bgr, file);
  }
  std::unique_ptr<FilmDecoder> open_film(const std::string& file) const override {
    return opened<OpenCvFilmDecoder, FilmDecoder>(file);
  }
  std::unique_ptr<FilmEncoder> make_film(const std::string& file, double frames_per_second,
                                         cv::Size size) const override {
    return encode_film(file, frames_per_second, size);
  }
};

}  // namespace

}  // namespace kasumi

extern "C" {
extern const char kasumi_rare_files_version[];
const char kasumi_rare_files_version[] = KASUMI_VERSION;

const kasumi::RareFiles* kasumi_rare_files() {
  static const kasumi::OpenCvFiles kFiles;
  return &kFiles;
}
}

#include "pipeline/files/picture_sink.hpp"

#include <system_error>

#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "base/files.hpp"
#include "base/unfinished_file.hpp"

namespace kasumi {

namespace {

cv::Mat to_bgr(const Image<Rgb8>& picture) {
  // OpenCV only reads from it.
  const cv::Mat rgb(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.elements().data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  return bgr;
}

class PictureFolder final : public PictureSink {
 public:
  explicit PictureFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}
  Result<> put(const Image<Rgb8>& picture) override {
    return write_png(folder_ / fmt::format("frame-{:06}.png", count_++), picture);
  }
  Result<> finish() override { return {}; }

 private:
  std::filesystem::path folder_;
  int count_ = 0;
};

class FilmWriter final : public PictureSink {
 public:
  FilmWriter(std::filesystem::path file, double frames_per_second)
      : file_(std::move(file)), unfinished_(unfinished_name(file_)), frames_per_second_(frames_per_second) {}
  ~FilmWriter() override {
    std::error_code ignored;
    writer_.release();
    std::filesystem::remove(unfinished_, ignored);
  }

  Result<> put(const Image<Rgb8>& picture) override {
    // Both codecs require even sizes.
    const cv::Mat bgr = to_bgr(picture)(cv::Rect(0, 0, picture.width() & ~1, picture.height() & ~1));
    if (!writer_.isOpened()) {
      size_ = bgr.size();
      for (const int codec : {cv::VideoWriter::fourcc('a', 'v', 'c', '1'), cv::VideoWriter::fourcc('m', 'p', '4', 'v')})
        if (writer_.open(unfinished_.string(), cv::CAP_FFMPEG, codec, frames_per_second_, size_)) break;
      if (!writer_.isOpened())
        return fail(FaultKind::io, "{}: cannot be written as a film by this machine's OpenCV ({}x{} pixels)",
                    file_.string(), size_.width, size_.height);
    }
    if (bgr.size() != size_)
      return fail(FaultKind::bad_input, "{}: the pictures of a film must have one size", file_.string());
    writer_.write(bgr);
    return {};
  }

  Result<> finish() override {
    if (!writer_.isOpened())
      return fail(FaultKind::bad_input, "{}: no pictures, so no film was written", file_.string());
    writer_.release();
    return finish_file(unfinished_, file_);
  }

 private:
  std::filesystem::path file_, unfinished_;
  double frames_per_second_;
  cv::VideoWriter writer_;
  cv::Size size_;
};

Result<> make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(FaultKind::io, "{}: cannot be made: {}", folder.string(), error.message());
  return {};
}

}  // namespace

Result<> write_png(const std::filesystem::path& path, const Image<Rgb8>& picture) {
  std::vector<std::uint8_t> bytes;
  if (picture.empty() || !cv::imencode(".png", to_bgr(picture), bytes))
    return fail(FaultKind::io, "{}: the picture cannot be encoded", path.string());
  return write_file(path, bytes);
}

Result<> write_png(const std::filesystem::path& path, const Image<std::uint8_t>& grey) {
  const cv::Mat view(grey.height(), grey.width(), CV_8UC1, const_cast<std::uint8_t*>(grey.elements().data()));
  std::vector<std::uint8_t> bytes;
  if (grey.empty() || !cv::imencode(".png", view, bytes))
    return fail(FaultKind::io, "{}: the picture cannot be encoded", path.string());
  return write_file(path, bytes);
}

Result<std::unique_ptr<PictureSink>> open_picture_folder(const std::filesystem::path& folder) {
  if (auto made = make_folder(folder); !made) return fail(made.error());
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const auto name = entry.path().filename().string();
    if (name.starts_with("frame-") && name.ends_with(".png")) std::filesystem::remove(entry.path(), error);
  }
  return std::make_unique<PictureFolder>(folder);
}

Result<std::unique_ptr<PictureSink>> open_film(const std::filesystem::path& file, double frames_per_second) {
  if (file.has_parent_path())
    if (auto made = make_folder(file.parent_path()); !made) return fail(made.error());
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // a missing codec is reported by us
  return std::make_unique<FilmWriter>(file, frames_per_second);
}

}  // namespace kasumi

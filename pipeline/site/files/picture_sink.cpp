#include "pipeline/site/files/picture_sink.hpp"

#include <system_error>

#include <opencv2/core.hpp>

#include "base/files.hpp"
#include "base/picture_files/picture_file.hpp"
#include "base/picture_files/rare_files.hpp"
#include "base/unfinished_file.hpp"

namespace kasumi {

namespace {

class PictureFolder final : public PictureSink {
 public:
  explicit PictureFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}
  Result<> put(std::size_t number, const Image<Rgb8>& picture) override {
    return write_png(folder_ / fmt::format("frame-{:06}.png", number), picture);
  }
  std::size_t at_once() const override { return 2; }  // one is compressed while another one goes through to the disk
  Result<> finish() override { return {}; }

 private:
  std::filesystem::path folder_;
};

class FilmWriter final : public PictureSink {
 public:
  FilmWriter(const RareFiles& files, std::filesystem::path file, double frames_per_second)
      : files_(files),
        file_(std::move(file)),
        unfinished_(unfinished_name(file_)),
        frames_per_second_(frames_per_second) {}
  ~FilmWriter() override {
    std::error_code ignored;
    encoder_.reset();
    std::filesystem::remove(unfinished_, ignored);
  }

  Result<> put(std::size_t, const Image<Rgb8>& picture) override {
    // It only reads from it. Both codecs require even sizes.
    const cv::Mat rgb =
        cv::Mat(picture.height(), picture.width(), CV_8UC3, const_cast<Rgb8*>(picture.elements().data()))(
            cv::Rect(0, 0, picture.width() & ~1, picture.height() & ~1));
    if (!encoder_) {
      size_ = rgb.size();
      encoder_ = files_.make_film(unfinished_.string(), frames_per_second_, size_);
      if (!encoder_)
        return fail(FaultKind::io, "{}: cannot be written as a film by this machine's FFmpeg ({}x{} pixels)",
                    file_.string(), size_.width, size_.height);
    }
    if (rgb.size() != size_)
      return fail(FaultKind::bad_input, "{}: the pictures of a film must have one size", file_.string());
    return said(encoder_->write(rgb));
  }

  std::size_t at_once() const override { return 1; }

  Result<> finish() override {
    if (!encoder_) return fail(FaultKind::bad_input, "{}: no pictures, so no film was written", file_.string());
    auto finished = said(encoder_->finish());
    encoder_.reset();
    if (!finished) return finished;
    return finish_file(unfinished_, file_);
  }

 private:
  Result<> said(const std::string& wrong) const {
    if (wrong.empty()) return {};
    return fail(FaultKind::io, "{}: writing failed: {}", file_.string(), wrong);
  }

  const RareFiles& files_;
  std::filesystem::path file_, unfinished_;
  double frames_per_second_;
  std::unique_ptr<FilmEncoder> encoder_;  // from the first picture on
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
  const auto bytes = encode_png(picture);
  if (!bytes) return fail(FaultKind::io, "{}: {}", path.string(), bytes.error().message);
  return write_file(path, *bytes);
}

Result<> write_png(const std::filesystem::path& path, const Image<std::uint8_t>& grey) {
  const auto bytes = encode_png(grey);
  if (!bytes) return fail(FaultKind::io, "{}: {}", path.string(), bytes.error().message);
  return write_file(path, *bytes);
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
  const auto files = rare_files();
  if (!files) return fail(files.error().kind, "{}: {}", file.string(), files.error().message);
  return std::make_unique<FilmWriter>(**files, file, frames_per_second);
}

}  // namespace kasumi

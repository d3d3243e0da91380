#include "pipeline/site/files/picture_source.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <opencv2/imgproc.hpp>

#include "base/picture_files/rare_files.hpp"

namespace kasumi {

namespace {

std::string ending_of(const std::filesystem::path& path) {
  auto ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

bool is_film(const std::filesystem::path& path) {
  static const std::set<std::string> kFilms{".mp4", ".mov", ".mkv", ".avi", ".webm", ".m4v"};
  return kFilms.count(ending_of(path)) > 0;
}

class PictureFiles final : public PictureSource {
 public:
  PictureFiles(std::vector<std::filesystem::path> files, bool is_sequence, bool allow_damaged)
      : files_(std::move(files)), is_sequence_(is_sequence), allow_damaged_(allow_damaged) {}
  Result<std::optional<NamedPicture>> next() override {
    if (at_ == files_.size()) return std::nullopt;
    const auto& file = files_[at_++];
    NamedPicture picture{file.string(), file.stem().string(), {}, {}};
    auto photograph = read_photograph(file, allow_damaged_ ? &picture.damage : nullptr);
    if (!photograph) return fail(photograph.error());
    picture.photograph = std::move(*photograph);
    return picture;
  }
  bool is_sequence() const override { return is_sequence_; }

 private:
  std::vector<std::filesystem::path> files_;
  bool is_sequence_, allow_damaged_;
  std::size_t at_ = 0;
};

class FilmReader final : public PictureSource {
 public:
  FilmReader(std::filesystem::path file, std::unique_ptr<FilmDecoder> decoder)
      : file_(std::move(file)), decoder_(std::move(decoder)) {}
  Result<std::optional<NamedPicture>> next() override {
    cv::Mat frame;
    try {
      if (!decoder_->read(frame)) {
        if (count_ == 0) return fail(FaultKind::bad_input, "{}: no picture can be read of this film", file_.string());
        return std::nullopt;
      }
    } catch (const cv::Exception& error) {
      return fail(FaultKind::bad_input, "{}: frame {}: cannot be read: {}", file_.string(), count_, error.err);
    }
    cv::Mat rgb;
    cv::cvtColor(frame, rgb, cv::COLOR_BGR2RGB);
    NamedPicture picture;
    picture.name = fmt::format("{}, frame {}", file_.string(), count_);
    picture.stem = fmt::format("{}.frame-{:06}", file_.stem().string(), count_++);
    picture.photograph.quantum = 1.0 / 255.0;
    picture.photograph.encoded = Image<glm::vec3>(rgb.cols, rgb.rows);
    cv::Mat target(rgb.rows, rgb.cols, CV_32FC3, picture.photograph.encoded.elements().data());
    rgb.convertTo(target, CV_32FC3, 1.0 / 255.0);
    return picture;
  }
  std::optional<double> frames_per_second() const override {
    const double found = decoder_->frames_per_second();
    return std::isfinite(found) && found > 0.0 ? std::optional(found) : std::nullopt;
  }
  bool is_sequence() const override { return true; }

 private:
  std::filesystem::path file_;
  std::unique_ptr<FilmDecoder> decoder_;
  int count_ = 0;
};

Result<std::unique_ptr<PictureSource>> open_film_to_read(const std::filesystem::path& path) {
  const auto files = rare_files();
  if (!files) return fail(files.error().kind, "{}: {}", path.string(), files.error().message);
  std::unique_ptr<FilmDecoder> decoder;
  try {
    decoder = (*files)->open_film(path.string());
  } catch (const cv::Exception&) {
  }
  if (!decoder)
    return fail(FaultKind::bad_input, "{}: cannot be read as a film by this machine's OpenCV and FFmpeg",
                path.string());
  return std::make_unique<FilmReader>(path, std::move(decoder));
}

Result<std::unique_ptr<PictureSource>> open_folder(const std::filesystem::path& path, bool allow_damaged) {
  auto files = pictures_in(path);
  if (files.empty()) return fail(FaultKind::bad_input, "{}: expected a folder with pictures in it", path.string());
  return std::make_unique<PictureFiles>(std::move(files), true, allow_damaged);
}

}  // namespace

bool is_picture_file(const std::filesystem::path& path) {
  static const std::set<std::string> kPictures{".png", ".jpg",  ".jpeg", ".tif", ".tiff", ".ppm",  ".pnm",  ".pam",
                                               ".exr", ".fits", ".fit",  ".fts", ".webp", ".heic", ".heif", ".avif"};
  return kPictures.count(ending_of(path)) > 0;
}

std::vector<std::filesystem::path> pictures_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    if (is_picture_file(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

Result<std::unique_ptr<PictureSource>> open_pictures(const std::vector<std::string>& names, bool allow_damaged) {
  std::error_code error;
  std::vector<std::filesystem::path> files(names.begin(), names.end());
  for (const auto& file : files) {
    const bool folder = std::filesystem::is_directory(file, error);
    if (!folder && !is_film(file)) continue;
    if (files.size() > 1)
      return fail(FaultKind::bad_input, "{}: expected no other picture with a film or a folder", file.string());
    return folder ? open_folder(file, allow_damaged) : open_film_to_read(file);
  }
  return std::make_unique<PictureFiles>(std::move(files), false, allow_damaged);
}

}  // namespace kasumi

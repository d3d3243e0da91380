#include "pipeline/site/files/light_file.hpp"

#include <opencv2/imgproc.hpp>

#include "base/files.hpp"
#include "base/picture_files/rare_files.hpp"

namespace kasumi {
namespace {

bool encode(const RareFiles& files, const std::string& extension, const cv::Mat& bgr,
            std::vector<std::uint8_t>& bytes) try {
  return files.encode(extension, bgr, bytes);
} catch (const cv::Exception&) {
  return false;
}

}  // namespace

bool is_light_file(const std::filesystem::path& file) {
  const auto extension = file.extension();
  return extension == ".exr" || extension == ".pfm" || extension == ".hdr" || extension == ".tif" ||
         extension == ".tiff";
}

Result<> write_light_file(const std::filesystem::path& file, const Image<glm::vec3>& light) {
  if (!is_light_file(file))
    return fail(FaultKind::bad_input, "{}: expected a name that ends in .exr, .pfm, .hdr or .tiff", file.string());
  if (light.empty()) return fail(FaultKind::bad_input, "{}: the picture is empty", file.string());
  const auto files = rare_files();
  if (!files) return fail(files.error().kind, "{}: {}", file.string(), files.error().message);
  // OpenCV only reads from it.
  const cv::Mat rgb(light.height(), light.width(), CV_32FC3, const_cast<glm::vec3*>(light.elements().data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  std::vector<std::uint8_t> bytes;
  if (encode(**files, file.extension().string(), bgr, bytes)) return write_file(file, bytes);
  auto substitute = file;
  substitute.replace_extension(".pfm");
  if (substitute == file || !encode(**files, ".pfm", bgr, bytes))
    return fail(FaultKind::unsupported, "{}: cannot be encoded by this machine's OpenCV", file.string());
  if (auto written = write_file(substitute, bytes); !written) return written;
  return fail(FaultKind::unsupported, "{}: not supported by this machine's OpenCV; wrote {} instead", file.string(),
              substitute.string());
}

}  // namespace kasumi

#include "calib/lens/import_lens.hpp"

#include "base/files.hpp"
#include "calib/lens/foreign_formats.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kLargestFile = 1 << 20;

// OCamCalib's file is numbers, and words behind #.
bool is_ocamcalib(const std::string& text) {
  bool numbers = false, start_of_line = true, comment = false;
  for (const char c : text) {
    if (start_of_line) comment = c == '#';
    start_of_line = c == '\n';
    if (comment) continue;
    if (std::string_view("0123456789+-.eE \t\r\n").find(c) == std::string_view::npos) return false;
    numbers = numbers || (c >= '0' && c <= '9');
  }
  return numbers;
}

Result<ForeignLens> read_foreign(const std::string& text, const ImportQuestions& questions) {
  if (!questions.camera.empty() && !is_colmap(text) && !is_kalibr(text))
    return fail(FaultKind::bad_input, "--import-camera {}: has no effect: the file is of one camera", questions.camera);
  if (is_agisoft(text)) return read_agisoft_lens(text);
  if (is_hugin(text)) return read_hugin_lens(text);
  if (is_colmap(text)) return read_colmap_lens(text, questions);
  return read_keyed_lens(text, questions);
}

}  // namespace

Result<ImportedLens> import_lens(const std::filesystem::path& path, const ImportRequest& options) {
  const auto name = path.string();
  const auto text = read_text_file(path);
  if (!text) return fail(text.error());
  if (text->size() > kLargestFile)
    return fail(FaultKind::bad_input, "{}: {} bytes, expected a calibration of at most {}", name, text->size(),
                kLargestFile);
  const auto largest = options.largest_angle.value_or(from_degrees(90.0));
  if (is_ocamcalib(*text)) {
    if (!options.camera.empty())
      return fail(FaultKind::bad_input, "--import-camera {}: has no effect: {} is of one camera", options.camera, name);
    if (options.model != "auto" && options.model != "scaramuzza")
      return fail(FaultKind::bad_input, "--model {}: expected scaramuzza, as {} is OCamCalib's", options.model, name);
    auto model = read_ocamcalib(path);
    if (!model) return fail(model.error());
    ImportedLens imported;
    imported.program = "OCamCalib";
    imported.width = model->width;
    imported.height = model->height;
    imported.lens.model = std::move(*model);
    imported.lens.largest_angle = largest;
    return imported;
  }
  const ImportQuestions questions{options.model, options.camera};
  const auto foreign = read_foreign(*text, questions);
  if (!foreign) {
    Problems named;
    std::string_view lines = foreign.error().message;
    for (std::size_t end = 0; !lines.empty(); lines.remove_prefix(std::min(lines.size(), end + 1))) {
      end = std::min(lines.find('\n'), lines.size());
      named.add("{}: {}", name, lines.substr(0, end));
    }
    return fail(named.fault());
  }
  const auto held = hold(*foreign, largest, options.model);
  if (!held) return fail(held.error().kind, "{}: {}", name, held.error().message);
  if (options.largest_angle && std::holds_alternative<PinholeParameters>(held->lens.model))
    return fail(FaultKind::bad_input, "--largest-angle-deg: {} is a pinhole, which has no such angle", name);
  ImportedLens imported;
  imported.lens = held->lens;
  imported.width = foreign->width;
  imported.height = foreign->height;
  imported.program = foreign->program;
  imported.foreign_model = foreign->model;
  imported.moved_px = held->moved_px;
  imported.rms_px = foreign->rms_px;
  return imported;
}

}  // namespace kasumi

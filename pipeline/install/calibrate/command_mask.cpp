#include <algorithm>
#include <cmath>

#include <CLI/CLI.hpp>

#include "base/utc_text.hpp"
#include "calib/calibration_file.hpp"
#include "calib/mask/scene_mask.hpp"
#include "calib/mask/sky_mask.hpp"
#include "calib/mask/sway_mask.hpp"
#include "pipeline/install/calibrate/calibrated_camera.hpp"
#include "pipeline/install/calibrate/command_calibrate.hpp"
#include "pipeline/install/calibrate/save_calibration.hpp"
#include "pipeline/install/calibration_report/plots.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "pipeline/site/files/picture_sink.hpp"

namespace kasumi {

namespace {

constexpr int kMaxMaskPictures = 80;
constexpr std::int64_t kMaxBytes = 200'000'000;  // of pictures kept for their median

struct MaskArguments {
  std::string fixture;
  std::string camera = "sky";
  std::string picture, strokes;
  std::vector<int> box;
  double margin_px = 2.0;
  double soft_px = 3.0;
  std::string serial;
  std::string out;
};

// Writes the mask next to the calibration file. An older mask is kept, since it may have been edited by hand.
Result<int> save(const MaskArguments& arguments, CalibrationStep step, const Image<std::uint8_t>& mask,
                 const Image<Rgb8>& drawing) {
  const auto file = beside(arguments.out, step.camera + "-free.png");
  step.mask = file.filename().string();
  const auto kept = keep_old(file);
  if (!kept) return fail(kept.error());
  if (auto written = write_png(file, mask); !written) return fail(written.error());
  fmt::print("written: {}: white is free, black is hidden; correct it in a paint program\n", file.string());
  if (*kept) fmt::print("the previous mask was kept as {}\n", (*kept)->string());
  return save_calibration(arguments.out, std::move(step), drawing);
}

CalibrationStep step_of(const MaskArguments& arguments, const std::string& camera, int width, int height) {
  CalibrationStep step;
  step.camera = camera;
  step.width = width;
  step.height = height;
  step.serial = arguments.serial;
  step.calibrated_utc = utc_text(std::chrono::floor<std::chrono::seconds>(SystemClock().utc()));
  return step;
}

// As many pictures as fit, spread over the recording.
struct RecordedPictures {
  std::vector<Image<Rgb8>> pictures;
  PicturesRead read;
  int most = 0;  // as many as fit into memory
};
Result<RecordedPictures> read_pictures(const Fixture& fixture, const Camera& camera) {
  RecordedPictures recorded;
  const std::int64_t each = 3 * std::int64_t{camera.width} * camera.height;
  const int most =
      static_cast<int>(std::clamp<std::int64_t>(kMaxBytes / std::max<std::int64_t>(1, each), 5, kMaxMaskPictures));
  auto read = for_each_picture(fixture, camera, {.most = most}, [&](const PictureView& view, const FrameMetadata&) {
    recorded.pictures.push_back(to_rgb(view));
  });
  if (!read) return fail(read.error());
  recorded.read = *read;
  recorded.most = most;
  return recorded;
}

Result<int> mask_sky(const MaskArguments& arguments) {
  const auto fixture = read_fixture(arguments.fixture);
  if (!fixture) return fail(fixture.error());
  const auto camera = calibrated_camera(*fixture, arguments.out, "sky");
  if (!camera) return fail(camera.error());
  const auto recorded = read_pictures(*fixture, *camera);
  if (!recorded) return fail(recorded.error());
  const auto& [pictures, read, most] = *recorded;
  const auto found = find_sky_mask(pictures, *camera, arguments.margin_px);
  if (!found) return fail(found.error().kind, "{}: {}", arguments.fixture, found.error().message);

  const double hours = to_seconds(read.last - read.first) / 3600.0;
  fmt::print("{} pictures over {:.1f} h, {} with enough light; {} damaged\n", read.good, hours, found->pictures,
             read.damaged);
  fmt::print("{:.1f} % of the sky is hidden; {:.1f} % was decided from its surroundings\n", 100.0 * found->hidden_share,
             100.0 * found->unsure_share);
  std::vector<std::string> remarks;
  if (found->pictures < 5 || hours < 2.0)
    remarks.push_back(
        "few pictures or hours: a cloud that stood still, or the sun, may have been taken for an obstruction");
  if (found->unsure_share > 0.1)
    remarks.push_back(
        "much of the picture is neither clearly sky nor clearly dark: check the plot and correct the mask in a paint "
        "program");
  for (const auto& remark : remarks) fmt::print("{}\n", remark);

  auto step = step_of(arguments, "sky", camera->width, camera->height);
  step.site = fixture->installation.site;
  step.measured.push_back({"mask",
                           step.calibrated_utc,
                           fmt::format("{} pictures of the recording {}, {} to {}", found->pictures, fixture->info.name,
                                       utc_text(read.first), utc_text(read.last)),
                           {{"hidden_percent", 100.0 * found->hidden_share},
                            {"unsure_percent", 100.0 * found->unsure_share},
                            {"margin_px", arguments.margin_px}},
                           remarks});
  const auto title = fmt::format("red: never sky, {:.1f} %; {} pictures", 100.0 * found->hidden_share, found->pictures);
  return save(arguments, std::move(step), found->mask, plot_mask(found->typical, found->mask, {}, title));
}

// Empty without --box.
std::optional<glm::ivec4> box_of(const MaskArguments& arguments, int width, int height, Problems& problems) {
  if (arguments.box.empty()) return std::nullopt;
  const auto& b = arguments.box;
  if (b[0] < 0 || b[1] < 0 || b[2] < 1 || b[3] < 1 || b[0] + b[2] > width || b[1] + b[3] > height)
    problems.add("--box {},{},{},{}: expected a rectangle X,Y,WIDTH,HEIGHT in the picture of {} x {}", b[0], b[1], b[2],
                 b[3], width, height);
  return glm::ivec4(b[0], b[1], b[2], b[3]);
}

Result<int> mask_swaying(const MaskArguments& arguments) {
  const auto fixture = read_fixture(arguments.fixture);
  if (!fixture) return fail(fixture.error());
  const auto camera = calibrated_camera(*fixture, arguments.out, "scene");
  if (!camera) return fail(camera.error());
  Problems problems;
  const auto box = box_of(arguments, camera->width, camera->height, problems);
  Image<Stroke> strokes;
  if (!arguments.strokes.empty()) {
    auto drawn = read_strokes(arguments.strokes, camera->width, camera->height);
    if (!drawn) problems.add("{}", drawn.error().message);
    if (drawn) strokes = std::move(*drawn);
  }
  if (!problems.empty()) return fail(problems.fault());
  const auto recorded = read_pictures(*fixture, *camera);
  if (!recorded) return fail(recorded.error());
  const auto& [pictures, read, most] = *recorded;
  if (static_cast<int>(pictures.size()) < kFewestSwayPictures)
    return fail(FaultKind::bad_input, "{}: {} good pictures of the scene camera, expected {} or more, of some minutes",
                arguments.fixture, pictures.size(), kFewestSwayPictures);
  auto found = find_sway_mask(pictures, camera->response, box);
  const double seconds = to_seconds(read.last - read.first);
  fmt::print("{} pictures over {:.0f} s; {} damaged\n", read.good, seconds, read.damaged);
  if (found.mask.empty()) {
    fmt::print("nothing sways before the camera: nothing is proposed, and nothing was written\n");
    return 0;
  }
  if (!strokes.empty()) {
    const auto still = find_scene_mask(found.typical, strokes, {.box = box, .soft_px = arguments.soft_px});
    if (!still) return fail(still.error().kind, "{}: {}", arguments.strokes, still.error().message);
    add_still(found, still->mask);
  }
  const auto share = fmt::format("{:.2f} % of the {} is covered at times, {:.2f} % in the mean over the time",
                                 100.0 * found.moving_share, box ? "box" : "picture", 100.0 * found.hidden_share);
  fmt::print("{}\n", share);
  std::vector<std::string> remarks;
  if (read.good < std::min(40, most) || seconds < 60.0)
    remarks.push_back(
        "few pictures or seconds: a gust may move the leaves further; where they were not seen, the building will be "
        "drawn over them");
  for (const auto& remark : remarks) fmt::print("{}\n", remark);

  auto step = step_of(arguments, "scene", camera->width, camera->height);
  step.site = fixture->installation.site;
  step.measured.push_back(
      {"mask",
       step.calibrated_utc,
       fmt::format("{} pictures of the recording {}, {} to {}", read.good, fixture->info.name, utc_text(read.first),
                   utc_text(read.last)),
       {{"moving_percent", 100.0 * found.moving_share}, {"hidden_percent", 100.0 * found.hidden_share}},
       remarks});
  return save(arguments, std::move(step), found.mask,
              plot_mask(found.typical, found.mask, strokes, "red: in front, by the share of the time; " + share));
}

Result<int> mask_scene(const MaskArguments& arguments) {
  const auto photograph = read_photograph(arguments.picture);
  if (!photograph) return fail(photograph.error());
  const auto picture = to_rgb8(*photograph);
  Problems problems;
  const auto strokes = read_strokes(arguments.strokes, picture.width(), picture.height());
  if (!strokes) problems.add("{}", strokes.error().message);
  MaskExtent options;
  options.soft_px = arguments.soft_px;
  options.box = box_of(arguments, picture.width(), picture.height(), problems);
  if (!problems.empty()) return fail(problems.fault());
  const auto found = find_scene_mask(picture, *strokes, options);
  if (!found) return fail(found.error().kind, "{}: {}", arguments.strokes, found.error().message);
  fmt::print("{:.1f} % of the {} is hidden\n", 100.0 * found->hidden_share, options.box ? "box" : "picture");

  auto step = step_of(arguments, "scene", picture.width(), picture.height());
  step.measured.push_back(
      {"mask",
       step.calibrated_utc,
       fmt::format("strokes of {} on {}", std::filesystem::path(arguments.strokes).filename().string(),
                   std::filesystem::path(arguments.picture).filename().string()),
       {{"hidden_percent", 100.0 * found->hidden_share}, {"soft_px", arguments.soft_px}},
       {}});
  const auto title =
      fmt::format("red: in front, {:.1f} %; pure red and green: the strokes", 100.0 * found->hidden_share);
  return save(arguments, std::move(step), found->mask, plot_mask(picture, found->mask, *strokes, title));
}

Result<int> calibrate(const MaskArguments& arguments) {
  Problems problems;
  const bool recording = !arguments.fixture.empty(), picture = !arguments.picture.empty();
  const bool strokes = !arguments.strokes.empty(), sky = recording && arguments.camera == "sky";
  if (recording ? picture : !picture && !strokes)
    problems.add(
        "expected either a recording (what is never sky; with --camera scene what sways before it) or --picture and "
        "--strokes (what stands in front of the building)");
  else if (picture != strokes && !recording)
    problems.add("--picture and --strokes: expected both");
  if (sky && strokes) problems.add("--strokes: expected with --picture, or with a recording and --camera scene");
  if (sky && !arguments.box.empty())
    problems.add("--box: expected with --picture and --strokes, or with a recording and --camera scene");
  if (!problems.empty()) return fail(problems.fault());
  if (!recording) return mask_scene(arguments);
  return sky ? mask_sky(arguments) : mask_swaying(arguments);
}

}  // namespace

void add_calibrate_mask(CLI::App& calibrate_command, Action& action) {
  auto* command = calibrate_command.add_subcommand(
      "mask",
      "What is never sky, from a recording of a day; what stands in front of the building, from a few strokes; which "
      "leaves sway before it, from a recording of some minutes");
  auto arguments = std::make_shared<MaskArguments>();
  auto& a = *arguments;
  command->add_option("fixture", a.fixture, "The sky camera: a recording of a day; the scene camera: of some minutes");
  command
      ->add_option("--camera", a.camera,
                   "Whose pictures of the recording are taken: sky, what is never sky; scene, what sways before the "
                   "building")
      ->check(CLI::IsMember({"sky", "scene"}))
      ->capture_default_str();
  command->add_option("--picture", a.picture, "The scene camera: one of its pictures");
  command->add_option(
      "--strokes", a.strokes,
      "A PNG of the same size with strokes, red on what stands in front, green or blue on what is free; or "
      "a TOML of lines (docs/calibration.md)");
  command
      ->add_option("--box", a.box,
                   "Where the building will appear: only this part is masked; default: the whole picture")
      ->type_name("X,Y,W,H")
      ->delimiter(',')
      ->expected(4);
  command->add_option("--margin-px", a.margin_px, "Sky: how far the mask extends beyond the visible edge")
      ->check(CLI::Range(0.0, 20.0))
      ->capture_default_str();
  command->add_option("--soft-px", a.soft_px, "Strokes: greatest width of soft edges (leaves, hair); 0: hard edges")
      ->check(CLI::Range(0.0, 20.0))
      ->capture_default_str();
  command->add_option("--serial", a.serial, "The camera's serial number or name, for the record");
  command->add_option("--out", a.out, "The calibration file; an older one, and an older mask, are kept as backups")
      ->required();
  command->callback([arguments, &action] { action = [arguments] { return calibrate(*arguments); }; });
}

}  // namespace kasumi

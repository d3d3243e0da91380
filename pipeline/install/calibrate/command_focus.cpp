#include <algorithm>
#include <cmath>

#include <CLI/CLI.hpp>

#include "base/utc_text.hpp"
#include "calib/calibration_file.hpp"
#include "calib/light/edge_fit.hpp"
#include "calib/light/stream_noise.hpp"
#include "pipeline/install/calibrate/calibrated_camera.hpp"
#include "pipeline/install/calibrate/command_calibrate.hpp"
#include "pipeline/install/calibrate/save_calibration.hpp"
#include "pipeline/install/calibration_report/plots.hpp"

namespace kasumi {

namespace {

constexpr int kMostFocusPictures = 16;

struct FocusArguments {
  std::string fixture;
  std::vector<int> box;
  std::string serial;
  std::string out;
};

struct FocusSeries {
  std::vector<Image<Rgb8>> pictures;
  double gain = 1.0;  // largest
  PicturesRead read;
};

Result<FocusSeries> read_still_scene(const Fixture& fixture, const Camera& camera) {
  FocusSeries scene;
  FrameSelection options;
  options.most = kMostFocusPictures;
  auto read = for_each_picture(fixture, camera, options, [&](const PictureView& view, const FrameMetadata& metadata) {
    scene.pictures.push_back(to_rgb(view));
    scene.gain = std::max(scene.gain, metadata.gain.value_or(1.0));
  });
  if (!read) return fail(read.error());
  scene.read = std::move(*read);
  return scene;
}

Image<float> mean_luma(const std::vector<Image<Rgb8>>& pictures) {
  Image<float> mean(pictures[0].width(), pictures[0].height());
  const float share = 1.0F / (255.0F * static_cast<float>(pictures.size()));
  for (const auto& picture : pictures)
    for (std::size_t i = 0; i < mean.elements().size(); ++i) {
      const Rgb8& pixel = picture.elements()[i];
      mean.elements()[i] += share * (0.299F * pixel.r + 0.587F * pixel.g + 0.114F * pixel.b);
    }
  return mean;
}

Image<Rgb8> plot_focus(const Image<Rgb8>& picture, const std::vector<DrawnEdge>& edges, const std::string& title) {
  Image<Stroke> strokes(picture.width(), picture.height(), Stroke::none);
  for (const auto& edge : edges) {
    const glm::dvec2 along{-std::sin(edge.normal.value), std::cos(edge.normal.value)};
    for (double t = -8.0; t <= 8.0; t += 0.5) {
      const glm::ivec2 at(glm::round(edge.pixel + t * along));
      if (strokes.contains(at.x, at.y)) strokes.at(at.x, at.y) = Stroke::free;
    }
  }
  return plot_mask(picture, Image<std::uint8_t>(picture.width(), picture.height(), 255), strokes, title);
}

Result<int> calibrate(const FocusArguments& arguments) {
  const auto fixture = read_fixture(arguments.fixture);
  if (!fixture) return fail(fixture.error());
  const auto camera = calibrated_camera(*fixture, arguments.out, "scene");
  if (!camera) return fail(camera.error());
  std::optional<glm::ivec4> box;
  if (!arguments.box.empty()) {
    const auto& b = arguments.box;
    box = glm::ivec4(b[0], b[1], b[0] + b[2], b[1] + b[3]);
    if (b[0] < 0 || b[1] < 0 || b[2] < 1 || b[3] < 1 || box->z > camera->width || box->w > camera->height)
      return fail(FaultKind::bad_input,
                  "--box {},{},{},{}: expected a rectangle X,Y,WIDTH,HEIGHT in the picture of {} x {}", b[0], b[1],
                  b[2], b[3], camera->width, camera->height);
  }
  const auto scene = read_still_scene(*fixture, *camera);
  if (!scene) return fail(scene.error());
  const auto edges = find_drawn_edges(mean_luma(scene->pictures), camera->response, box);
  const auto sharpness = sharpness_of(edges, camera->response, scene->read.jpeg_steps.get());
  if (!sharpness)
    return fail(FaultKind::bad_input,
                "{}: {} straight edges between even areas were found, expected 5 or more: film a printed checkerboard "
                "held slightly turned, as far away as the building if you can, or roofs and walls",
                arguments.fixture, edges.size());
  const auto noise = fit_stream_noise(scene->pictures, camera->response,
                                      {camera->white_balance, sharpness->sharpening, scene->read.jpeg_steps});
  fmt::print("point spread {:.2f} +- {:.2f} px, sharpening {:.2f} +- {:.2f}, from the {} sharpest of {} edges\n",
             sharpness->point_spread_px, sharpness->point_spread_sigma_px, sharpness->sharpening,
             sharpness->sharpening_sigma, sharpness->edges, edges.size());
  std::vector<std::string> remarks;
  if (noise)
    fmt::print(
        "noise: full scale is {:.0f} electrons at gain 1, read noise {:.1f} electrons; variances within {:.0f} %\n",
        noise->full_scale_electrons * scene->gain, noise->read_electrons, 100.0 * noise->misfit);
  else
    remarks.push_back(scene->pictures.size() < 3
                          ? "undetermined: noise: expected 3 pictures or more"
                          : "undetermined: noise: none above the rounding of the stream was found");
  if (scene->read.jpeg_steps)
    fmt::print("JPEG: brightness in steps of {} and more, colours of {} and more\n",
               *std::ranges::min_element(scene->read.jpeg_steps->luma),
               *std::ranges::min_element(scene->read.jpeg_steps->chroma));
  for (const auto& remark : remarks) fmt::print("{}\n", remark);

  CalibrationStep step;
  step.camera = "scene";
  step.width = camera->width;
  step.height = camera->height;
  step.serial = arguments.serial;
  const auto rounded = [](double value) { return std::round(100.0 * value) / 100.0; };
  step.focus = {std::min(rounded(sharpness->point_spread_px), 3.0), rounded(sharpness->sharpening),
                scene->read.jpeg_steps != nullptr};
  if (noise) step.noise = {std::round(noise->full_scale_electrons * scene->gain), rounded(noise->read_electrons)};
  const auto now = utc_text(std::chrono::floor<std::chrono::seconds>(SystemClock().utc()));
  step.calibrated_utc = now;
  Measured measured{"focus",
                    now,
                    fmt::format("{} pictures of the recording {}", scene->pictures.size(), fixture->info.name),
                    {{"point_spread_sigma_px", sharpness->point_spread_sigma_px},
                     {"sharpening_sigma", sharpness->sharpening_sigma},
                     {"edges", static_cast<double>(sharpness->edges)}},
                    std::move(remarks)};
  if (noise) measured.numbers.emplace_back("noise_misfit", noise->misfit);
  step.measured.push_back(std::move(measured));
  const auto title = fmt::format("point spread {:.2f} px, sharpening {:.2f}: the edges found",
                                 sharpness->point_spread_px, sharpness->sharpening);
  return save_calibration(arguments.out, std::move(step), plot_focus(scene->pictures.front(), edges, title));
}

}  // namespace

void add_calibrate_focus(CLI::App& calibrate_command, Action& action) {
  auto* command = calibrate_command.add_subcommand(
      "focus", "How the scene camera blurs, sharpens, codes and adds noise, from a recording of a still scene");
  auto arguments = std::make_shared<FocusArguments>();
  auto& a = *arguments;
  command
      ->add_option("fixture", a.fixture,
                   "A recording of a few pictures, camera and scene still, with straight edges between even areas")
      ->required();
  command->add_option("--box", a.box, "Look for edges in this rectangle only")
      ->type_name("X,Y,WIDTH,HEIGHT")
      ->delimiter(',')
      ->expected(4);
  command->add_option("--serial", a.serial, "The camera's serial number or name, for the record");
  command->add_option("--out", a.out, "The calibration file; an older one is kept as a backup")->required();
  command->callback([arguments, &action] { action = [arguments] { return calibrate(*arguments); }; });
}

}  // namespace kasumi

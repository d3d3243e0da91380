#include <filesystem>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "base/clock.hpp"
#include "base/files.hpp"
#include "base/picture_files/picture_file.hpp"
#include "base/utc_text.hpp"
#include "pipeline/command.hpp"
#include "pipeline/lab/prove/proof_json.hpp"
#include "pipeline/lab/prove/proof_page.hpp"
#include "pipeline/lab/prove/proof_sheet.hpp"

namespace kasumi {
namespace {

Result<int> run_proof(const ProveRequest& request) {
  if (request.landmarks.empty() && request.air.empty())
    return fail(FaultKind::bad_input, "prove: expected the source of the air: --landmarks FILE, or --air TABLE");
  if (request.lat.has_value() != request.lon.has_value())
    return fail(FaultKind::bad_input, "--lat and --lon: expected both");
  const auto proof = prove(request);
  if (!proof) return fail(proof.error());
  const auto summary = summary_of(*proof);
  const std::filesystem::path out = request.out;
  std::error_code error;
  std::filesystem::create_directories(out, error);
  if (error) return fail(FaultKind::io, "{}: {}", request.out, error.message());
  const auto now = utc_text(std::chrono::floor<std::chrono::seconds>(SystemClock().utc()));
  std::vector<std::uint8_t> sheet;
  if (const auto drawn = proof_sheet(*proof); !drawn.empty()) {
    auto png = encode_png(drawn);
    if (!png) return fail(png.error());
    sheet = std::move(*png);
    if (auto written = write_file(out / "sheet.png", sheet); !written) return fail(written.error());
  }
  if (auto written = write_text_file(out / "proof.json", proof_json(*proof, summary, now)); !written)
    return fail(written.error());
  if (auto written = write_text_file(out / "index.html", proof_page(*proof, summary, sheet, now)); !written)
    return fail(written.error());
  if (!request.state.empty())
    if (auto kept = write_text_file(std::filesystem::path(request.state) / "proof.json",
                                    remembered_proof(*proof, summary, now));
        !kept)
      return fail(kept.error());
  fmt::print("{}", proof_text(*proof, summary));
  return 0;
}

}  // namespace

void add_prove_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand(
      "prove", "Puts a real building of the site back into pictures of it, and says how far off it is drawn");
  auto request = std::make_shared<ProveRequest>();
  auto& r = *request;
  command
      ->add_option(
          "scenes", r.scenes,
          "Pictures of the scene camera over many days: a folder, @LIST (a path, a tab, a time, and if you like "
          "a tab and the kind of air), a pattern in quotes")
      ->required();
  command->add_option("--part", r.part, "The building: a name of --landmarks, or a name for --region-px")->required();
  command->add_option("--distance-m", r.distance_m, "How far away it is; default: as its landmark says")
      ->check(CLI::Range(5.0, 400e3));
  command
      ->add_option("--faces-deg", r.faces_deg,
                   "Where the facade faces, degrees from north clockwise: by that the sun is on it or not")
      ->check(CLI::Range(-360.0, 360.0));
  command->add_option("--landmarks", r.landmarks,
                      "[[landmarks]] to estimate the air from, without those of the building");
  command->add_option("--air", r.air,
                      "A table of it instead: utc, extinction_g_per_m, if known extinction_r_per_m, "
                      "extinction_b_per_m, extinction_sigma_per_m");
  command->add_option("--region-px", r.region, "The facade in the reference picture; default: its landmark's")
      ->type_name("X,Y,W,H")
      ->delimiter(',')
      ->expected(4);
  command->add_option("--sky-px", r.sky, "The sky beside it; default: its landmark's")
      ->type_name("X,Y,W,H")
      ->delimiter(',')
      ->expected(4);
  command->add_option("--reference", r.reference, "The picture in which the regions were marked; default: found");
  command->add_option("--lat", r.lat, "Where the camera stands, degrees north; default: [site] of --landmarks")
      ->check(CLI::Range(-90.0, 90.0));
  command->add_option("--lon", r.lon, "Degrees east")->check(CLI::Range(-180.0, 180.0));
  command->add_option("--time-format", r.times.format,
                      "Of the times in the pictures' names, as strptime has it: %Y%m%d_%H%M%S. Default: what is usual, "
                      "else EXIF");
  command->add_option("--utc-offset-h", r.times.utc_offset_h, "Of those times from UTC: 9 in Japan")
      ->check(CLI::Range(-14.0, 14.0))
      ->capture_default_str();
  command->add_option("--state", r.state, "The kiosk's state folder: kasumi doctor then reports the result");
  command->add_option("--out", r.out, "Folder for index.html, sheet.png, proof.json")->required();
  command->callback([request, &action] { action = [request] { return run_proof(*request); }; });
}

}  // namespace kasumi

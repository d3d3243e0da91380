#include "pipeline/lab/photographs/archive_run.hpp"

#include <cmath>
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "pipeline/lab/archive/archive_figures.hpp"
#include "pipeline/lab/archive/merge_parts.hpp"
#include "pipeline/lab/archive/record_table.hpp"
#include "pipeline/lab/archive/summary_page.hpp"
#include "pipeline/lab/photographs/learn_cameras.hpp"
#include "pipeline/machine/progress.hpp"

namespace kasumi {
namespace {

Result<> refuse_beside_out(const EstimateRequest& arguments) {
  Problems problems;
  if (arguments.csv) problems.add("--csv: --out writes records, expected --merge PARTS --out FILE.csv afterwards");
  if (arguments.response_from_pictures())
    problems.add(
        "--response estimate: asks all pictures together, expected --tone-exponent or --camera-memory beside --out");
  return problems.empty() ? Result<>() : fail(problems.fault());
}

// What the answers depend on beside the picture: options, and the files that they name.
Result<std::string> options_fingerprint(const EstimateRequest& arguments) {
  Fingerprint fingerprint;
  fingerprint.add(arguments.given_words);
  std::vector<std::string> files{arguments.calibration, arguments.camera_memory};
  if (const auto periods = CalibrationPeriods::read(arguments.cameras))
    for (std::size_t i = 0; i < periods->size(); ++i) files.push_back(periods->file(i));
  for (const auto& file : files) {
    const auto text = file.empty() ? Result<std::string>() : read_text_file(file);
    if (!text) return fail(text.error());
    fingerprint.add(*text);
  }
  return fingerprint.text();
}

}  // namespace

Result<ArchiveRun> open_archive_run(const EstimateRequest& arguments, EstimateInputs& inputs) {
  if (auto alone = refuse_beside_out(arguments); !alone) return fail(alone.error());
  const auto shard = shard_of(arguments.shard, [](const char* name) { return std::getenv(name); });
  if (!shard) return fail(shard.error());
  const auto options = options_fingerprint(arguments);
  if (!options) return fail(options.error());
  inputs.complete();
  Fingerprint list;
  inputs.add_to(list);
  const std::size_t all = inputs.count().value_or(0);
  const PartPlan plan{{all, list.text(), *options}, shard->first(all), shard->size(all)};
  auto part = PartFile::open(arguments.out, plan, arguments.resume);
  if (!part) return fail(part.error());
  inputs.keep(plan.first + part->done(), plan.count - part->done());
  return ArchiveRun{*shard, plan, std::move(*part)};
}

Result<int> learn_camera_of_archive(const EstimateRequest& arguments, EstimateInputs& inputs, std::size_t threads) {
  constexpr std::size_t kMost = 960;  // half of them by night, half of the rest in clouds
  inputs.complete();
  const auto sample = inputs.sample(kMost);
  const auto learned = learn_cameras(sample, inputs.cameras(), CameraMemory(), true, threads, kMost);
  for (const auto& camera : learned->cameras())
    fmt::print("camera of {} x {} pixels: {} pictures of the sample, {} tone curves, {} suns{}\n", camera.width,
               camera.height, camera.pictures, camera.tones, camera.turn ? camera.turn->suns : 0,
               camera.turn ? fmt::format(", turned to within {:.2f} deg", to_degrees(camera.turn->sigma)) : "");
  if (auto written = learned->write(arguments.learn_camera); !written) return fail(written.error());
  if (!learned->cameras().empty()) return 0;
  fmt::print(stderr, "kasumi: no camera is known by {} of {} pictures\n", sample.size(), inputs.count().value_or(0));
  return 1;
}

Result<int> merge_archive(const EstimateRequest& arguments) {
  if (arguments.out.empty() && arguments.summary.empty())
    return fail(FaultKind::bad_input, "--merge: expected --out FILE.jsonl, .csv or .sqlite, or --summary FILE.html");
  if (!arguments.images.empty())
    return fail(FaultKind::bad_input, "--merge: stands instead of pictures, expected none beside it");
  const std::filesystem::path out = arguments.out;
  if (!arguments.out.empty())
    if (auto known = check_table_name(out); !known) return fail(known.error());
  for (const auto& part : arguments.merge) {
    std::error_code error;
    if (!out.empty() && std::filesystem::equivalent(part, out, error))
      return fail(FaultKind::bad_input, "--out {}: is one of the parts, expected another file", arguments.out);
  }
  const auto whole = WholeArchive::prove({arguments.merge.begin(), arguments.merge.end()});
  if (!whole) return fail(whole.error());

  std::optional<PhotometerComparison> photometer;
  if (!arguments.photometers.empty()) {
    auto readings = read_photometer({arguments.photometers.begin(), arguments.photometers.end()});
    if (!readings) return fail(readings.error());
    photometer.emplace(std::move(*readings));
  }
  const std::chrono::minutes ahead(std::lround(60.0 * arguments.utc_offset_h));
  ArchiveFigures figures(ahead);
  SeriesFigures series(ahead);
  Progress progress("merge", whole->archive().pictures, std::chrono::seconds(60));
  const auto pass = [&](RecordTable* table) -> Result<> {
    auto taken = whole->for_each([&](std::string_view line, const nlohmann::json& record) -> Result<> {
      figures.add(record);
      series.add(record);
      if (photometer) photometer->add(record);
      progress.advance("");
      return table ? table->add(line, record) : Result<>();
    });
    return taken && table ? table->finish() : taken;
  };
  const auto merged =
      out.empty() ? pass(nullptr) : replace_file(out, [&](const std::filesystem::path& path) -> Result<> {
        const auto table = open_record_table(path);
        if (!table) return fail(table.error());
        return pass(table->get());
      });
  progress.clear();
  if (!merged) return fail(merged.error());
  const auto page =
      arguments.summary.empty() ? out.parent_path() / "summary.html" : std::filesystem::path(arguments.summary);
  const ArchiveSummary summary{figures, series, photometer ? &*photometer : nullptr, whole->archive()};
  if (auto written = write_text_file(page, summary_page(summary)); !written) return fail(written.error());
  auto beside = page;
  if (auto written = write_text_file(beside.replace_extension(".json"), summary_json(summary)); !written)
    return fail(written.error());
  fmt::print("{} pictures of {} parts, each exactly once; {} tell the air: {}{}\n", figures.pictures(),
             arguments.merge.size(), figures.usable(), out.empty() ? "" : out.string() + ", ", page.string());
  return 0;
}

}  // namespace kasumi

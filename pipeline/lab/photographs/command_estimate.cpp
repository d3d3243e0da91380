#include <algorithm>
#include <atomic>
#include <cstdio>
#include <map>
#include <thread>

#include <CLI/CLI.hpp>

#include "pipeline/command.hpp"
#include "pipeline/lab/archive/estimate_csv.hpp"
#include "pipeline/lab/photographs/archive_run.hpp"
#include "pipeline/lab/photographs/estimate_answer.hpp"
#include "pipeline/lab/photographs/estimate_inputs.hpp"
#include "pipeline/lab/photographs/estimate_request.hpp"
#include "pipeline/lab/photographs/estimate_tally.hpp"
#include "pipeline/lab/photographs/estimated_response.hpp"
#include "pipeline/lab/photographs/fit_plot.hpp"
#include "pipeline/lab/photographs/found_air.hpp"
#include "pipeline/lab/photographs/haze_answer.hpp"
#include "pipeline/lab/photographs/learn_cameras.hpp"
#include "pipeline/lab/photographs/scan_report.hpp"
#include "pipeline/lab/photographs/steady_worker.hpp"
#include "pipeline/lab/photographs/visibility_series.hpp"
#include "pipeline/log_lines.hpp"
#include "pipeline/machine/ordered_jobs.hpp"
#include "pipeline/machine/progress.hpp"
#include "pipeline/site/files/archive_members.hpp"
#include "pipeline/site/files/picture_sink.hpp"

namespace kasumi {

namespace {

struct ImageJob {
  EstimateInput input;
  const VisibilityReading* scene = nullptr;  // taken at the same time
  std::optional<ArchivePlace> place{};       // of a record
};

struct StackJob {
  PictureStack stack;
  ArchivePlace place;  // of the first that is to be answered
};

// The landmarks' result from the scene camera's picture of the same time, compared with the sky.
std::string landmarks_answer(const VisibilitySeries& scenes, const VisibilityReading& scene,
                             const PhotographReport* report, bool json) {
  std::optional<ExtinctionComparison> sky;
  if (report && report->look.estimate.usable)
    sky = scenes.watch.compare(scene.air, report->look.estimate.turbidity, report->look.estimate.sigma);
  return json ? visibility_json(scenes.watch, scene, sky ? &*sky : nullptr)
              : visibility_text(scenes.watch, scene, sky ? &*sky : nullptr);
}

std::filesystem::path plot_path(const EstimateRequest& arguments, const std::filesystem::path& image) {
  auto name = image.filename();
  name += ".fit.png";
  const auto member = archive_member(image);
  const auto folder = (member ? member->archive : image).parent_path();
  return (arguments.plot_dir.empty() ? folder : std::filesystem::path(arguments.plot_dir)) / name;
}

struct Answer {
  std::string text;         // for standard output
  std::string error;        // for standard error
  std::string useless;      // why nothing is known from it; empty: something is, or `error` says more
  std::string elsewhere{};  // where the file says that it was taken, where that contradicts the place given
};

// Files whose own place is not the one given: the first and their number, for the end.
class Elsewhere {
 public:
  void add(const std::filesystem::path& file, const std::string& elsewhere) {
    if (!elsewhere.empty() && count_++ == 0) first_ = file.string() + ": " + elsewhere;
  }
  void print() const {
    if (count_ > 0)
      fmt::print(stderr, "kasumi: {} picture{} of another place than the one given, which is followed: {}\n", count_,
                 count_ == 1 ? " is" : "s are", first_);
  }

 private:
  std::size_t count_ = 0;
  std::string first_;
};

// What one thread keeps of each camera.
class Worker {
 public:
  explicit Worker(const std::vector<PhotographSetup>& cameras) : cameras_(&cameras) {}
  PhotographEstimator& of(std::size_t camera) {
    return photographs_.try_emplace(camera, (*cameras_)[camera]).first->second;
  }
  std::optional<Utc> utc_of(const EstimateInput& input) const {
    return input.utc ? input.utc : (*cameras_)[input.camera].utc;
  }

 private:
  const std::vector<PhotographSetup>* cameras_;
  std::map<std::size_t, PhotographEstimator> photographs_;
};

Answer answer_of(const EstimateRequest& arguments, const VisibilitySeries* scenes, const ImageJob& job,
                 const PhotographReport& report) {
  const auto& file = job.input.file;
  const auto landmarks_text =
      job.scene ? landmarks_answer(*scenes, *job.scene, &report, arguments.json) : std::string();
  Answer answer;
  if (report.off_m) answer.elsewhere = other_place(report);
  if (!report.look.estimate.usable && !(job.scene && job.scene->usable()))
    answer.useless = why_useless(report.look.estimate);
  if (job.place)
    answer.text = archive_record(estimate_json(file, report, ""), report.utc, answer.useless, *job.place);
  else if (arguments.csv)
    answer.text = estimate_csv_line(estimate_json(file, report, ""), report.utc);
  else
    answer.text =
        arguments.json ? estimate_json(file, report, landmarks_text) : estimate_text(file, report) + landmarks_text;
  if ((arguments.plot || !arguments.plot_dir.empty()) && report.picture) {
    const auto path = plot_path(arguments, file);
    const auto& estimate = report.look.estimate;
    auto title = fmt::format("{}: {}", file.filename().string(), estimate.reason);
    if (estimate.usable)
      title = fmt::format("{}: T = {:.3f} +- {:.3f}, aerosol depth {:.3f} +- {:.3f}", file.filename().string(),
                          estimate.turbidity.value, estimate.sigma, report.quality->aod_550,
                          aerosol_sigmas(estimate, *report.air).aod_550);
    if (auto written = write_png(path, plot_fit(*report.picture, report.look, title)); !written)
      answer.error = written.error().message;
  }
  return answer;
}

Answer answer_of(const EstimateRequest& arguments, Worker& worker, const VisibilitySeries* scenes,
                 const ImageJob& job) {
  const auto& [file, utc, problem, camera, label] = job.input;
  const auto unread = [&](const std::string& why) {
    if (job.place) return Answer{unread_record(file.string(), worker.utc_of(job.input), why, *job.place), why, ""};
    return Answer{arguments.csv ? estimate_csv_line(file.string(), worker.utc_of(job.input), why) : "", why, ""};
  };
  if (!problem.empty()) return unread(problem);
  const auto report = worker.of(camera).estimate_from(file, utc);
  return report ? answer_of(arguments, scenes, job, *report) : unread(report.error().message);
}

// One for each picture of the job that is to be answered.
std::vector<Answer> answers_of(const EstimateRequest& arguments, Worker& worker, const StackJob& job) {
  const auto& pictures = job.stack.pictures;
  std::vector<std::filesystem::path> files;
  for (const auto& picture : pictures) files.push_back(picture.file);
  const auto whole = pictures.size() > 1
                         ? worker.of(pictures.front().camera).estimate_from_stack(files, pictures.front().utc)
                         : std::nullopt;
  std::vector<Answer> answers;
  for (std::size_t i = 0; i < job.stack.count; ++i) {
    const auto& input = pictures[job.stack.first + i];
    const ImageJob own{input, nullptr, ArchivePlace{job.place.picture + i, job.place.archive}};
    const bool merged = whole && std::ranges::find(whole->stack, input.file) != whole->stack.end();
    if (!merged)
      answers.push_back(answer_of(arguments, worker, nullptr, own));
    else if (input.file == whole->stack.front())
      answers.push_back(answer_of(arguments, nullptr, own, *whole));
    else
      answers.push_back(
          {exposure_record(input.file.string(), worker.utc_of(input), whole->stack.front().string(), *own.place), "",
           std::string(kExposureOfStack)});
  }
  return answers;
}

int exit_code_of(const EstimateTally& tally, std::string_view what) {
  if (const auto told = tally.told(what); !told.empty()) fmt::print(stderr, "kasumi: {}\n", told);
  return tally.exit_code();
}

// Errors (bad_input): it cannot be made, or is a file.
Result<> make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && std::filesystem::is_directory(folder)) return {};
  return fail(FaultKind::bad_input, "--plot-dir {}: expected a folder, or a place for a new one ({})", folder.string(),
              error ? error.message() : "a file is there");
}

Result<int> estimate_scans(const EstimateRequest& arguments) {
  const auto options = photograph_setup(arguments);
  if (!options) return fail(options.error());
  EstimateTally tally;
  if (arguments.csv) fmt::print("{}", estimate_csv_header());
  for (const std::filesystem::path file : arguments.scans) {
    const auto report = report_on_scan(file, *options);
    if (arguments.csv)
      fmt::print("{}", report ? estimate_csv_line(estimate_json(file, report->answer, ""), options->utc)
                              : estimate_csv_line(file.string(), options->utc, report.error().message));
    else if (report)
      fmt::print("{}", arguments.json ? estimate_json(file, report->answer, "") : estimate_text(file, report->answer));
    std::fflush(stdout);
    const std::string told = report ? report->note : report.error().message;
    if (!told.empty()) fmt::print(stderr, "kasumi: {}{}\n", report ? file.string() + ": " : "", told);
    if (!report)
      tally.unread();
    else if (const auto& estimate = report->answer.look.estimate; !estimate.usable)
      tally.useless(why_useless(estimate));
    else
      tally.useful();
  }
  return exit_code_of(tally, "scan");
}

Result<int> estimate_hazes(const EstimateRequest& arguments) {
  if (!arguments.images.empty() || !arguments.scenes.empty() || !arguments.scans.empty())
    return fail(FaultKind::bad_input, "--haze: stands instead of other pictures, expected none beside it");
  HazeQuestion question{.distance_m = arguments.distance_m, .altitude_m = arguments.altitude_m.value_or(0.0)};
  if (const auto& part = arguments.part; part.size() == 4) question.part = HazyPart{part[0], part[1], part[2], part[3]};
  EstimateTally tally;
  for (const auto& answer : hazes_of({arguments.hazes.begin(), arguments.hazes.end()}, question)) {
    if (!answer) {
      fmt::print(stderr, "kasumi: {}\n", answer.error().message);
      tally.unread();
      continue;
    }
    fmt::print("{}", arguments.json ? haze_json(*answer) : haze_text(*answer));
    answer->useful() ? tally.useful() : tally.useless(answer->colour.reason);
  }
  return exit_code_of(tally, "picture");
}

Result<int> answer_scenes(const VisibilitySeries& scenes, const EstimateRequest& arguments) {
  MeasuredVisibilities measured;
  if (!arguments.measured.empty()) {
    auto read = read_measured_visibilities(arguments.measured);
    if (!read) return fail(read.error());
    measured = std::move(*read);
  }
  EstimateTally tally;
  std::vector<VisibilityCheck> checks;
  for (const auto& scene : scenes.pictures) {
    const auto instrument = measured.find(scene.picture.filename().string());
    const bool checked = instrument != measured.end();
    if (checked) checks.push_back(check_visibility(scene.air, instrument->second));
    const auto* check = checked ? &checks.back() : nullptr;
    if (arguments.json)
      fmt::print("{}\n", visibility_json(scenes.watch, scene, nullptr, check));
    else
      fmt::print("{}{}", visibility_text(scenes.watch, scene, nullptr), check ? check_text(*check) : "");
    scene.usable() ? tally.useful() : tally.useless(scene.air.extinction().reason);
  }
  if (!measured.empty() && !arguments.json) fmt::print("{}", checks_text(checks));
  return exit_code_of(tally, "picture");
}

// What must be known of the cameras before the first answer: of --response estimate from all pictures, else from as many
// as are there at once.
Result<> learn(const EstimateRequest& arguments, EstimateInputs& inputs, std::size_t threads) {
  constexpr std::size_t kMost = 200;
  if (arguments.response_from_pictures()) {
    std::vector<DatedFile> taken;
    for (auto& input : inputs.all())
      if (input.problem.empty()) taken.push_back({input.file, input.utc});
    const auto tone = tone_curve_of(taken, inputs.cameras().front());
    if (!tone) return fail(FaultKind::bad_input, "--response estimate: {}", tone.error().message);
    inputs.set_tone(*tone);
  }
  CameraMemory memory;
  if (!arguments.camera_memory.empty()) {
    auto before = CameraMemory::read(arguments.camera_memory);
    if (!before) return fail(before.error());
    memory = std::move(*before);
  }
  const bool kept = !arguments.camera_memory.empty();
  const auto learned = learn_cameras(inputs.ahead(kMost), inputs.cameras(), std::move(memory), kept, threads);
  inputs.set_memory(learned);
  return kept ? learned->write(arguments.camera_memory) : Result<>();
}

// A shard of an archive; a picture that cannot be read is a record, and no error.
Result<int> estimate_archive(const EstimateRequest& arguments, EstimateInputs& inputs, std::size_t threads) {
  auto run = open_archive_run(arguments, inputs);
  if (!run) return fail(run.error());
  CameraMemory memory;
  if (!arguments.camera_memory.empty()) {
    auto before = CameraMemory::read(arguments.camera_memory);
    if (!before) return fail(before.error());
    memory = std::move(*before);
  }
  // Each picture by itself: what one shard's pictures tell of their camera the others would not know.
  inputs.set_memory(std::make_shared<CameraMemory>(std::move(memory)));
  const auto& shard = run->shard;
  const auto& plan = run->plan;
  auto& part = run->part;
  const auto name =
      shard.from.empty() ? std::string("estimate") : fmt::format("shard {}/{}", shard.index + 1, shard.count);
  fmt::print(stderr, "kasumi: {}{}: pictures {} to {} of {}; {} are there already{}\n", name,
             shard.from.empty() || shard.from == "--shard" ? "" : " by " + shard.from, plan.first + 1,
             plan.first + plan.count, plan.archive.pictures, part.done(),
             part.mended_bytes() > 0 ? fmt::format(", without a torn record of {} bytes", part.mended_bytes()) : "");
  std::size_t number = plan.first + part.done(), useful = 0, unread = 0;
  std::vector<Worker> workers(threads, Worker(inputs.cameras()));
  Progress progress(name, plan.count - part.done(), std::chrono::seconds(60));
  std::atomic<bool> failed = false;
  Result<> written;
  Elsewhere elsewhere;
  run_in_order<StackJob, std::vector<Answer>>(
      threads,
      [&]() -> std::optional<StackJob> {
        auto stack = failed ? std::nullopt : inputs.next_stack();
        if (!stack) return std::nullopt;
        StackJob job{std::move(*stack), {number + 1, plan.archive}};
        number += job.stack.count;
        return job;
      },
      [&](std::size_t worker, const StackJob& job) { return answers_of(arguments, workers[worker], job); },
      [&](const StackJob& job, const std::vector<Answer>& answers) {
        for (std::size_t i = 0; i < answers.size() && !failed; ++i) {
          const auto& answer = answers[i];
          written = part.add(answer.text);
          failed = !written;
          unread += answer.error.empty() ? 0 : 1;
          useful += answer.error.empty() && answer.useless.empty() ? 1 : 0;
          elsewhere.add(job.stack.pictures[job.stack.first + i].file, answer.elsewhere);
          progress.advance("");
        }
      });
  progress.clear();
  if (written) written = part.finish();
  if (!written) return fail(written.error());
  elsewhere.print();
  fmt::print(stderr, "kasumi: {}: done, {} more pictures: {} tell the air, {} could not be read\n", name,
             number - plan.first - part.done(), useful, unread);
  return 0;
}

// Arguments that name no picture are reported first; the others are still answered.
Result<int> estimate_pictures(const EstimateRequest& arguments, const std::optional<VisibilitySeries>& scenes) {
  auto inputs = EstimateInputs::expand(arguments);
  if (!inputs) return fail(inputs.error());
  const auto& missing = inputs->problems();
  const bool whole = !arguments.out.empty() || !arguments.learn_camera.empty();  // or nothing
  if (!missing.empty() && (inputs->empty() || scenes || whole)) return fail(missing.fault());
  if (scenes && scenes->pictures.size() != inputs->count())
    return fail(FaultKind::bad_input,
                "--scene: {} pictures but {} of the sky: expected one for each, in the same order, or none of the sky",
                scenes->pictures.size(), inputs->count().value_or(0));
  prepare_steady_work();
  if (!arguments.plot_dir.empty())
    if (auto made = make_folder(arguments.plot_dir); !made) return fail(made.error());
  EstimateTally tally;
  if (!missing.empty()) print_error(missing.fault().message);
  for (std::size_t i = 0; i < missing.lines().size(); ++i) tally.unread();

  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  std::size_t threads = arguments.jobs > 0 ? arguments.jobs : cores;
  threads = std::min(threads, inputs->count().value_or(threads));
  if (!arguments.learn_camera.empty()) return learn_camera_of_archive(arguments, *inputs, threads);
  if (!arguments.out.empty()) return estimate_archive(arguments, *inputs, threads);
  if (auto learned = learn(arguments, *inputs, threads); !learned) return fail(learned.error());
  std::size_t given = 0;
  const auto next = [&]() -> std::optional<ImageJob> {
    auto input = inputs->next();
    if (!input) return std::nullopt;
    return ImageJob{std::move(*input), scenes ? &scenes->pictures[given++] : nullptr};
  };

  std::vector<Worker> workers(threads, Worker(inputs->cameras()));
  if (arguments.csv) fmt::print("{}", estimate_csv_header());
  std::fflush(stdout);
  Progress progress("estimate", inputs->count());
  Elsewhere elsewhere;
  run_in_order<ImageJob, Answer>(
      threads, next,
      [&](std::size_t worker, const ImageJob& job) {
        return answer_of(arguments, workers[worker], scenes ? &*scenes : nullptr, job);
      },
      [&](const ImageJob& job, const Answer& answer) {
        progress.clear();
        elsewhere.add(job.input.file, answer.elsewhere);
        fmt::print("{}", answer.text);
        std::fflush(stdout);
        if (!answer.error.empty()) {
          fmt::print(stderr, "kasumi: {}\n", answer.error);
          tally.unread();
        } else if (!answer.useless.empty()) {
          tally.useless(answer.useless);
        } else {
          tally.useful();
        }
        progress.advance("");
      });
  progress.clear();
  elsewhere.print();
  return exit_code_of(tally, "picture");
}

Result<int> estimate(const EstimateRequest& arguments) {
  const bool pictures_asked = !arguments.images.empty() || (arguments.scenes.empty() && arguments.scans.empty());
  if (arguments.csv && (!arguments.hazes.empty() || !arguments.scenes.empty()))
    return fail(FaultKind::bad_input, "--csv: has no columns for --haze and --scene, expected --json");
  if (!arguments.merge.empty()) return merge_archive(arguments);
  if (!arguments.out.empty() && (!arguments.hazes.empty() || !arguments.scans.empty() || !arguments.scenes.empty()))
    return fail(FaultKind::bad_input, "--out: is for pictures of the sky, expected no --scene, --scan or --haze");
  if (!arguments.hazes.empty()) return estimate_hazes(arguments);
  if (!arguments.scans.empty()) return estimate_scans(arguments);
  std::optional<VisibilitySeries> scenes;
  if (!arguments.scenes.empty()) {
    auto visibilities = read_visibilities({arguments.scenes.begin(), arguments.scenes.end()}, arguments.landmarks);
    if (!visibilities) return fail(visibilities.error());
    scenes = std::move(*visibilities);
    if (!pictures_asked) return answer_scenes(*scenes, arguments);
  }
  if (!arguments.measured.empty())
    return fail(FaultKind::bad_input, "--measured: is for --scene alone, expected no pictures of the sky beside it");
  return estimate_pictures(arguments, scenes);
}

}  // namespace

void add_estimate_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("estimate", "Turbidity from photographs of the sky");
  auto arguments = std::make_shared<EstimateRequest>();
  add_estimate_options(*command, *arguments);
  command->callback([command, arguments, &action] {
    if (!arguments->scenes.empty() && arguments->landmarks.empty())
      throw CLI::ValidationError("--scene", "expected --landmarks FILE with their places and distances");
    order_lists(*command, *arguments);
    arguments->given_words = words_of_answers(*command);
    action = [arguments] { return estimate(*arguments); };
  });
}

}  // namespace kasumi

#include "pipeline/lab/recording/replay.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <future>
#include <thread>

#include "base/files.hpp"
#include "base/latest_slot.hpp"
#include "base/statistics.hpp"
#include "capture/fixture/replay_source.hpp"
#include "gles/display/window.hpp"
#include "gles/gl/offscreen.hpp"
#include "gles/model/mip_levels.hpp"
#include "pipeline/lab/recording/light_terms.hpp"
#include "pipeline/lab/recording/replayed_air.hpp"
#include "pipeline/machine/progress.hpp"
#include "pipeline/machine/stop_signal.hpp"
#include "pipeline/show/scene/air_figures.hpp"
#include "pipeline/show/scene/compositor.hpp"
#include "pipeline/show/stage/overlay.hpp"
#include "pipeline/show/stage/then_and_now.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "pipeline/site/files/picture_sink.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

// Frame rate of the video: the recorded rate, or a time lapse where there are seconds between frames.
double film_rate(const std::vector<IndexRow>& rows) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < rows.size(); ++i)
    intervals.push_back(to_seconds(rows[i].metadata.captured_at - rows[i - 1].metadata.captured_at));
  if (intervals.empty()) return 10.0;
  const double interval = median(std::move(intervals));
  return interval > 0.0 && interval <= 1.0 ? std::min(1.0 / interval, 120.0) : 10.0;
}

bool is_film(const std::filesystem::path& out) {
  return out.extension() == ".mp4";
}

Image<Rgb8> opaque(const Image<glm::u8vec4>& pixels) {
  Image<Rgb8> picture(pixels.width(), pixels.height());
  std::ranges::transform(pixels.elements(), picture.elements().begin(), [](const glm::u8vec4& p) { return Rgb8(p); });
  return picture;
}

// Where the pictures of one run are drawn and stored.
struct ReplayOutput {
  std::unique_ptr<GlContext> headless;
  std::unique_ptr<Window> window;
  std::optional<Offscreen> offscreen;
  std::unique_ptr<PictureSink> sink;

  GlContext& context() { return window ? *window : *headless; }
};

Result<ReplayOutput> open_output(const ReplayRequest& request, const Fixture& fixture) {
  ReplayOutput output;
  const auto& scene = fixture.installation.scene;
  if (request.window) {
    auto window = open_window({"Kasumi: " + fixture.info.name, scene.width, scene.height, request.realtime});
    if (!window) return fail(window.error());
    output.window = std::move(*window);
  } else {
    auto context = open_headless_context();
    if (!context) return fail(context.error());
    output.headless = std::move(*context);
  }
  if (request.out || !request.window) {
    auto offscreen = Offscreen::create(output.context().info(), scene.width, scene.height);
    if (!offscreen) return fail(offscreen.error());
    output.offscreen = std::move(*offscreen);
  }
  if (request.out) {
    Result<std::unique_ptr<PictureSink>> sink;
    if (is_film(*request.out)) {
      const auto rows = read_index(fixture.folder / "scene");
      if (!rows) return fail(rows.error());
      sink = open_film(*request.out, film_rate(*rows));
    } else {
      sink = open_picture_folder(*request.out);
    }
    if (!sink) return fail(sink.error());
    output.sink = std::move(*sink);
  }
  return output;
}

// The state of one run and what each kind of frame does.
class Run {
 public:
  Run(const ReplayRequest& request, const Fixture& fixture, const Model& model, ReplayOutput output,
      Compositor compositor, std::optional<LightTerms> terms, ReplayedAir& air, StageTimes& times)
      : request_(request),
        output_(std::move(output)),
        compositor_(std::move(compositor)),
        terms_(std::move(terms)),
        site_(fixture.installation.site),
        encoding_(fixture.installation.scene.yuv_encoding),
        air_(air),
        times_(times) {
    compositor_.set_bare(request.wipe);
    compositor_.set_view(request.view);
    if (request.overlay) overlay_.emplace(output_.context(), fixture.installation, model.bounds(), std::nullopt);
    summary_.fixture = fixture.info.name;
    summary_.gl_renderer = output_.context().info().renderer;
    summary_.software_gl = output_.context().info().software;
    summary_.processor_mixed = compositor_.processor_mixes();
  }

  // `next`: the first of the scene camera's frames. The following one, and its air, come while this one is drawn.
  Result<> play(FixtureSources& sources, std::future<ReplayedFrame> next) {
    Progress progress("replay", request_.frames.value_or(sources.scene->row_count()));
    const auto ask = [&] {
      next = std::async(std::launch::async, [&] { return air_.next_scene_frame(sources, stop_requested); });
    };
    while (next.valid()) {
      auto frame = next.get();
      if (!frame || over()) break;
      // The last picture's sky is the last that counts; whether this is the last is known when it is drawn.
      const bool may_be_last = request_.frames && summary_.pictures + 1 >= *request_.frames;
      if (!may_be_last) ask();
      latest_ = std::move(frame->sky);
      if (auto shown = show(frame->frame, frame->picture); !shown) return shown;
      progress.advance(progress_detail());
      if (may_be_last && !over()) ask();
    }
    air_.finish_sky(sources, [this] { return over(); });
    latest_ = air_.latest();
    return {};
  }

  // The sky runs in a thread of its own; this thread owns GL.
  Result<> play_in_real_time(FixtureSources& sources, Clock& clock) {
    Progress progress("replay", request_.frames.value_or(sources.scene->row_count()));
    LatestSlot<SkyReport> reports;
    LatestSlot<Sight> sights;
    std::atomic<bool> stopping = false;
    std::thread sky([&] {
      DaylightState above;
      while (!stopping && sources.sky->due()) {
        if (const auto sight = sights.take()) air_.look(*sight, above);
        if (auto report = air_.observe_sky(sources.sky->next(clock.now() + 500ms))) {
          above = above_in(*report);
          reports.put(std::move(*report));
        }
      }
    });
    Result<> result;
    while (!over() && sources.scene->due()) {
      auto frame = sources.scene->next(clock.now() + 50ms);
      if (auto report = reports.take()) latest_ = std::move(*report);
      if (!frame && frame.error().kind == FaultKind::timeout)
        continue;  // a gap: keep handling the window's events and hold the picture
      if (auto sight = air_.sight_due(frame)) sights.put(std::move(*sight));
      if (!frame) {
        if (result = show(frame, fail(frame.error())); !result) break;
      } else if (result = show(frame, decode(*frame, encoding_)); !result) {
        break;
      }
      progress.advance(progress_detail());
    }
    stopping = true;
    clock.interrupt();
    sky.join();
    summary_.dropped = reports.dropped();
    return result;
  }

  Result<ReplaySummary> finish() {
    if (output_.sink) {
      if (auto written = wait_for_writing(0); !written) return fail(written.error());
      if (auto finished = output_.sink->finish(); !finished) return fail(finished.error());
      const auto folder = is_film(*request_.out) ? request_.out->parent_path() : *request_.out;
      if (auto written = air_.table().write(folder / "turbidity.csv"); !written) return fail(written.error());
      if (!air_.curve().empty())
        if (auto written = write_text_file(folder / "air.svg", air_.curve().svg()); !written)
          return fail(written.error());
    }
    summary_.sky_frames = air_.sky_frames();
    summary_.usable_sky_frames = air_.usable_sky_frames();
    summary_.skipped.merge(std::map(air_.skipped()));
    summary_.layers_drawn = compositor_.layer().drawn();
    summary_.horizon = compositor_.air().horizon().source;
    summary_.horizon_reason = compositor_.air().horizon().reason;
    summary_.notes = compositor_.notes();
    summary_.stages = times_.seconds();
    if (latest_.picture) summary_.last = latest_;
    if (summary_.last) summary_.air = seen_quality(latest_, site_.altitude_m);
    return summary_;
  }

 private:
  bool over() {
    if (request_.frames && summary_.pictures >= *request_.frames) return true;
    summary_.interrupted = stop_requested() || (output_.window && !output_.window->handle_events());
    return summary_.interrupted;
  }

  std::string progress_detail() const {
    const auto* air = latest_.seen_air();
    return air ? fmt::format("T {:.2f}", air->air.turbidity().value) : "T unknown yet";
  }

  Result<> show(const Result<Frame>& frame, const Result<DecodedPicture>& picture) {
    if (!frame) {
      if (frame.error().kind != FaultKind::timeout && frame.error().kind != FaultKind::end_of_stream)
        ++summary_.skipped[fmt::format("scene camera: {}", name_of(frame.error().kind))];
      return {};
    }
    if (!picture) return skip_or_fail(*frame, picture.error());
    place_sun(latest_, frame->metadata.utc, site_);
    const auto started = StageTimes::now();
    const auto layers = compositor_.layer().drawn();
    auto drawn = draw(*frame, *picture);
    times_.add(compositor_.layer().drawn() == layers ? ReplayStage::drawing : ReplayStage::layers, started);
    if (!drawn) return skip_or_fail(*frame, drawn.error());
    if (output_.sink)
      if (auto written = write(std::move(*drawn)); !written) return written;
    ++summary_.pictures;
    return {};
  }

  // Of a window alone no pixels are read.
  Result<Image<Rgb8>> draw(const Frame& frame, const DecodedPicture& decoded) {
    Image<Rgb8> picture;
    if (output_.offscreen && compositor_.processor_mixes() && !terms_ && !overlay_ && request_.wipe <= 0.0 &&
        request_.view == BuildingView::live) {
      const auto mixed = compositor_.mix(frame.metadata, decoded, latest_);
      if (!mixed) return fail(mixed.error());
      if (output_.sink) picture = opaque(**mixed);
    } else if (output_.offscreen) {
      if (auto drawn = compositor_.draw(frame.metadata, decoded, latest_, output_.offscreen->target()); !drawn)
        return fail(drawn.error());
      if (terms_)
        if (auto written = write_terms(frame); !written) return fail(written.error());
      if (auto drawn = draw_overlay(output_.offscreen->target()); !drawn) return fail(drawn.error());
      auto pixels = output_.offscreen->read();
      if (!pixels) return pixels;
      picture = std::move(*pixels);
    }
    if (output_.window) {
      if (auto drawn = compositor_.draw(frame.metadata, decoded, latest_, output_.window->target()); !drawn)
        return fail(drawn.error());
      if (auto drawn = draw_overlay(output_.window->target()); !drawn) return fail(drawn.error());
      output_.window->show();
    }
    return picture;
  }

  // The last pictures are written while the next one is drawn. Errors: of those before, too.
  Result<> write(Image<Rgb8> picture) {
    if (auto written = wait_for_writing(output_.sink->at_once() - 1); !written) return written;
    writing_.push_back(std::async(std::launch::async, [this, number = summary_.pictures, picture = std::move(picture)] {
      const auto started = StageTimes::now();
      auto put = output_.sink->put(number, picture);
      times_.add(ReplayStage::writing, started);
      return put;
    }));
    return {};
  }
  // Until so many are left.
  Result<> wait_for_writing(std::size_t left) {
    for (; writing_.size() > left; writing_.pop_front())
      if (auto written = writing_.front().get(); !written) return written;
    return {};
  }

  Result<> write_terms(const Frame& frame) {
    const auto picture = output_.offscreen->read();
    if (!picture) return fail(picture.error());
    return terms_->write(*request_.out, summary_.pictures, frame, latest_, *picture);
  }

  Result<> draw_overlay(const DrawTarget& target) {
    if (overlay_)
      if (auto drawn = overlay_->draw(target); !drawn) return drawn;
    const MessageStyle letters;
    const auto hour = hour_of(request_.view, latest_.utc, site_, {});  // recordings name no time zone
    return then_and_now_.draw(
        output_.context(), hand_view(request_.wipe, latest_, letters.language, request_.view, hour), letters, target);
  }

  Result<> skip_or_fail(const Frame& frame, const Fault& fault) {
    if (fault.kind != FaultKind::bad_input) return fail(fault);
    const auto status = frame.metadata.status;
    ++summary_.skipped[fmt::format("scene camera: {}", status == FrameStatus::good ? "damaged" : name_of(status))];
    return {};
  }

  const ReplayRequest& request_;
  ReplayOutput output_;
  Compositor compositor_;
  std::optional<LightTerms> terms_;  // empty: not wanted
  std::optional<Overlay> overlay_;
  ThenAndNow then_and_now_;
  Site site_;
  YuvEncoding encoding_;
  ReplayedAir& air_;
  StageTimes& times_;
  SkyReport latest_;
  ReplaySummary summary_;
  std::deque<std::future<Result<>>> writing_;  // of the last pictures
};

}  // namespace

Result<ReplaySummary> replay(const ReplayRequest& request) {
  const auto started = std::chrono::steady_clock::now();
  if (request.terms && (!request.out || is_film(*request.out)))
    return fail(FaultKind::bad_input, "--terms: expected --out FOLDER, in which two more pictures stand next to each");
  auto fixture = read_fixture(request.fixture);
  if (!fixture) return fail(fixture.error());
  auto& given = fixture->installation.surroundings.air;
  given = given.overridden_by(request.given);
  if (request.air.turbidity) given.aod_550.reset();

  std::unique_ptr<Clock> clock;
  if (request.realtime)
    clock = std::make_unique<SystemClock>();
  else
    clock = std::make_unique<FastForwardClock>(fixture->info.start_utc);
  auto sources = open_fixture_sources(fixture->folder, *clock);
  if (!sources) return fail(sources.error());
  // The air of the first pictures is estimated while this thread opens GL and the model.
  StageTimes times;
  ReplayedAir air(fixture->installation, times);
  std::future<ReplayedFrame> first;
  if (!request.realtime)
    first = std::async(std::launch::async, [&] { return air.next_scene_frame(*sources, stop_requested); });
  auto output = open_output(request, *fixture);
  if (!output) return fail(output.error());
  auto model = read_gltf(fixture->installation.object.model, {}, fixture->installation.object.scene);
  if (!model) return fail(model.error());
  make_levels(*model);
  auto compositor = Compositor::create(output->context(), fixture->installation, *model,
                                       SceneAir(fixture->installation, request.air), {.mixing = request.mixing});
  if (!compositor) return fail(compositor.error());

  std::optional<LightTerms> terms;
  if (request.terms) {
    auto created = LightTerms::create(output->context(), fixture->installation, *model, request.air, request.mixing);
    if (!created) return fail(created.error());
    terms = std::move(*created);
  }

  Run run(request, *fixture, *model, std::move(*output), std::move(*compositor), std::move(terms), air, times);
  auto played = request.realtime ? run.play_in_real_time(*sources, *clock) : run.play(*sources, std::move(first));
  if (!played) return fail(played.error());
  auto summary = run.finish();
  if (summary) summary->given = given.whole();
  if (summary) summary->notes.insert(summary->notes.end(), model->notes.begin(), model->notes.end());
  if (summary) summary->sighting = sight_object(fixture->installation, model->bounds());
  if (summary && !fixture->installation.depth_map.empty()) summary->notes.push_back(fixture->installation.depth_map);
  if (summary) summary->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  return summary;
}

}  // namespace kasumi

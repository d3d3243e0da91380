#include <algorithm>
#include <array>
#include <memory>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "estimator/sky/sun.hpp"
#include "gles/model/mip_levels.hpp"
#include "pipeline/command.hpp"
#include "pipeline/lab/rehearse/rehearsed_view.hpp"
#include "pipeline/machine/progress.hpp"
#include "pipeline/show/stage/shown_story.hpp"
#include "pipeline/site/config/content.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "pipeline/site/files/contact_sheet.hpp"
#include "pipeline/site/files/picture_sink.hpp"

namespace kasumi {

namespace {

namespace fs = std::filesystem;

constexpr std::array kAirNames{"clear", "usual", "hazy"};
constexpr std::size_t kMostHours = 12;
constexpr int kMonths = 12;
constexpr int kCellWidth = 480, kStoryWidth = 960;  // a story's letters are to be read
constexpr int kStoryColumns = 2, kStoryMonth = 6;

struct RehearseArguments {
  std::string kiosk, out;
  int year = 2026, day = 21;
  std::vector<int> hours{6, 9, 12, 15, 18};
  std::vector<double> turbidities{2.0, 3.0, 8.0};
  bool film = false;
  int film_minutes = 30;
  double frames_per_second = 12.0;
};

// What is shown when; a recording has no eras.
struct Rehearsed {
  ContentPtr content;
  std::string time_zone;
  ContentPtr at(Utc utc) const { return in_its_era(content, utc); }
};

Result<Rehearsed> of_recording(const fs::path& folder) {
  auto fixture = read_fixture(folder);
  if (!fixture) return fail(fixture.error());
  auto content = std::make_shared<Content>();
  content->config.installation = std::move(fixture->installation);
  const auto& object = content->config.installation.object;
  auto model = read_gltf(object.model, {}, object.scene);
  if (!model) return fail(model.error());
  make_levels(*model);
  content->model = std::make_shared<const Model>(std::move(*model));
  return Rehearsed{std::move(content), {}};
}

Result<Rehearsed> rehearsed(const fs::path& given) {
  std::error_code error;
  const bool folder = fs::is_directory(given, error);
  if (folder && fs::exists(given / "fixture.toml", error)) return of_recording(given);
  auto content = read_content(folder ? given / "kasumi.toml" : given);
  if (!content) return fail(content.error());
  return Rehearsed{*content, (*content)->config.opening.time_zone};
}

std::string label_of(std::chrono::local_time<Duration> wall, double turbidity) {
  constexpr std::array kNames{"Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
  const auto day = std::chrono::floor<std::chrono::days>(wall);
  const std::chrono::year_month_day date(day);
  const std::chrono::hh_mm_ss time(std::chrono::floor<std::chrono::minutes>(wall - day));
  return fmt::format("{} {} {:02}:{:02}  T {:g}", static_cast<unsigned>(date.day()),
                     kNames.at(static_cast<unsigned>(date.month()) - 1), time.hours().count(), time.minutes().count(),
                     turbidity);
}

PanelReader reader_at(const std::optional<VisitorOptions>& visitor) {
  if (!visitor) return {};
  return {visitor->left_handed, visitor->seated, false, visitor->pixels_per_degree};
}

class Rehearsal {
 public:
  Rehearsal(const RehearseArguments& arguments, const Rehearsed& what, GlContext& context)
      : arguments_(arguments), what_(what), context_(context) {}

  Result<> write_sheets() {
    Progress progress("rehearse", arguments_.turbidities.size() * kMonths * arguments_.hours.size());
    for (std::size_t air = 0; air < kAirNames.size(); ++air) {
      ContactSheet sheet;
      for (int month = 1; month <= kMonths; ++month)
        for (const int hour : arguments_.hours) {
          if (auto added = add(wall(month, hour * 60), arguments_.turbidities[air], sheet); !added) return added;
          progress.advance(kAirNames[air]);
        }
      const auto file = fs::path(arguments_.out) / fmt::format("{}.png", kAirNames[air]);
      if (auto written = write_png(file, sheet.drawn(static_cast<int>(arguments_.hours.size()))); !written)
        return written;
      progress.clear();
      fmt::print("written: {}\n", file.string());
    }
    return {};
  }

  // A sheet for each language: every story as a visitor reads it, in an era in which it is told.
  Result<> write_stories() {
    const auto& visitor = what_.content->visitor;
    if (!visitor || visitor->stories.empty()) return {};
    const auto eras = all_eras(what_.content);
    const int noon = 12 * 60;
    for (const auto& language : visitor->languages) {
      ContactSheet sheet(kStoryWidth);
      Progress progress("rehearse", visitor->stories.size());
      for (const Story& story : visitor->stories) {
        const auto era = std::ranges::find_if(eras, [&](const auto& one) { return is_told_in(story, era_name(*one)); });
        const auto& content = era == eras.end() ? what_.content : *era;
        auto picture = drawn(content, kStoryWidth, wall(kStoryMonth, noon), arguments_.turbidities[1]);
        if (!picture) return fail(picture.error());
        const StoryView view{story.title.at(language), story.text.at(language), language,
                             reader_at(content->config.visitor)};
        if (auto laid = lay_story_over(*picture, view, *content, kiosk_); !laid)
          fmt::print("{}: {}.text.{} ({}): {}\n", visitor->file.string(), story.key, language, story.name,
                     laid.error().message);
        const auto name = era_name(*content);
        sheet.add(*picture, name.empty() ? story.name : fmt::format("{} ({})", story.name, name));
        progress.advance(language);
      }
      const auto file = fs::path(arguments_.out) / fmt::format("stories-{}.png", language);
      const auto columns = std::min<std::size_t>(kStoryColumns, visitor->stories.size());
      if (auto written = write_png(file, sheet.drawn(static_cast<int>(columns))); !written) return written;
      progress.clear();
      fmt::print("written: {}\n", file.string());
    }
    return {};
  }

  // A day of each month from dawn to dusk, under the usual air.
  Result<> write_film() {
    const auto file = fs::path(arguments_.out) / "year.mp4";
    auto film = open_film(file, arguments_.frames_per_second);
    if (!film) return fail(film.error());
    for (int month = 1; month <= kMonths; ++month)
      for (int minute = 0; minute < 24 * 60; minute += arguments_.film_minutes) {
        const auto time = wall(month, minute);
        if (brightness_under(sun_position(utc(time), site()).direction) < 0.01) continue;  // a black picture
        ContactSheet labelled;
        if (auto added = add(time, arguments_.turbidities[1], labelled); !added) return added;
        if (auto put = (*film)->put(labelled.drawn(1)); !put) return put;
      }
    if (auto finished = (*film)->finish(); !finished) return finished;
    fmt::print("written: {}\n", file.string());
    return {};
  }

 private:
  const Site& site() const { return what_.content->config.installation.site; }

  std::chrono::local_time<Duration> wall(int month, int minute) const {
    const std::chrono::year_month_day date(std::chrono::year(arguments_.year),
                                           std::chrono::month(static_cast<unsigned>(month)),
                                           std::chrono::day(static_cast<unsigned>(arguments_.day)));
    return std::chrono::local_days(date) + std::chrono::minutes(minute);
  }

  Utc utc(std::chrono::local_time<Duration> time) const { return utc_of(time, what_.time_zone, site().longitude_deg); }

  Result<> add(std::chrono::local_time<Duration> time, double turbidity, ContactSheet& sheet) {
    const auto picture = drawn(what_.at(utc(time)), kCellWidth, time, turbidity);
    if (!picture) return fail(picture.error());
    sheet.add(*picture, label_of(time, turbidity));
    return {};
  }

  Result<Image<Rgb8>> drawn(const ContentPtr& content, int width, std::chrono::local_time<Duration> time,
                            double turbidity) {
    if (content != shown_ || width != width_ || turbidity != turbidity_) {
      view_.reset();
      shown_ = content;
      width_ = width;
      kiosk_ = with_small_scene(content->config.installation, width);
      turbidity_ = turbidity;
      auto made = RehearsedView::create(context_, kiosk_, *content->model, Turbidity{turbidity});
      if (!made) return fail(made.error());
      view_ = std::move(*made);
    }
    return view_->draw(utc(time));
  }

  const RehearseArguments& arguments_;
  const Rehearsed& what_;
  GlContext& context_;
  ContentPtr shown_;
  Installation kiosk_;
  int width_ = 0;  // of its pictures at most
  double turbidity_ = 0.0;
  std::optional<RehearsedView> view_;
};

Result<int> rehearse(const RehearseArguments& arguments) {
  const auto what = rehearsed(arguments.kiosk);
  if (!what) return fail(what.error());
  for (const auto& note : model_notes(*what->content)) fmt::print("{}\n", note);
  std::error_code error;
  fs::create_directories(arguments.out, error);
  if (error) return fail(FaultKind::io, "--out {}: {}", arguments.out, error.message());
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  Rehearsal rehearsal(arguments, *what, **context);
  if (auto written = rehearsal.write_sheets(); !written) return fail(written.error());
  if (auto written = rehearsal.write_stories(); !written) return fail(written.error());
  if (arguments.film)
    if (auto written = rehearsal.write_film(); !written) return fail(written.error());
  fmt::print("hours: {}\n", what->time_zone.empty() ? "by the mean sun of the site ([opening] time_zone names none)"
                                                    : "by the clock of " + what->time_zone);
  return 0;
}

}  // namespace

void add_rehearse_command(CLI::App& app, Action& action) {
  auto* command =
      app.add_subcommand("rehearse", "A year of hours and airs at the site as sheets, before a camera is mounted");
  auto arguments = std::make_shared<RehearseArguments>();
  command->add_option("kiosk", arguments->kiosk, "kasumi.toml, or a folder that holds one, or a recording's folder")
      ->required();
  command
      ->add_option("--out", arguments->out, "Folder for clear.png, usual.png, hazy.png, stories-en.png, and year.mp4")
      ->required();
  command->add_option("--year", arguments->year, "The year")->check(CLI::Range(1970, 2200))->capture_default_str();
  command->add_option("--day", arguments->day, "The day of each month")
      ->check(CLI::Range(1, 28))
      ->capture_default_str();
  command->add_option("--hours", arguments->hours, "Hours of the day, 12 at most: 6,9,12,15,18")
      ->delimiter(',')
      ->expected(1, kMostHours)
      ->check(CLI::Range(0, 23))
      ->capture_default_str();
  command->add_option("--turbidity", arguments->turbidities, "T of the clear, the usual and the hazy air: 2,3,8")
      ->delimiter(',')
      ->expected(3)
      ->check(CLI::Range(1.7, 10.0))
      ->capture_default_str();
  command->add_flag("--film", arguments->film,
                    "Also year.mp4: a day of each month from dawn to dusk, in the usual air");
  command->add_option("--film-minutes", arguments->film_minutes, "Of the day, from one picture of the film to the next")
      ->check(CLI::Range(1, 240))
      ->capture_default_str();
  command->add_option("--fps", arguments->frames_per_second, "Frame rate of the film")
      ->check(CLI::Range(1.0, 120.0))
      ->capture_default_str();
  command->callback([arguments, &action] { action = [arguments] { return rehearse(*arguments); }; });
}

}  // namespace kasumi

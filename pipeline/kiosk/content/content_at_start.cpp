#include "pipeline/kiosk/content/content_at_start.hpp"

#include <spdlog/spdlog.h>

#include "base/outside/abandonable.hpp"
#include "base/outside/lines.hpp"
#include "base/utc_text.hpp"
#include "pipeline/kiosk/content/bundle.hpp"
#include "pipeline/kiosk/start/kept_content.hpp"

namespace kasumi {

namespace {

using Problem = std::vector<std::string>;

// The longest seen are some seconds; the unit waits for a minute.
constexpr std::chrono::seconds kReadingDeadline{20};

Problem failed_starts() {
  return {fmt::format("{} starts in a row have failed with it", kStartsBeforeKeptContent)};
}

void log_instead(Utc since, const Problem& problems) {
  spdlog::error("the configured content is not used, shown is what worked until {}:",
                utc_text(std::chrono::floor<std::chrono::seconds>(since)));
  for (const auto& problem : problems) spdlog::error("  {}", problem);
}

// Differs from what was signed: damaged, or changed since.
Result<ContentPtr> read_generation(const Generations& generations, const Generation& generation) {
  auto content = read_content_within(kReadingDeadline, generations.config_of(generation));
  if (!content) return content;
  const auto whole =
      within<Result<>>(kReadingDeadline, [folder = generations.folder_of(generation), manifest = generation.manifest] {
        return check_unpacked(folder, manifest);
      });
  if (!whole) return fail(FaultKind::io, "{}: the disk does not answer", generations.folder_of(generation).string());
  if (!*whole) return fail(whole->error());
  return content;
}

// Set up by hand.
Result<ContentPtr> by_hand_or_kept(const std::filesystem::path& config, const StartLog& starts,
                                   const std::filesystem::path& kept_folder) {
  auto configured = read_content_within(kReadingDeadline, config);
  const bool suspect = configured && suspects_content(starts.record()) && !is_kept(**configured, kept_folder);
  if (kept_folder.empty() || (configured && !suspect)) return configured;
  auto problems = configured ? failed_starts() : lines_of(configured.error().message);
  auto kept = read_kept_content(config, kept_folder, problems);
  if (!kept) {
    spdlog::info("no earlier content to show instead: {}", kept.error().message);
    return configured;
  }
  log_instead((*kept)->instead->kept_utc, problems);
  return kept;
}

ContentPtr shown_instead(const ContentPtr& content, Utc since, Problem problems) {
  log_instead(since, problems);
  auto instead = std::make_shared<Content>(*content);
  instead->instead = InsteadOfConfigured{since, std::move(problems)};
  return instead;
}

void go_back(const Generations& generations, const Generation& generation, const Problem& problems, Utc now) {
  spdlog::error("the content {} ({}) goes back, and is not tried again:", generation.manifest.name, generation.id);
  for (const auto& problem : problems) spdlog::error("  {}", problem);
  const auto why = problems.empty() ? std::string("refused") : problems.front();
  const auto more = problems.size() > 1 ? fmt::format(" (and {} more)", problems.size() - 1) : "";
  if (auto gone = generations.go_back(generation.id, now, why + more); !gone)
    spdlog::error("the content cannot go back: {}", gone.error().message);
}

}  // namespace

Result<ContentPtr> content_instead(const ContentPlace& place, const Content& refused,
                                   const std::filesystem::path& kept_folder, std::vector<std::string> problems,
                                   Utc now) {
  const auto& generations = place.generations;
  const auto& config = refused.files.empty() ? place.config : refused.files.front().path;
  if (const auto generation = generations.of(config)) {
    const auto before = generations.before(generation->id);
    auto earlier = before ? read_generation(generations, *before) : read_content_within(kReadingDeadline, place.config);
    if (!earlier) return earlier;
    if (generation->proven) return shown_instead(*earlier, before ? *before->proven : now, std::move(problems));
    go_back(generations, *generation, problems, now);
    return earlier;
  }
  if (refused.instead || kept_folder.empty() || is_kept(refused, kept_folder))
    return fail(FaultKind::bad_input, "this is what worked last");
  auto kept = read_kept_content(place.config, kept_folder, problems);
  if (kept) log_instead((*kept)->instead->kept_utc, problems);
  return kept;
}

Result<ContentPtr> content_at_start(const ContentPlace& place, StartLog& starts,
                                    const std::filesystem::path& kept_folder, Utc now) {
  const auto& generations = place.generations;
  const auto current = generations.current();
  if (!current) return by_hand_or_kept(place.config, starts, kept_folder);
  auto content = read_generation(generations, *current);
  const bool suspect = current->on_probation() && current->starts >= kStartsBeforeKeptContent;
  const bool is_going_back = current->went_back.has_value();
  if (content && !suspect && !is_going_back) {
    if (current->on_probation())
      starts.note_too("generation", [generations, id = current->id] {
        if (auto noted = generations.note_start(id); !noted)
          spdlog::warn("the start is not counted: {}", noted.error().message);
      });
    return content;
  }
  const auto problems = is_going_back ? Problem{current->went_back->why}
                        : content     ? failed_starts()
                                      : lines_of(content.error().message);
  const auto before = generations.before(current->id);
  auto earlier = before ? read_generation(generations, *before) : by_hand_or_kept(place.config, starts, kept_folder);
  if (!earlier) {
    spdlog::error("no earlier content to show instead: {}", earlier.error().message);
    return content;
  }
  const bool may_pass = !content && content.error().kind == FaultKind::io;
  if (!is_going_back && (current->proven || may_pass))
    return shown_instead(*earlier, before ? *before->proven : now, problems);
  go_back(generations, *current, problems, now);
  return earlier;
}

}  // namespace kasumi

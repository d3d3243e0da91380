#include "pipeline/content/content_at_start.hpp"

#include <sstream>

#include <spdlog/spdlog.h>

#include "base/utc_text.hpp"
#include "pipeline/start/kept_content.hpp"

namespace kasumi {

namespace {

using Problem = std::vector<std::string>;

Problem problems_in(const std::string& message) {
  Problem lines;
  std::istringstream stream(message);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

Problem failed_starts() {
  return {fmt::format("{} starts in a row have failed with it", kStartsBeforeKeptContent)};
}

void log_instead(Utc since, const Problem& problems) {
  spdlog::error("the configured content is not used, shown is what worked until {}:",
                utc_text(std::chrono::floor<std::chrono::seconds>(since)));
  for (const auto& problem : problems) spdlog::error("  {}", problem);
}

// Set up by hand.
Result<ContentPtr> by_hand_or_kept(const std::filesystem::path& config, const StartLog& starts,
                                   const std::filesystem::path& kept_folder) {
  auto configured = read_content(config);
  const bool suspect = configured && suspects_content(starts.record()) && !is_kept(**configured, kept_folder);
  if (kept_folder.empty() || (configured && !suspect)) return configured;
  auto problems = configured ? failed_starts() : problems_in(configured.error().message);
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

Result<ContentPtr> content_at_start(const ContentPlace& place, const StartLog& starts,
                                    const std::filesystem::path& kept_folder, Utc now) {
  const auto& generations = place.generations;
  const auto current = generations.current();
  if (!current) return by_hand_or_kept(place.config, starts, kept_folder);
  auto content = read_content(generations.config_of(*current));
  const bool suspect = current->on_probation() && current->starts >= kStartsBeforeKeptContent;
  const bool is_going_back = current->went_back.has_value();
  if (content && !suspect && !is_going_back) {
    if (current->on_probation())
      if (auto noted = generations.note_start(current->id); !noted)
        spdlog::warn("the start is not counted: {}", noted.error().message);
    return content;
  }
  const auto problems = is_going_back ? Problem{current->went_back->why}
                        : content     ? failed_starts()
                                      : problems_in(content.error().message);
  const auto before = generations.before(current->id);
  auto earlier =
      before ? read_content(generations.config_of(*before)) : by_hand_or_kept(place.config, starts, kept_folder);
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

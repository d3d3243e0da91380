#include "pipeline/lab/archive/merge_parts.hpp"

#include <memory>

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "pipeline/lab/archive/record_lines.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kMostTold = 10;               // problems of one kind
constexpr std::size_t kMostPictures = 100'000'000;  // a number beyond is no list's length

}  // namespace

void WholeArchive::read_part(std::size_t part, Problems& problems) {
  const auto name = parts_[part].string();
  RecordLines lines(parts_[part]);
  if (!lines.opened()) return problems.add("{}: cannot be read", name);
  std::size_t number = 0, twice = 0;
  while (lines.next()) {
    ++number;
    const auto place = place_in(lines.line());
    if (!place && !lines.whole())
      return problems.add("{}: line {} is torn: its task has not ended, expected --resume to go on with it", name,
                          number);
    if (!place || place->archive.pictures > kMostPictures)
      return problems.add("{}: line {}: expected a record of `kasumi estimate --out`", name, number);
    if (places_.empty()) {
      archive_ = place->archive;
      places_.resize(archive_.pictures);
    }
    if (place->archive.pictures != archive_.pictures || place->archive.list != archive_.list)
      return problems.add("{}: line {} is of another list of pictures than {}", name, number, parts_.front().string());
    if (place->archive.options != archive_.options)
      return problems.add("{}: line {} was made with other options than {}", name, number, parts_.front().string());
    auto& known = places_[place->picture - 1];
    if (known.known && ++twice <= kMostTold)
      problems.add("{}: line {}: picture {} is there already, in {}", name, number, place->picture,
                   parts_[known.part].string());
    known = {lines.begin(), static_cast<std::uint32_t>(part), true};
  }
  if (lines.too_long()) problems.add("{}: line {}: longer than any record", name, number + 1);
  if (twice > kMostTold) problems.add("{}: {} more are there already", name, twice - kMostTold);
}

void WholeArchive::tell_missing(Problems& problems) const {
  std::size_t gaps = 0, missing = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (places_[i].known) continue;
    const std::size_t first = i;
    while (i < places_.size() && !places_[i].known) ++i;
    missing += i - first;
    if (++gaps > kMostTold) continue;
    if (i - first == 1)
      problems.add("picture {} of {} is in no part", i, places_.size());
    else
      problems.add("pictures {} to {} of {} are in no part", first + 1, i, places_.size());
  }
  if (gaps > kMostTold) problems.add("{} pictures are missing in all", missing);
}

Result<WholeArchive> WholeArchive::prove(const std::vector<std::filesystem::path>& parts) {
  WholeArchive whole;
  whole.parts_ = parts;
  Problems problems;
  for (std::size_t i = 0; i < parts.size(); ++i) whole.read_part(i, problems);
  if (whole.places_.empty() && problems.empty()) problems.add("--merge: no part has any record");
  whole.tell_missing(problems);
  if (!problems.empty()) return fail(problems.fault());
  return whole;
}

Result<> WholeArchive::for_each(
    const std::function<Result<>(std::string_view line, const nlohmann::json& record)>& take) const {
  std::unique_ptr<RecordLines> lines;
  std::size_t open = parts_.size();
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const auto& place = places_[i];
    if (place.part != open) {
      open = place.part;
      lines = std::make_unique<RecordLines>(parts_[open]);
    }
    lines->go_to(place.begin);
    const bool read = lines->next();
    const auto record = read ? parse_json(lines->line()) : nlohmann::json();
    if (!record.is_object() || !record.contains("archive"))
      return fail(FaultKind::bad_input, "{}: picture {} is no JSON: its part is damaged, or changed meanwhile",
                  parts_[open].string(), i + 1);
    if (auto taken = take(lines->line(), record); !taken) return taken;
  }
  return {};
}

}  // namespace kasumi

#include "pipeline/lab/archive/archive_record.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "base/utc_text.hpp"

namespace kasumi {
namespace {

constexpr std::string_view kPlace = ",\"archive\":{";

std::string record_of(nlohmann::ordered_json answer, const std::optional<Utc>& utc, std::string_view refused,
                      const ArchivePlace& place) {
  answer["utc"] = nullptr;
  if (utc) answer["utc"] = utc_text(*utc);
  answer["refused"] = nullptr;
  if (!refused.empty()) answer["refused"] = refused;
  answer["archive"] = {{"picture", place.picture},
                       {"of", place.archive.pictures},
                       {"list", place.archive.list},
                       {"options", place.archive.options}};
  // File names need not be UTF-8.
  return text_of_json(answer) + "\n";
}

}  // namespace

void Fingerprint::add(std::string_view text) {
  for (const char c : text) hash_ = (hash_ ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  hash_ = (hash_ ^ 0xffu) * 0x100000001b3u;  // no byte of UTF-8: "ab", "c" is not "a", "bc"
}

std::string Fingerprint::text() const {
  return fmt::format("{:016x}", hash_);
}

std::string archive_record(std::string_view answer, const std::optional<Utc>& utc, std::string_view refused,
                           const ArchivePlace& place) {
  return record_of(parse_ordered_json(answer), utc, refused, place);
}

std::string unread_record(const std::string& image, const std::optional<Utc>& utc, const std::string& reason,
                          const ArchivePlace& place) {
  nlohmann::ordered_json answer;
  answer["image"] = image;
  answer["usable"] = false;
  answer["reason"] = reason;
  return record_of(std::move(answer), utc, "could not be read", place);
}

std::string exposure_record(const std::string& image, const std::optional<Utc>& utc, const std::string& whole,
                            const ArchivePlace& place) {
  nlohmann::ordered_json answer;
  answer["image"] = image;
  answer["usable"] = false;
  answer["reason"] = "one exposure of the stack that is answered under " + whole;
  answer["stack_of"] = whole;
  return record_of(std::move(answer), utc, kExposureOfStack, place);
}

std::optional<ArchivePlace> place_in(std::string_view line) {
  const auto at = line.rfind(kPlace);
  if (at == std::string_view::npos || line.front() != '{' || line.back() != '}' ||
      line.find('\0') != std::string_view::npos)
    return std::nullopt;
  const auto begin = at + kPlace.size() - 1;
  const auto place = parse_json(line.substr(begin, line.size() - begin - 1));
  if (!place.is_object()) return std::nullopt;
  const auto count = [&](const char* key) {
    return place.contains(key) && place[key].is_number_unsigned() ? place[key].get<std::size_t>() : 0;
  };
  const auto text = [&](const char* key) {
    return place.contains(key) && place[key].is_string() ? place[key].get<std::string>() : std::string();
  };
  ArchivePlace found{count("picture"), {count("of"), text("list"), text("options")}};
  if (found.picture < 1 || found.picture > found.archive.pictures) return std::nullopt;
  return found;
}

}  // namespace kasumi

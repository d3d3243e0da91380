#include "pipeline/kiosk/visitor/visitor_presses.hpp"

#include <charconv>

#include "base/files.hpp"
#include "base/utc_text.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr std::size_t kFewestCounts = 5;               // older files lack the keys that came later
constexpr auto kPressesKept = std::chrono::days(396);  // 13 months
constexpr std::uint64_t kMostPresses = 1'000'000'000;  // in an hour

std::string_view cut(std::string_view& text, char at) {
  const auto end = std::min(text.find(at), text.size());
  const auto part = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return part;
}

}  // namespace

PressesByHour read_presses(std::string_view text) {
  PressesByHour presses;
  while (!text.empty()) {
    auto line = cut(text, '\n');
    const auto hour = parse_utc(cut(line, ','));
    if (!hour || *hour != std::chrono::floor<std::chrono::hours>(*hour)) continue;
    std::array<std::uint64_t, kHandKeys> counts{};
    bool whole = true;
    for (std::size_t i = 0; i < kHandKeys && (i < kFewestCounts || !line.empty()); ++i) {
      const auto part = cut(line, ',');
      auto& count = counts[i];
      const auto read = std::from_chars(part.data(), part.data() + part.size(), count);
      whole = whole && read.ec == std::errc{} && read.ptr == part.data() + part.size() && count <= kMostPresses;
    }
    if (whole && line.empty()) presses[*hour] = counts;
  }
  return presses;
}

std::string presses_text(const PressesByHour& presses) {
  auto text = fmt::format("hour_utc,{}\n", fmt::join(kHandKeyNames, ","));
  for (const auto& [hour, counts] : presses) text += fmt::format("{},{}\n", utc_text(hour), fmt::join(counts, ","));
  return text;
}

Result<> add_presses(const std::filesystem::path& file, const PressesByHour& fresh, Utc now) {
  const auto text = read_text_file(file, kSmallFile);
  auto presses = text ? read_presses(*text) : PressesByHour{};
  std::erase_if(presses, [&](const auto& entry) { return entry.first < now - kPressesKept || entry.first > now; });
  for (const auto& [hour, counts] : fresh)
    for (std::size_t i = 0; i < kHandKeys; ++i) presses[hour][i] = std::min(presses[hour][i] + counts[i], kMostPresses);
  return write_text_file(file, presses_text(presses));
}

}  // namespace kasumi

#include "pipeline/kiosk/content/floor.hpp"

#include "base/files.hpp"
#include "base/utc_text.hpp"

namespace kasumi {

namespace {

constexpr Utc kThisProgram = std::chrono::sys_days{std::chrono::January / 1 / 2026};

}  // namespace

std::optional<Utc> latest_believable(Utc now, bool clock_trusted) {
  if (clock_trusted) return now + std::chrono::days(1);
  if (now >= kThisProgram) return now + std::chrono::days(366);
  return std::nullopt;
}

std::optional<Utc> read_floor(const std::filesystem::path& folder, const std::optional<Utc>& latest) {
  auto text = read_text_file(folder / "floor", {.most_bytes = 100}).value_or("");
  while (text.ends_with('\n')) text.pop_back();
  const auto floor = parse_utc(text);
  return floor && latest && *floor > *latest ? std::nullopt : floor;
}

Result<> raise_floor(const std::filesystem::path& folder, Utc to, const std::optional<Utc>& latest) {
  const auto floor = read_floor(folder, latest);
  return floor && *floor >= to ? Result<>() : set_floor(folder, to);
}

Result<> set_floor(const std::filesystem::path& folder, Utc to) {
  return write_text_file(folder / "floor", utc_text(std::chrono::floor<std::chrono::seconds>(to)) + "\n");
}

}  // namespace kasumi

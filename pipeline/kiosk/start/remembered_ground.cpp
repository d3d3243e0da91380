#include "pipeline/kiosk/start/remembered_ground.hpp"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "base/files.hpp"
#include "base/utc_text.hpp"

namespace kasumi {

namespace {

constexpr Duration kKeepInterval = std::chrono::hours(1);  // half a megabyte each time: flash memory wears
// Any version; the version that is written.
constexpr std::string_view kEveryKind = "kasumi-ground-", kKind = "kasumi-ground-1";
// What was learnt while the clock was wrong goes by a sun that stood elsewhere: by a degree, in so long.
constexpr Duration kClockError = std::chrono::minutes(4);

std::filesystem::path ground_file(const std::filesystem::path& folder) {
  return folder / "ground.bin";
}

// One line of text, then the shares.
Result<GroundState> parsed(const std::vector<std::uint8_t>& bytes) {
  const auto end = std::ranges::find(bytes, std::uint8_t{'\n'});
  if (end == bytes.end()) return fail(FaultKind::bad_input, "damaged");
  std::istringstream line(std::string(bytes.begin(), end));
  std::string kind, utc, ground;
  std::size_t count = 0;
  line >> kind >> utc >> ground >> count;
  if (kind != kKind && kind.starts_with(kEveryKind)) return fail(FaultKind::bad_input, "of another version of kasumi");
  const auto when = parse_utc(utc);
  if (!line || kind != kKind || !when || static_cast<std::size_t>(bytes.end() - end) != count + 1)
    return fail(FaultKind::bad_input, "damaged");
  return GroundState{*when, ground, {end + 1, bytes.end()}};
}

// Goes on from what was kept. Errors: as load_ground_state(), and what was kept of another ground or time to come.
Result<> resume(GroundWatch& ground, const std::filesystem::path& folder, Utc now) {
  const auto kept = load_ground_state(folder);
  if (!kept) return fail(kept.error());
  if (!*kept) return {};
  const auto& state = **kept;
  const auto file = ground_file(folder).string();
  if (state.utc > now + kClockError)
    return fail(FaultKind::bad_input, "{}: learnt at {}, which is still to come", file, utc_text(state.utc));
  const double since_s = std::max(0.0, to_seconds(now - state.utc));
  if (const auto resumed = ground.resume({state.ground, state.shares}, since_s); !resumed)
    return fail(FaultKind::bad_input, "{}: {}", file, resumed.error().message);
  return {};
}

}  // namespace

Result<> save(const GroundState& state, const std::filesystem::path& folder) {
  const auto kept = load_ground_state(folder);
  if (kept && *kept && (*kept)->ground == state.ground && (*kept)->shares == state.shares) return {};
  const auto line = fmt::format("{} {} {} {}\n", kKind, utc_text(state.utc), state.ground, state.shares.size());
  std::vector<std::uint8_t> bytes(line.begin(), line.end());
  bytes.insert(bytes.end(), state.shares.begin(), state.shares.end());
  return write_file(ground_file(folder), bytes);
}

Result<std::optional<GroundState>> load_ground_state(const std::filesystem::path& folder) {
  const auto file = ground_file(folder);
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return std::optional<GroundState>();
  const auto bytes = read_file(file);
  if (!bytes) return fail(bytes.error());
  auto state = parsed(*bytes);
  if (!state) return fail(FaultKind::bad_input, "{}: {}", file.string(), state.error().message);
  return std::move(*state);
}

void GroundKeeper::recall(const std::shared_ptr<GroundWatch>& ground,
                          const std::optional<std::filesystem::path>& folder) {
  if (ground == ground_) return;
  if (ground_ && ground_->lessons() != kept_lessons_) write(folder);
  ground_ = ground;
  kept_lessons_ = ground->lessons();
  kept_at_ = clock_.now();
  if (!folder || kept_lessons_ > 0) return;
  if (const auto resumed = resume(*ground, *folder, clock_.utc()); !resumed)
    spdlog::warn("ground: {}; learning anew which of it lies in the sun", resumed.error().message);
}

void GroundKeeper::keep(const std::optional<std::filesystem::path>& folder) {
  if (ground_ && ground_->lessons() != kept_lessons_ && clock_.now() - kept_at_ >= kKeepInterval) write(folder);
}

void GroundKeeper::write(const std::optional<std::filesystem::path>& folder) {
  kept_at_ = clock_.now();
  kept_lessons_ = ground_->lessons();
  if (!folder) return;
  auto learnt = ground_->learnt();
  const auto saved = save(GroundState{clock_.utc(), std::move(learnt.ground), std::move(learnt.shares)}, *folder);
  if (!saved && !save_failing_) spdlog::warn("ground: {}", saved.error().message);
  save_failing_ = !saved;
}

}  // namespace kasumi

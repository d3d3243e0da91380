// What an appliance has learnt of the ground around its building, kept on disk: as remembered_state.hpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "pipeline/show/scene/ground_watch.hpp"

namespace kasumi {

struct GroundState {
  Utc utc{};                         // of what was learnt last
  std::string ground;                // which; without spaces
  std::vector<std::uint8_t> shares;  // some hundred kB
};

// folder/ground.bin, unless it holds the same shares. Error: io.
Result<> save(const GroundState& state, const std::filesystem::path& folder);
// Empty: nothing was saved there. Errors: bad_input (not written by save(), or by another version's), io.
Result<std::optional<GroundState>> load_ground_state(const std::filesystem::path& folder);

// Reads it before the ground is looked at for the first time, and writes it every hour in which there was something to
// learn. A file that cannot be used (damaged, of another ground, view or version, later than now) is logged and
// learning begins anew. `folder`: empty: nothing is kept.
class GroundKeeper {
 public:
  explicit GroundKeeper(const Clock& clock) : clock_(clock) {}
  void recall(const std::shared_ptr<GroundWatch>& ground, const std::optional<std::filesystem::path>& folder);
  void keep(const std::optional<std::filesystem::path>& folder);  // what was recalled last

 private:
  void write(const std::optional<std::filesystem::path>& folder);

  const Clock& clock_;
  std::shared_ptr<GroundWatch> ground_;
  int kept_lessons_ = 0;
  Instant kept_at_{};
  bool save_failing_ = false;  // already logged
};

}  // namespace kasumi

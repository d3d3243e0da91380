#include "capture/fixture.hpp"

namespace kasumi {

FixtureInfo read_fixture_info(const ConfigTable& root) {
  // A newer format may mean other things by the same words, so nothing is guessed.
  if (root.integer("format", {}, kFixtureFormat) != kFixtureFormat || !root.has("format"))
    root.problem("format", fmt::format("{}, the format this program knows", kFixtureFormat));
  FixtureInfo info;
  info.name = root.text("name");
  info.description = root.text("description", "");
  info.licence = root.text("licence");
  info.provenance = root.text("provenance");
  info.start_utc = root.utc("start_utc");
  return info;
}

}  // namespace kasumi

// A fixture's description, whole: what the recording is and what was recorded with.
#pragma once

#include <filesystem>

#include "base/result.hpp"
#include "capture/fixture.hpp"
#include "pipeline/installation.hpp"

namespace kasumi {

struct Fixture {
  std::filesystem::path folder;
  FixtureInfo info;
  Installation installation;
};

// folder/fixture.toml. Errors (bad_input): every problem of it at once.
Result<Fixture> read_fixture(const std::filesystem::path& folder);

}  // namespace kasumi

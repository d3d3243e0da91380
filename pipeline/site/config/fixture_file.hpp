// A fixture's complete description: the recording and the installation that recorded it.
#pragma once

#include <filesystem>

#include "base/result.hpp"
#include "capture/fixture/fixture.hpp"
#include "capture/fixture/recording_reader.hpp"
#include "pipeline/site/config/installation.hpp"

namespace kasumi {

struct Fixture {
  std::filesystem::path folder;
  FixtureInfo info;
  Installation installation;
};

// folder/fixture.toml. Errors (bad_input): all its problems at once.
Result<Fixture> read_fixture(const std::filesystem::path& folder);

// The recorded pictures of `camera`, by its name; its encoding and size override those in the options.
Result<PicturesRead> for_each_picture(const Fixture& fixture, const Camera& camera, FrameSelection options,
                                      const std::function<void(const PictureView&, const FrameMetadata&)>& use);

}  // namespace kasumi

// A fixture's description, whole: what the recording is and what was recorded with.
#pragma once

#include <filesystem>

#include "base/result.hpp"
#include "capture/fixture/fixture.hpp"
#include "capture/fixture/recording_reader.hpp"
#include "pipeline/config/installation.hpp"

namespace kasumi {

struct Fixture {
  std::filesystem::path folder;
  FixtureInfo info;
  Installation installation;
};

// folder/fixture.toml. Errors (bad_input): every problem of it at once.
Result<Fixture> read_fixture(const std::filesystem::path& folder);

// The pictures of its camera of that name; encoding and size are the camera's, whatever the options say.
Result<PicturesRead> for_each_picture(const Fixture& fixture, const Camera& camera, ReadingOptions options,
                                      const std::function<void(const PictureView&, const FrameMetadata&)>& use);

}  // namespace kasumi

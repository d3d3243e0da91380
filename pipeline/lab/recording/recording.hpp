// A recording in progress: the fixture's folder, both cameras' frames, and its limits.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>

#include "capture/fixture/fixture_writer.hpp"
#include "pipeline/machine/devices.hpp"

namespace kasumi {

struct RecordingLimits {
  std::uint64_t most_bytes = 4'000'000'000;  // of both cameras together
  std::uint64_t keep_free = 500'000'000;     // bytes of the disk to keep free
};

// Where a recording's frames come from, for its description: "live cameras", "a recording (live/)", or both.
std::string sources_text(const RunConfig& config);

// Thread-safe.
class Recording {
 public:
  // Creates the folder: fixture.toml with the configuration's site, cameras and building, the files these name, and two
  // empty indexes. Once each camera has a row, the recording can be replayed whenever it is interrupted.
  // Errors: bad_input (all problems of the configuration; the folder already contains a recording), io.
  static Result<std::unique_ptr<Recording>> create(const std::filesystem::path& config_file,
                                                   const std::filesystem::path& folder, Utc start,
                                                   const RecordingLimits& limits);

  // BLOCKS until the frame is on the disk. Bad frames are kept unchanged. Errors: io (disk full: earlier frames stay
  // intact); bad_input (a frame of impossible geometry: not kept, the recording can go on); end_of_stream (a limit is
  // reached: not kept).
  Result<> keep(CameraRole role, const Frame& frame);
  Result<> keep_disconnect(CameraRole role, Instant at, Utc utc);

  int rows(CameraRole role) const;
  std::uint64_t bytes() const;

 private:
  Recording(std::filesystem::path folder, RecordingLimits limits, FixtureWriter sky, FixtureWriter scene)
      : folder_(std::move(folder)), limits_(limits), writers_{std::move(sky), std::move(scene)} {}
  FixtureWriter& writer(CameraRole role) { return writers_[role == CameraRole::sky ? 0 : 1]; }
  Result<> check_limits(std::uint64_t more) const;

  std::filesystem::path folder_;
  RecordingLimits limits_;
  mutable std::array<std::mutex, 2> mutexes_;  // one per camera, so that they do not wait for each other's writes
  std::array<FixtureWriter, 2> writers_;
  std::array<std::atomic<std::uint64_t>, 2> bytes_{};
  std::array<std::atomic<int>, 2> rows_{};
};

}  // namespace kasumi

// `kasumi estimate` over an archive: a shard of its list into a part, all parts into one table and a page.
#pragma once

#include <cstddef>

#include "base/result.hpp"
#include "pipeline/lab/archive/part_file.hpp"
#include "pipeline/lab/archive/shard.hpp"
#include "pipeline/lab/photographs/estimate_inputs.hpp"

namespace kasumi {

struct ArchiveRun {
  Shard shard;
  PartPlan plan;
  PartFile part;
};

// Opens the part of --out; what it lacks is left in `inputs`. Reads the files of --calibration and --camera-memory for
// their fingerprint. Errors: bad_input (options that go without --out only, no such shard, as PartFile::open()), io.
Result<ArchiveRun> open_archive_run(const EstimateRequest& arguments, EstimateInputs& inputs);

// --learn-camera: writes what a sample of the pictures tells. Exit code 1: no camera is known by it. Errors: io.
Result<int> learn_camera_of_archive(const EstimateRequest& arguments, EstimateInputs& inputs, std::size_t threads);

// --merge. Errors: bad_input (the parts are not the whole of one archive: what is missing), io.
Result<int> merge_archive(const EstimateRequest& arguments);

}  // namespace kasumi

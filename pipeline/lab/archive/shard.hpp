// Which part of a list of pictures one process works on: given, or by the job array that it is a task of.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "base/result.hpp"

namespace kasumi {

struct Shard {
  std::size_t index = 0, count = 1;  // from 0
  std::string from;                  // "--shard", "SLURM_ARRAY_TASK_ID"; empty: the whole list

  // Of a list of `size`: consecutive pictures; sizes of shards differ by at most one.
  std::size_t first(std::size_t size) const;
  std::size_t size(std::size_t size) const;
};

using Environment = std::function<const char*(const char* name)>;  // as std::getenv

// `given`: "I/N", I from 1 to N, or empty: the variables of Slurm's arrays, Kubernetes' indexed Jobs (which set the
// index alone: JOB_COMPLETIONS is for the Job's manifest) and Grid Engine's arrays. Errors (bad_input): no such shard,
// a task without the number of tasks, a task outside of them.
Result<Shard> shard_of(const std::string& given, const Environment& environment);

}  // namespace kasumi

// turbidity.csv: one row per sky frame, what was estimated and what was shown.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "pipeline/show/scene/sky_watch.hpp"

namespace kasumi {

class TurbidityTable {
 public:
  void add(const SkyReport& report, double altitude_m);
  Result<> write(const std::filesystem::path& path) const;
  std::size_t row_count() const { return rows_.size(); }

 private:
  std::vector<std::string> rows_;
};

}  // namespace kasumi

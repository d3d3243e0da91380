// Parts of an archive as one: every picture of its list exactly once, in the list's order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "base/result.hpp"
#include "pipeline/lab/archive/archive_record.hpp"

namespace kasumi {

class WholeArchive {
 public:
  // Reads the parts once. Errors (bad_input), all of them at once: a part cannot be read, has a torn or strange line,
  // or is of another list or other options than the first; pictures that are missing or there twice.
  static Result<WholeArchive> prove(const std::vector<std::filesystem::path>& parts);

  const Archive& archive() const { return archive_; }
  // Each record in order; stops at the first error of `take`. `line`: without newline. Errors: those; bad_input (a part
  // changed meanwhile, or a record is no JSON).
  Result<> for_each(const std::function<Result<>(std::string_view line, const nlohmann::json& record)>& take) const;

 private:
  struct Place {
    std::uint64_t begin = 0;
    std::uint32_t part = 0;
    bool known = false;
  };
  void read_part(std::size_t part, Problems& problems);
  void tell_missing(Problems& problems) const;

  std::vector<std::filesystem::path> parts_;
  std::vector<Place> places_;  // by picture
  Archive archive_;
};

}  // namespace kasumi

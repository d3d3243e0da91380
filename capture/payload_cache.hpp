// Reads payload files, and keeps the last few of those that several rows name.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "capture/payload.hpp"

namespace kasumi {

class PayloadCache {
 public:
  explicit PayloadCache(std::filesystem::path folder) : folder_(std::move(folder)) {}
  // At most `bytes_used` bytes of the file, fewer when it is shorter; none when the name is empty. The same
  // memory for the same name and bytes_used while it is kept. Error (io): cannot be read.
  Result<Payload> read(const std::string& name, std::uint32_t bytes_used, bool keep);

 private:
  struct Entry {
    std::string name;
    std::uint32_t bytes_used;
    Payload payload;
  };
  std::filesystem::path folder_;
  std::deque<Entry> kept_;  // newest first
};

}  // namespace kasumi

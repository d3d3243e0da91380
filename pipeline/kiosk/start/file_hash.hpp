// FNV-1a, by which a file that a disk has damaged is known: it finds every change of a single byte.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace kasumi {

class FileHash {
 public:
  void add(std::span<const std::uint8_t> bytes) {
    for (const auto byte : bytes) hash_ = (hash_ ^ byte) * 0x100000001b3u;
  }
  void add(std::string_view text) { add({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}); }
  std::string hex() const { return fmt::format("{:016x}", hash_); }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

}  // namespace kasumi

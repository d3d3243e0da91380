// SHA-256, by which the files of a bundle are known.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include <sodium/crypto_hash_sha256.h>

#include "base/result.hpp"

namespace kasumi {

class Sha256 {
 public:
  Sha256();
  void add(std::span<const std::uint8_t> bytes);
  std::string hex();  // of all that was added; 64 digits. Once

 private:
  crypto_hash_sha256_state state_;
};

std::string sha256_of(std::string_view text);
// In pieces: a file may be larger than memory. Error: io.
Result<std::string> sha256_of_file(const std::filesystem::path& file);

}  // namespace kasumi

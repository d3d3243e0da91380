#include "pipeline/kiosk/content/digest.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include <fcntl.h>
#include <sodium/utils.h>
#include <unistd.h>

#include "base/unique_fd.hpp"

namespace kasumi {

Sha256::Sha256() {
  crypto_hash_sha256_init(&state_);
}

void Sha256::add(std::span<const std::uint8_t> bytes) {
  crypto_hash_sha256_update(&state_, bytes.data(), bytes.size());
}

std::string Sha256::hex() {
  std::array<std::uint8_t, crypto_hash_sha256_BYTES> digest;
  crypto_hash_sha256_final(&state_, digest.data());
  std::array<char, 2 * crypto_hash_sha256_BYTES + 1> digits;
  sodium_bin2hex(digits.data(), digits.size(), digest.data(), digest.size());
  return digits.data();
}

std::string sha256_of(std::string_view text) {
  Sha256 hash;
  hash.add({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  return hash.hex();
}

Result<std::string> sha256_of_file(const std::filesystem::path& file) {
  const UniqueFd fd(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  std::vector<std::uint8_t> piece(1 << 16);
  Sha256 hash;
  while (fd) {
    const auto n = ::read(fd.value(), piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) break;
    if (n == 0) return hash.hex();
    hash.add({piece.data(), static_cast<std::size_t>(n)});
  }
  return fail(FaultKind::io, "{}: cannot be read: {}", file.string(), std::strerror(errno));
}

}  // namespace kasumi

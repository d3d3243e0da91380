// Signatures in minisign's format (https://jedisct1.github.io/minisign): Ed25519 over the BLAKE2b-512 of a text ("ED"),
// or over the text itself ("Ed", as older versions sign). What minisign signs is accepted here, and the other way round.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.hpp"

namespace kasumi {

struct PublicKey {
  std::string name;  // of its file, without .pub
  std::array<std::uint8_t, 8> id{};
  std::array<std::uint8_t, 32> key{};
};

// A file of minisign's, two lines. Error: bad_input.
Result<PublicKey> read_public_key(std::string_view text, std::string name);
// All *.pub of a folder, in the order of their names; none where there is no such folder. Errors: bad_input (all that
// are no keys), io.
Result<std::vector<PublicKey>> read_public_keys(const std::filesystem::path& folder);

// The verified signer.
struct Signed {
  std::string by;       // the key's name
  std::string comment;  // the trusted comment, which is signed too
};
// Errors (bad_input): no signature, by none of these keys, not over this text, another comment than was signed.
Result<Signed> verify_signature(std::string_view text, std::string_view signature, const std::vector<PublicKey>& keys);

struct SecretKey {
  std::array<std::uint8_t, 8> id{};
  std::array<std::uint8_t, 64> key{};
  ~SecretKey();
};
// `password` is asked only for a key that is encrypted; its derivation takes seconds and up to 1 GB of memory.
// Errors: bad_input (no key of minisign's, a wrong password).
Result<SecretKey> read_secret_key(std::string_view text, const std::function<Result<std::string>()>& password);

// The four lines of a .minisig, prehashed. Errors: bad_input (a comment of more than one line).
Result<std::string> sign(std::string_view text, const SecretKey& key, std::string_view comment);

}  // namespace kasumi

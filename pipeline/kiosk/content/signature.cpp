#include "pipeline/kiosk/content/signature.hpp"

#include <algorithm>
#include <cstring>
#include <optional>

#include <sodium.h>

#include "base/files.hpp"

namespace kasumi {

namespace {

constexpr std::string_view kUntrusted = "untrusted comment: ", kTrusted = "trusted comment: ";
constexpr std::size_t kMostKeys = 100;
constexpr std::size_t kMostKeyBytes = 4096;

using Bytes = std::vector<std::uint8_t>;

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// Lines, with or without a carriage return; a last one that is empty is none.
std::vector<std::string_view> text_lines(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const auto end = text.find('\n');
    auto line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    lines.push_back(line);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

// Exactly `size` bytes; empty: anything else.
std::optional<Bytes> from_base64(std::string_view text, std::size_t size) {
  Bytes bytes(size);
  std::size_t length = 0;
  const char* end = nullptr;
  if (sodium_base642bin(bytes.data(), bytes.size(), text.data(), text.size(), nullptr, &length, &end,
                        sodium_base64_VARIANT_ORIGINAL) != 0 ||
      length != size || end != text.data() + text.size())
    return std::nullopt;
  return bytes;
}

std::string to_base64(std::span<const std::uint8_t> bytes) {
  std::string text(sodium_base64_encoded_len(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(text.data(), text.size(), bytes.data(), bytes.size(), sodium_base64_VARIANT_ORIGINAL);
  text.resize(std::strlen(text.c_str()));
  return text;
}

template <std::size_t size>
std::array<std::uint8_t, size> part(std::span<const std::uint8_t> bytes, std::size_t from) {
  std::array<std::uint8_t, size> taken;
  std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(from), size, taken.begin());
  return taken;
}

std::array<std::uint8_t, 64> blake2b_512(std::string_view text) {
  std::array<std::uint8_t, 64> hash;
  crypto_generichash(hash.data(), hash.size(), bytes_of(text).data(), text.size(), nullptr, 0);
  return hash;
}

bool is_signed(std::span<const std::uint8_t> signature, std::span<const std::uint8_t> message, const PublicKey& key) {
  return crypto_sign_verify_detached(signature.data(), message.data(), message.size(), key.key.data()) == 0;
}

// As minisign prints it.
std::string id_text(std::span<const std::uint8_t> id) {
  std::string text;
  for (auto byte = id.rbegin(); byte != id.rend(); ++byte) text += fmt::format("{:02X}", *byte);
  return text;
}

}  // namespace

Result<PublicKey> read_public_key(std::string_view text, std::string name) {
  const auto lines = text_lines(text);
  const auto bytes = lines.size() == 2 && lines[0].starts_with(kUntrusted) ? from_base64(lines[1], 42) : std::nullopt;
  if (!bytes || (*bytes)[0] != 'E' || (*bytes)[1] != 'd')
    return fail(FaultKind::bad_input, "{}: not a public key of minisign's (two lines, of `minisign -G`)", name);
  return PublicKey{std::move(name), part<8>(*bytes, 2), part<32>(*bytes, 10)};
}

Result<std::vector<PublicKey>> read_public_keys(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (auto entry = std::filesystem::directory_iterator(folder, error); !error && entry != end(entry);
       entry.increment(error))
    if (entry->path().extension() == ".pub") files.push_back(entry->path());
  if (error && error != std::errc::no_such_file_or_directory)
    return fail(FaultKind::io, "{}: cannot be read: {}", folder.string(), error.message());
  if (files.size() > kMostKeys)
    return fail(FaultKind::bad_input, "{}: {} keys, expected at most {}", folder.string(), files.size(), kMostKeys);
  std::ranges::sort(files);
  std::vector<PublicKey> keys;
  Problems problems;
  for (const auto& file : files) {
    const auto text = read_text_file(file);
    auto key = text ? read_public_key(text->substr(0, kMostKeyBytes), file.string()) : fail(text.error());
    if (!key) {
      problems.add("{}", key.error().message);
      continue;
    }
    key->name = file.stem().string();
    keys.push_back(std::move(*key));
  }
  if (!problems.empty()) return fail(problems.fault());
  return keys;
}

Result<Signed> verify_signature(std::string_view text, std::string_view signature, const std::vector<PublicKey>& keys) {
  if (sodium_init() < 0) return fail(FaultKind::unsupported, "libsodium cannot be used here");
  if (signature.empty()) return fail(FaultKind::bad_input, "it is not signed");
  const auto lines = text_lines(signature);
  const auto whole = lines.size() == 4 && lines[0].starts_with(kUntrusted) && lines[2].starts_with(kTrusted);
  const auto first = whole ? from_base64(lines[1], 74) : std::nullopt;
  const auto global = whole ? from_base64(lines[3], 64) : std::nullopt;
  if (!first || !global || (*first)[0] != 'E' || ((*first)[1] != 'd' && (*first)[1] != 'D'))
    return fail(FaultKind::bad_input, "its signature is not of minisign's format (four lines)");
  const auto id = part<8>(*first, 2);
  const auto over_text = part<64>(*first, 10);
  const auto hash = blake2b_512(text);
  const bool prehashed = (*first)[1] == 'D';
  const auto message = prehashed ? std::span<const std::uint8_t>(hash) : bytes_of(text);
  const auto comment = lines[2].substr(kTrusted.size());
  Bytes with_comment(over_text.begin(), over_text.end());
  with_comment.insert(with_comment.end(), comment.begin(), comment.end());
  bool known = false;
  for (const auto& key : keys) {
    if (key.id != id) continue;
    known = true;
    if (!is_signed(over_text, message, key)) continue;
    if (!is_signed(*global, with_comment, key))
      return fail(FaultKind::bad_input, "its signature's trusted comment is not the one that was signed");
    return Signed{key.name, std::string(comment)};
  }
  if (known) return fail(FaultKind::bad_input, "its signature does not belong to what it holds: changed since?");
  std::string names;
  for (const auto& key : keys) names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", key.name, id_text(key.id));
  return fail(FaultKind::bad_input, "it is signed by the key {}, which is not trusted here; trusted: {}", id_text(id),
              names.empty() ? "none" : names);
}

SecretKey::~SecretKey() {
  sodium_memzero(key.data(), key.size());
}

// Sig "Ed", derivation "Sc" or none, checksum "B2", salt 32, operations 8, memory 8, then what may be encrypted: id 8,
// key 64, checksum 32.
Result<SecretKey> read_secret_key(std::string_view text, const std::function<Result<std::string>()>& password) {
  if (sodium_init() < 0) return fail(FaultKind::unsupported, "libsodium cannot be used here");
  constexpr std::size_t kHidden = 54, kHiddenSize = 104, kMostMemory = std::size_t{2} << 30;
  const auto lines = text_lines(text);
  auto bytes = lines.size() == 2 && lines[0].starts_with(kUntrusted) ? from_base64(lines[1], kHidden + kHiddenSize)
                                                                     : std::nullopt;
  const auto is = [&](std::size_t at, const char* word) { return std::memcmp(bytes->data() + at, word, 2) == 0; };
  const bool plain = bytes && is(2, "\0\0");
  if (!bytes || !is(0, "Ed") || !is(4, "B2") || (!plain && !is(2, "Sc")))
    return fail(FaultKind::bad_input, "not a secret key of minisign's (two lines, of `minisign -G`)");
  if (!plain) {
    std::uint64_t operations = 0, memory = 0;
    std::memcpy(&operations, bytes->data() + 38, 8);  // little-endian, as all our machines are
    std::memcpy(&memory, bytes->data() + 46, 8);
    if (memory > kMostMemory || operations > (std::uint64_t{1} << 32))
      return fail(FaultKind::bad_input, "the secret key asks for {} bytes of memory, expected at most {}", memory,
                  kMostMemory);
    auto word = password();
    if (!word) return fail(word.error());
    std::array<std::uint8_t, kHiddenSize> stream;
    if (crypto_pwhash_scryptsalsa208sha256(stream.data(), stream.size(), word->data(), word->size(), bytes->data() + 6,
                                           operations, static_cast<std::size_t>(memory)) != 0)
      return fail(FaultKind::io, "there is not enough memory for the secret key's password");
    for (std::size_t i = 0; i < kHiddenSize; ++i) (*bytes)[kHidden + i] ^= stream[i];
    sodium_memzero(stream.data(), stream.size());
    sodium_memzero(word->data(), word->size());
  }
  SecretKey key;
  key.id = part<8>(*bytes, kHidden);
  key.key = part<64>(*bytes, kHidden + 8);
  const auto told = part<32>(*bytes, kHidden + 72);
  Bytes checked{'E', 'd'};
  checked.insert(checked.end(), bytes->begin() + kHidden, bytes->begin() + kHidden + 72);
  std::array<std::uint8_t, 32> sum;
  crypto_generichash(sum.data(), sum.size(), checked.data(), checked.size(), nullptr, 0);
  sodium_memzero(bytes->data(), bytes->size());
  sodium_memzero(checked.data(), checked.size());
  // minisign leaves the sum of a key without a password at zero.
  const bool unsummed = plain && std::ranges::all_of(told, [](std::uint8_t byte) { return byte == 0; });
  if (sum != told && !unsummed)
    return fail(FaultKind::bad_input, "{}",
                plain ? "the secret key is damaged" : "the password is not the secret key's");
  return key;
}

Result<std::string> sign(std::string_view text, const SecretKey& key, std::string_view comment) {
  if (sodium_init() < 0) return fail(FaultKind::unsupported, "libsodium cannot be used here");
  if (comment.find_first_of("\r\n") != std::string_view::npos)
    return fail(FaultKind::bad_input, "a signature's comment is one line");
  const auto hash = blake2b_512(text);
  std::array<std::uint8_t, 64> over_text, global;
  crypto_sign_detached(over_text.data(), nullptr, hash.data(), hash.size(), key.key.data());
  Bytes with_comment(over_text.begin(), over_text.end());
  with_comment.insert(with_comment.end(), comment.begin(), comment.end());
  crypto_sign_detached(global.data(), nullptr, with_comment.data(), with_comment.size(), key.key.data());
  Bytes first{'E', 'D'};
  first.insert(first.end(), key.id.begin(), key.id.end());
  first.insert(first.end(), over_text.begin(), over_text.end());
  return fmt::format("{}signature of kasumi content pack\n{}\n{}{}\n{}\n", kUntrusted, to_base64(first), kTrusted,
                     comment, to_base64(global));
}

}  // namespace kasumi

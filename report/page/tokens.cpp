#include "report/page/tokens.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

#include <crypt.h>
#include <sys/random.h>

namespace kasumi::report {

namespace {

using namespace std::chrono_literals;

constexpr std::size_t kLongestToken = 128, kLongestAddress = 64;
constexpr int kGuessesPerSecond = 5;            // of one address
constexpr int kStrangersGuessesPerSecond = 20;  // of all: each costs a millisecond
constexpr std::size_t kMostFriends = 64, kMostAddresses = 1000;

// No shorter for the first difference, so that time tells nothing.
bool are_equal(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return difference == 0;
}

// Empty: the method is not known.
std::string hashed(const std::string& token, const std::string& setting) {
  const auto data = std::make_unique<crypt_data>();
  const char* hash = ::crypt_rn(token.c_str(), setting.c_str(), data.get(), sizeof *data);
  return hash && hash[0] != '*' ? hash : "";
}

// RFC 4648; what is no base64 ends it.
std::string from_base64(std::string_view text) {
  std::string bytes;
  unsigned bits = 0, held = 0;
  for (const char c : text) {
    const unsigned value = c >= 'A' && c <= 'Z'   ? static_cast<unsigned>(c - 'A')
                           : c >= 'a' && c <= 'z' ? static_cast<unsigned>(c - 'a') + 26
                           : c >= '0' && c <= '9' ? static_cast<unsigned>(c - '0') + 52
                           : c == '+'             ? 62u
                           : c == '/'             ? 63u
                                                  : 64u;
    if (value == 64u) break;
    bits = bits << 6 | value;
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes += static_cast<char>(bits >> held & 0xffu);
  }
  return bytes;
}

// Whether its method is set to take longer than a second or more than 16 MB: a guess at a token costs as much,
// and nobody is served meanwhile.
bool is_costly(const std::string& hash) {
  constexpr std::size_t kLongestHash = 256;
  if (hash.size() > kLongestHash) return true;
  // crypt(5): the logarithm of the cost, as a digit of "./0-9A-Za-z".
  const auto exceeds = [&](std::size_t at, char most) { return hash.size() > at && hash[at] > most; };
  if (hash.starts_with("$y$")) return !hash.starts_with("$y$j") || exceeds(4, '9');
  if (hash.starts_with("$gy$")) return !hash.starts_with("$gy$j") || exceeds(5, '9');
  if (hash.starts_with("$7$")) return exceeds(3, 'C');
  if (hash.starts_with("$2")) return exceeds(4, '0') && hash.compare(4, 2, "12") > 0;
  // Counts of rounds.
  std::size_t digits = 0, most = 0;
  const auto end = hash.find('$', 1);
  const auto rounds = end == std::string::npos ? end : hash.find('$', end + 1);
  for (const char c : std::string_view(hash).substr(0, rounds))
    most = std::max(most, digits = (c >= '0' && c <= '9') ? digits + 1 : 0);
  return most > 6;
}

std::string token_of(std::string_view authorization) {
  constexpr std::string_view kBearer = "bearer ", kBasic = "basic ";
  // RFC 9110: the scheme is written in any case.
  const auto is = [&](std::string_view scheme) {
    return authorization.size() >= scheme.size() &&
           std::ranges::equal(authorization.substr(0, scheme.size()), scheme, {},
                              [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  };
  if (is(kBearer)) return std::string(authorization.substr(kBearer.size()));
  if (!is(kBasic)) return {};
  const auto both = from_base64(authorization.substr(kBasic.size()));
  const auto colon = both.find(':');
  return colon == std::string::npos ? std::string() : both.substr(colon + 1);
}

}  // namespace

std::string_view name_of(Admission admission) {
  switch (admission) {
    case Admission::admitted: return "admitted";
    case Admission::none: return "no token";
    case Admission::wrong: return "wrong token";
    case Admission::expired: return "expired token";
    case Admission::too_many: return "too many guesses";
  }
  return "unknown";
}

bool is_usable_hash(const std::string& hash) {
  return !is_costly(hash) && hash.starts_with('$') && !hashed("x", hash).empty();
}

bool Tokens::may_look(const std::string& address) {
  const auto now = clock_.now();
  if (now - window_ >= 1s) {
    window_ = now;
    looked_.clear();
    looked_at_all_ = 0;
  }
  const bool is_friend = std::ranges::find(friends_, address) != friends_.end();
  if (!is_friend && looked_.size() >= kMostAddresses && !looked_.contains(address)) return false;
  if (looked_[address]++ >= kGuessesPerSecond) return false;
  return is_friend || looked_at_all_++ < kStrangersGuessesPerSecond;
}

bool Tokens::is_valid(const AccessToken& option) const {
  return !option.until || clock_.utc() < *option.until;
}

Admission Tokens::admit(std::string_view authorization, std::string_view from) {
  const std::string address(from.substr(0, kLongestAddress));
  const auto token = token_of(authorization);
  if (token.empty()) return authorization.empty() ? Admission::none : Admission::wrong;
  if (token.size() > kLongestToken) return Admission::wrong;
  for (const auto& known : known_)
    if (are_equal(known.token, token))
      return is_valid(options_[known.option]) ? Admission::admitted : Admission::expired;
  if (!may_look(address)) return Admission::too_many;
  // All of them, whichever it is.
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < options_.size(); ++i)
    if (are_equal(hashed(token, options_[i].hash), options_[i].hash)) found = i;
  if (!found) return Admission::wrong;
  known_.push_back({token, *found});
  std::erase(friends_, address);
  friends_.push_back(address);
  if (friends_.size() > kMostFriends) friends_.pop_front();
  return is_valid(options_[*found]) ? Admission::admitted : Admission::expired;
}

Result<std::string> random_letters() {
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyz234567";
  std::array<unsigned char, 26> random;
  if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size()))
    return fail(FaultKind::io, "no random numbers: {}", std::strerror(errno));
  std::string letters;
  for (const unsigned char byte : random) letters += kLetters[byte % kLetters.size()];
  return letters;
}

Result<NewToken> new_token() {
  auto letters = random_letters();
  if (!letters) return fail(letters.error());
  NewToken made;
  made.token = std::move(*letters);
  std::array<char, CRYPT_GENSALT_OUTPUT_SIZE> setting;
  // The lowest cost takes 1 MB and a millisecond; slow hashes are for what people think up.
  if (!::crypt_gensalt_rn("$y$", 1, nullptr, 0, setting.data(), static_cast<int>(setting.size())))
    return fail(FaultKind::io, "no salt: {}", std::strerror(errno));
  made.hash = hashed(made.token, setting.data());
  if (made.hash.empty()) return fail(FaultKind::io, "crypt() of this machine does not know yescrypt");
  return made;
}

}  // namespace kasumi::report

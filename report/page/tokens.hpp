// Who may see the page: tokens, of which only hashes are kept.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi::report {

struct AccessToken {
  std::string name;          // of whom or what it is for
  std::string hash;          // crypt(5): "$y$..." or another method of this machine's crypt()
  std::optional<Utc> until;  // valid so long; empty: for ever
};

enum class Admission {
  admitted,
  none,  // no token was given
  wrong,
  expired,   // it was right once
  too_many,  // more guesses a second than are looked at
};
std::string_view name_of(Admission admission);

// Whether crypt() of this machine knows the hash's method.
bool is_usable_hash(const std::string& hash);

class Tokens {
 public:
  Tokens(std::vector<AccessToken> options, Clock& clock) : options_(std::move(options)), clock_(clock) {}
  bool empty() const { return options_.empty(); }
  // The token of an Authorization header: "Bearer TOKEN", or "Basic ..." with the token as password, which browsers ask
  // for. A token that was admitted is known again without the cost of its hash. Compares in constant time. Guesses are
  // counted by the address that they come from, so that nobody can shut others out; and so many a second in all, of which
  // some are left to addresses of which a right token came before.
  Admission admit(std::string_view authorization, std::string_view address = {});

 private:
  struct Known {
    std::string token;
    std::size_t option;
  };
  bool may_look(const std::string& address);
  bool is_valid(const AccessToken& option) const;

  std::vector<AccessToken> options_;
  Clock& clock_;
  std::vector<Known> known_;
  Instant window_{};
  std::map<std::string, int> looked_;  // at guesses, in the window, by address
  int looked_at_all_ = 0;              // of strangers
  std::deque<std::string> friends_;    // addresses of which a right token came, the newest last
};

// 26 letters and digits, of 130 random bits. Errors: io.
Result<std::string> random_letters();

// 130 random bits as 26 letters and digits, and their hash, cheap to check since nobody can guess them. Errors: io.
struct NewToken {
  std::string token, hash;
};
Result<NewToken> new_token();

}  // namespace kasumi::report

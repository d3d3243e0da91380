#include "report/channels/sign_of_life.hpp"

#include <algorithm>

#include "report/diagnosis/diagnosis.hpp"
#include "report/web/web_request.hpp"

namespace kasumi::report {

namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMostAnswerBytes = 64 * 1024;
constexpr Duration kAgain = 1min;  // after a failure

}  // namespace

struct SignOfLife::Exchange {
  Exchange(const SignOfLifeOptions& options, Duration longest)
      : request(options.url, options.ca_file, "http,https", longest / 2) {
    request.set(CURLOPT_TIMEOUT_MS, static_cast<long>(longest / 1ms));
    const curl_write_callback discard = [](char*, std::size_t, std::size_t bytes, void* so_far) {
      auto& sum = *static_cast<std::size_t*>(so_far);
      sum += bytes;
      return sum > kMostAnswerBytes ? std::size_t{0} : bytes;
    };
    request.set(CURLOPT_WRITEFUNCTION, discard);
    request.set(CURLOPT_WRITEDATA, static_cast<void*>(&heard));
  }

  // What was wrong with it, or nothing, once it is over.
  std::optional<std::string> turn() {
    const auto end = request.turn();
    if (!end) return std::nullopt;
    if (!end->problem.empty()) return end->problem;
    return end->code >= 200 && end->code < 300 ? "" : fmt::format("it answers {}", end->code);
  }

  std::size_t heard = 0;
  WebRequest request;
};

SignOfLife::SignOfLife(SignOfLifeOptions options, Clock& clock, Duration longest)
    : options_(std::move(options)), clock_(clock), longest_(longest) {}
SignOfLife::~SignOfLife() = default;

void SignOfLife::tell(const Heard& heard) {
  if (exchange_ || !is_well(diagnose(heard).sight)) return;
  const auto now = clock_.now();
  if (next_ && now < *next_) return;
  next_ = now + options_.every;
  exchange_ = std::make_unique<Exchange>(options_, longest_);
}

void SignOfLife::turn() {
  if (!exchange_) return;
  const auto problem = exchange_->turn();
  if (!problem) return;
  exchange_.reset();
  finish(*problem);
}

void SignOfLife::finish(const std::string& problem) {
  if (problem.empty()) {
    ++given_;
  } else {
    ++failed_;
    next_ = std::min(*next_, clock_.now() + kAgain);
  }
  // One line for each change.
  if (problem == problem_) return;
  problem_ = problem;
  if (problem.empty())
    fmt::print(stderr, "<5>sign of life: {}: given\n", host_of(options_.url));
  else
    fmt::print(stderr, "<4>sign of life: {}: {}\n", host_of(options_.url), problem);
}

}  // namespace kasumi::report

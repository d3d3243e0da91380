#include "report/channels/sign_of_life.hpp"

#include <algorithm>

#include <curl/curl.h>

#include "base/c_ptr.hpp"
#include "report/status/diagnosis.hpp"

namespace kasumi::report {

namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMostAnswerBytes = 64 * 1024;
constexpr Duration kAgain = 1min;  // after a failure

// Without what makes it a secret.
std::string host_of(const std::string& url) {
  const auto begin = url.find("://") + 3;
  auto host = url.substr(begin, url.find_first_of("/?#", begin) - begin);
  return host.substr(host.rfind('@') + 1);
}

}  // namespace

bool is_web_address(std::string_view url) {
  if (url.size() > 1000 || !(url.starts_with("https://") || url.starts_with("http://"))) return false;
  const auto host = url.find("://") + 3;
  if (host == url.size() || std::string_view("/?#:@").find(url[host]) != std::string_view::npos) return false;
  return std::ranges::all_of(url, [](char c) { return c > 0x20 && c < 0x7f && c != '"' && c != '\\'; });
}

struct SignOfLife::Exchange {
  Exchange(const SignOfLifeOptions& options, Duration longest) : multi(curl_multi_init()), easy(curl_easy_init()) {
    if (!multi || !easy) return;
    const auto set = [&](CURLoption option, auto value) { curl_easy_setopt(easy.get(), option, value); };
    const auto longest_ms = static_cast<long>(longest / 1ms);
    set(CURLOPT_URL, options.url.c_str());
    set(CURLOPT_PROTOCOLS_STR, "http,https");
    set(CURLOPT_FOLLOWLOCATION, 0L);
    set(CURLOPT_TIMEOUT_MS, longest_ms);
    set(CURLOPT_CONNECTTIMEOUT_MS, longest_ms / 2);
    set(CURLOPT_NOSIGNAL, 1L);
    set(CURLOPT_QUICK_EXIT, 1L);  // a name's look-up that hangs is left behind
    set(CURLOPT_USERAGENT, "kasumi-report");
    set(CURLOPT_ERRORBUFFER, words);
    set(CURLOPT_SSL_VERIFYPEER, 1L);
    set(CURLOPT_SSL_VERIFYHOST, 2L);
    if (!options.ca_file.empty()) {
      set(CURLOPT_CAINFO, options.ca_file.c_str());
      set(CURLOPT_CAPATH, static_cast<const char*>(nullptr));
    }
    const curl_write_callback discard = [](char*, std::size_t, std::size_t bytes, void* so_far) {
      auto& sum = *static_cast<std::size_t*>(so_far);
      sum += bytes;
      return sum > kMostAnswerBytes ? std::size_t{0} : bytes;
    };
    set(CURLOPT_WRITEFUNCTION, discard);
    set(CURLOPT_WRITEDATA, static_cast<void*>(&heard));
    curl_multi_add_handle(multi.get(), easy.get());
  }
  ~Exchange() {
    if (multi && easy) curl_multi_remove_handle(multi.get(), easy.get());
  }
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  // What was wrong with it, or nothing, once it is over.
  std::optional<std::string> turn() {
    if (!multi || !easy) return "no memory";
    int running = 0;
    curl_multi_perform(multi.get(), &running);
    if (running > 0) return std::nullopt;
    int left = 0;
    const auto* message = curl_multi_info_read(multi.get(), &left);
    const auto result = message ? message->data.result : CURLE_FAILED_INIT;
    // The library's own words name milliseconds, which would make each failure a new one.
    const bool by_tls = result == CURLE_PEER_FAILED_VERIFICATION || result == CURLE_SSL_CONNECT_ERROR ||
                        result == CURLE_SSL_CACERT_BADFILE;
    if (result != CURLE_OK) return by_tls && words[0] ? std::string(words) : curl_easy_strerror(result);
    long code = 0;
    curl_easy_getinfo(easy.get(), CURLINFO_RESPONSE_CODE, &code);
    if (code >= 200 && code < 300) return "";
    return fmt::format("it answers {}", code);
  }

  std::size_t heard = 0;
  char words[CURL_ERROR_SIZE] = {};
  CPtr<CURLM, curl_multi_cleanup> multi;
  CPtr<CURL, curl_easy_cleanup> easy;
};

SignOfLife::SignOfLife(SignOfLifeOptions options, Clock& clock, Duration longest)
    : options_(std::move(options)), clock_(clock), longest_(longest) {
  static const auto ready = curl_global_init(CURL_GLOBAL_DEFAULT);
  (void)ready;
}
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

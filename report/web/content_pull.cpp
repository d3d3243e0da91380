#include "report/web/content_pull.hpp"

#include <algorithm>

#include "report/web/web_request.hpp"

namespace kasumi::report {

namespace {

using namespace std::chrono_literals;

constexpr Duration kFirstWait = 1min;  // doubled after each failure
// A web server's headers take some kB; more is no answer.
constexpr std::size_t kMostHeaderBytes = 64 * 1024, kMostRefusalBytes = 64 * 1024;
constexpr int kWhole = 200, kPart = 206, kUnchanged = 304, kNoSuchPart = 416;  // of HTTP

}  // namespace

struct ContentPull::Exchange {
  Exchange(const PullOptions& options, const PullBounds& of, ArrivingBundle& to)
      : bounds(of), bundle(to), request(options.url, options.ca_file, "https", of.to_connect) {
    if (!bundle.whole_tag().empty()) add_line("If-None-Match: " + bundle.whole_tag());
    if (is_strong(bundle.tag()) && bundle.bytes() > 0) {
      asked_from = bundle.bytes();
      add_line(fmt::format("Range: bytes={}-", *asked_from));
      add_line("If-Range: " + bundle.tag());
    }
    request.set(CURLOPT_HTTPHEADER, lines.get());
    request.set(CURLOPT_LOW_SPEED_LIMIT, bounds.slow_bytes_s);
    request.set(CURLOPT_LOW_SPEED_TIME, std::max(1L, static_cast<long>(bounds.slow / 1s)));
    request.set(CURLOPT_TIMEOUT_MS, static_cast<long>(bounds.whole / 1ms));
    const curl_write_callback header = [](char* line, std::size_t, std::size_t bytes, void* of_us) {
      auto& us = *static_cast<Exchange*>(of_us);
      take_header({line, bytes}, us.answer);
      return (us.header_bytes += bytes) > kMostHeaderBytes ? std::size_t{0} : bytes;
    };
    const curl_write_callback body = [](char* piece, std::size_t, std::size_t bytes, void* of_us) {
      return static_cast<Exchange*>(of_us)->take({piece, bytes}) ? bytes : std::size_t{0};
    };
    request.set(CURLOPT_HEADERFUNCTION, header);
    request.set(CURLOPT_HEADERDATA, static_cast<void*>(this));
    request.set(CURLOPT_WRITEFUNCTION, body);
    request.set(CURLOPT_WRITEDATA, static_cast<void*>(this));
  }

  void add_line(const std::string& line) {
    if (auto* longer = curl_slist_append(lines.get(), line.c_str())) {
      (void)lines.release();
      lines.reset(longer);
    }
  }

  bool take(std::span<const char> piece) {
    if (answer.code != kWhole && answer.code != kPart) return (refusal_bytes += piece.size()) <= kMostRefusalBytes;
    const auto taken = take_bundle(piece);
    if (!taken) problem = taken.error();
    return taken.has_value();
  }

  Result<> take_bundle(std::span<const char> piece) {
    if (!begun)
      if (auto done = begin(); !done) return done;
    begun = true;
    if (bundle.bytes() + piece.size() > bounds.bytes)
      return fail(FaultKind::bad_input, "it sends more than {} MB: no bundle is so large", bounds.bytes >> 20);
    return bundle.add(piece);
  }

  // What comes is what was asked for, and there is room for it.
  Result<> begin() {
    const bool part = answer.code == kPart;
    const auto all = part ? answer.of_bytes : answer.bytes;
    if (part && (!asked_from || answer.first != *asked_from || (!answer.tag.empty() && answer.tag != bundle.tag())))
      return fail(FaultKind::bad_input, "it sends another part than it was asked for");
    if (!part && answer.tag.empty())
      return fail(FaultKind::bad_input, "it gives no ETag, without which all of it would come each time");
    if (all && *all > bounds.bytes)
      return fail(FaultKind::bad_input, "it has {} MB, and a bundle at most {}", *all >> 20, bounds.bytes >> 20);
    of_bytes = all.value_or(0);
    return part ? bundle.resume(of_bytes) : bundle.begin(answer.tag, of_bytes);
  }

  // Whether a bundle came. Errors: why none did.
  Result<bool> ended(const WebRequest::End& end) {
    if (problem) return fail(*problem);
    if (header_bytes > kMostHeaderBytes) return fail(FaultKind::bad_input, "its header has no end");
    if (refusal_bytes > kMostRefusalBytes) return fail(FaultKind::bad_input, "it answers {}", answer.code);
    if (!end.problem.empty()) return fail(FaultKind::io, "{}", end.problem);
    if (end.code == kUnchanged) return false;
    if (end.code != kWhole && end.code != kPart) return fail(FaultKind::bad_input, "it answers {}", end.code);
    if (!begun) return fail(FaultKind::bad_input, "it sends an empty file");
    if (of_bytes != 0 && bundle.bytes() != of_bytes)
      return fail(FaultKind::bad_input, "it sends {} of {} bytes", bundle.bytes(), of_bytes);
    if (auto whole = bundle.finish(); !whole) return fail(whole.error());
    return true;
  }

  const PullBounds& bounds;
  ArrivingBundle& bundle;
  CPtr<curl_slist, curl_slist_free_all> lines;  // of the request
  PullAnswer answer;
  std::optional<std::uint64_t> asked_from;
  std::uint64_t of_bytes = 0;
  std::size_t header_bytes = 0, refusal_bytes = 0;
  bool begun = false;
  std::optional<Fault> problem;  // of this program or of the server
  WebRequest request;
};

ContentPull::ContentPull(PullOptions options, Clock& clock, PullBounds bounds)
    : options_(std::move(options)),
      clock_(clock),
      bounds_(bounds),
      bundle_(options_.folder, options_.url, bounds.free_bytes),
      wait_(kFirstWait) {}
ContentPull::~ContentPull() {
  exchange_.reset();
  bundle_.keep();
}

void ContentPull::turn() {
  if (!exchange_) {
    if (next_ && clock_.now() < *next_) return;
    exchange_ = std::make_unique<Exchange>(options_, bounds_, bundle_);
  }
  const auto end = exchange_->request.turn();
  if (!end) return;
  auto came = exchange_->ended(*end);
  // What was sent wrongly is not continued; what was cut off is.
  const bool wrong = !came && (exchange_->answer.code == kNoSuchPart || came.error().kind == FaultKind::bad_input);
  const bool some = exchange_->begun;
  exchange_.reset();
  if (wrong)
    bundle_.forget();
  else if (!came)
    bundle_.keep();
  else if (!*came && !bundle_.tag().empty())
    bundle_.forget();  // of a version that was taken back
  if (some && !wrong) wait_ = kFirstWait;
  finish(std::move(came));
}

void ContentPull::finish(Result<bool> came) {
  const auto host = host_of(options_.url);
  const auto before = std::exchange(status_.problem, came ? std::string() : came.error().message);
  if (!came) {
    ++failed_;
    next_ = clock_.now() + std::min(wait_, options_.every);
    wait_ = std::min(2 * wait_, options_.every);
    // One line for each change.
    if (before != status_.problem) fmt::print(stderr, "<4>content: {}: {}\n", host, status_.problem);
    return;
  }
  next_ = clock_.now() + options_.every;
  wait_ = kFirstWait;
  status_.asked = clock_.utc();
  ++(*came ? fetched_ : unchanged_);
  if (*came) {
    status_.came = clock_.utc();
    fmt::print(stderr, "<5>content: {}: a bundle has come\n", host);
  } else if (!before.empty()) {
    fmt::print(stderr, "<5>content: {}: answers again\n", host);
  }
}

PullStatus ContentPull::status() const {
  auto status = status_;
  status.bytes = bundle_.bytes();
  status.of_bytes = exchange_ ? exchange_->of_bytes : 0;
  return status;
}

}  // namespace kasumi::report

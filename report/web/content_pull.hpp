// New content, asked for at a web server now and then: one bundle at one address. It is fetched once for each version
// (ETag), goes on where it was cut off (Range), and stays in a folder until `kasumi content` has verified it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "report/web/arriving_bundle.hpp"

namespace kasumi::report {

// Of a bundle, as `kasumi content` takes it: 2 GiB of files, and what a tar has around them.
inline constexpr std::uint64_t kMostBundleBytes =
    (std::uint64_t{2} << 30) + 1004 * std::uint64_t{4096} + (std::uint64_t{1} << 20);

struct PullOptions {
  std::string url;  // https://; a secret of sorts
  Duration every = std::chrono::minutes(15);
  std::string ca_file;  // empty: the machine's certificate authorities
  std::filesystem::path folder = "/var/lib/kasumi-report";
};

struct PullBounds {
  std::uint64_t bytes = kMostBundleBytes;
  std::uint64_t free_bytes = std::uint64_t{128} << 20;  // that it leaves on the disk
  Duration to_connect = std::chrono::seconds(20);
  long slow_bytes_s = 500;  // slower for so long, and the download pauses until the next try, which resumes it
  Duration slow = std::chrono::minutes(1);
  Duration whole = std::chrono::hours(12);  // of one exchange
};

// For remote operators.
struct PullStatus {
  std::optional<Utc> asked;               // when the server last answered completely
  std::optional<Utc> came;                // since the reporter's start: when a bundle came whole
  std::uint64_t bytes = 0, of_bytes = 0;  // of the current download; 0: none, or unknown
  std::string problem;                    // of the last try; empty: none
};

class ContentPull {
 public:
  ContentPull(PullOptions options, Clock& clock, PullBounds bounds = {});
  ~ContentPull();
  ContentPull(const ContentPull&) = delete;
  ContentPull& operator=(const ContentPull&) = delete;

  // Call it some times a second. BLOCKS for the disk alone.
  void turn();

  PullStatus status() const;
  std::uint64_t fetched() const { return fetched_; }
  std::uint64_t unchanged() const { return unchanged_; }
  std::uint64_t failed() const { return failed_; }

 private:
  struct Exchange;
  void finish(Result<bool> came);

  PullOptions options_;
  Clock& clock_;
  PullBounds bounds_;
  ArrivingBundle bundle_;
  std::unique_ptr<Exchange> exchange_;
  std::optional<Instant> next_;
  Duration wait_;  // after the next failure
  PullStatus status_;
  std::uint64_t fetched_ = 0, unchanged_ = 0, failed_ = 0;
};

}  // namespace kasumi::report

// A sign of life: a GET of an address now and then, only while the kiosk is well. Whoever waits for it raises the alarm
// when it stays away, whatever has broken: kiosk, reporter, machine or network.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/clock.hpp"
#include "report/diagnosis/status_watch.hpp"

namespace kasumi::report {

struct SignOfLifeOptions {
  std::string url;  // a secret of sorts: who knows it can feign life
  Duration every = std::chrono::minutes(5);
  std::string ca_file;  // empty: who the machine trusts
};

class SignOfLife {
 public:
  // `longest`: of one exchange.
  SignOfLife(SignOfLifeOptions options, Clock& clock, Duration longest = std::chrono::seconds(20));
  ~SignOfLife();
  SignOfLife(const SignOfLife&) = delete;
  SignOfLife& operator=(const SignOfLife&) = delete;

  // Call it after each look at the kiosk.
  void tell(const Heard& heard);
  // Call it some times a second. Never waits.
  void turn();

  std::uint64_t given() const { return given_; }
  std::uint64_t failed() const { return failed_; }

 private:
  struct Exchange;
  void finish(const std::string& problem);

  SignOfLifeOptions options_;
  Clock& clock_;
  Duration longest_;
  std::unique_ptr<Exchange> exchange_;
  std::optional<Instant> next_;
  std::string problem_;
  std::uint64_t given_ = 0, failed_ = 0;
};

}  // namespace kasumi::report

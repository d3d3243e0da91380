#include "pipeline/machine/time_watch.hpp"

#include <sys/stat.h>
#include <sys/timerfd.h>
#include <sys/timex.h>

#include <cerrno>
#include <cmath>
#include <limits>

#include <spdlog/spdlog.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/abandonable.hpp"
#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"
#include "base/outside/this_boot.hpp"
#include "base/unique_fd.hpp"
#include "pipeline/machine/timedated.hpp"

namespace kasumi {

namespace {

// A synchronization that sets the clock is written down right after it.
constexpr std::chrono::seconds kSettingTakes{5};
// The time server's fine adjustment moves the clock by 43 s a day at most; setting the clock moves it at once.
constexpr double kSlewWhileDown_s = 2.0, kSlewBeforeSaving_s = 0.5;
constexpr std::chrono::seconds kFileDeadline{1};  // of a file in memory

std::optional<bool> ask_kernel() {
  struct timex kernel {};
  if (::adjtimex(&kernel) < 0) return std::nullopt;
  return (kernel.status & STA_UNSYNC) == 0;
}

// When the file was written, by the clock that it may have set.
std::optional<Utc> written_at(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return std::nullopt;
  return Utc(std::chrono::seconds(status.st_mtim.tv_sec) + std::chrono::nanoseconds(status.st_mtim.tv_nsec));
}

class MachineTimeWatch final : public TimeWatch {
 public:
  explicit MachineTimeWatch(TimeSources sources)
      : sources_(std::move(sources)), timer_(timerfd_create(CLOCK_REALTIME, TFD_NONBLOCK | TFD_CLOEXEC)) {
    arm();
  }

  ClockState read() override {
    std::uint64_t expired = 0;
    if (timer_ && ::read(timer_.value(), &expired, sizeof expired) < 0 && errno == ECANCELED) {
      ++state_.jumps;
      doubt_timesyncd();
      arm();
    }
    const auto kernel = sources_.kernel ? sources_.kernel() : std::nullopt;
    state_.synchronized = kernel ? *kernel : timesyncd_says_so() || timedated_says_so();
    return state_;
  }

 private:
  void arm() {
    struct itimerspec never {};
    never.it_value.tv_sec = std::numeric_limits<time_t>::max();
    if (timer_) ::timerfd_settime(timer_.value(), TFD_TIMER_ABSTIME | TFD_TIMER_CANCEL_ON_SET, &never, nullptr);
  }

  // The clock was set: by timesyncd just now, or by another program or a person after its last synchronization.
  void doubt_timesyncd() {
    const auto written = written_at(sources_.timesyncd);
    const Utc now = std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now());
    const bool by_it = written && *written <= now && now - *written <= kSettingTakes;
    doubted_ = by_it ? std::nullopt : written;
  }

  bool timesyncd_says_so() const {
    const auto written = written_at(sources_.timesyncd);
    return written && written != doubted_;
  }

  bool timedated_says_so() {
    if (!sources_.ask_timedated) return false;
    if (!timedated_) timedated_ = ask_timedated();
    return timedated_->synchronized();
  }

  TimeSources sources_;
  UniqueFd timer_;
  std::optional<Utc> doubted_;  // the synchronization that the clock was set after
  std::unique_ptr<Timedated> timedated_;
  ClockState state_;
};

class RememberedTrust final : public TimeWatch {
 public:
  RememberedTrust(std::unique_ptr<TimeWatch> watch, std::filesystem::path file, BootTime boot)
      : watch_(std::move(watch)), file_(std::move(file)), boot_(std::move(boot)) {
    saved_s_ = within<std::optional<double>>(kFileDeadline, [file = file_, boot = boot_] {
                 return load(file, boot);
               }).value_or(std::nullopt);
    state_.remembered = saved_s_.has_value();
  }

  ClockState read() override {
    const auto now = watch_->read();
    if (now.jumps != state_.jumps) forget();
    const bool held = state_.remembered || now.synchronized;
    state_ = now;
    state_.remembered = held;
    if (held) save();
    return state_;
  }

 private:
  static double offset_s(const BootTime& boot) { return to_seconds(boot.utc().time_since_epoch()) - boot.since_s(); }

  static std::optional<double> load(const std::filesystem::path& file, const BootTime& boot) {
    const auto text = read_text_file(file, kSmallFile);
    const auto json = text ? parse_json(modest_json(*text)) : nlohmann::json();
    if (!json.is_object() || boot.id.empty() || json.value("boot", nlohmann::json()) != boot.id) return std::nullopt;
    const auto offset = json.value("offset_s", nlohmann::json());
    if (!offset.is_number() || !(std::abs(offset.get<double>() - offset_s(boot)) <= kSlewWhileDown_s))
      return std::nullopt;
    return offset.get<double>();
  }

  void save() {
    const double offset = offset_s(boot_);
    if (saved_s_ && std::abs(*saved_s_ - offset) <= kSlewBeforeSaving_s) return;
    const auto text = text_of_json(nlohmann::json{{"boot", boot_.id}, {"offset_s", offset}}) + "\n";
    const auto written = changing_.within(kFileDeadline, [file = file_, text] { return write_text_file(file, text); });
    if (!written) return;  // later
    saved_s_ = offset;
    if (!*written) spdlog::warn("trust in the clock ends with this start: {}", written->error().message);
  }

  // A file that stays says another time than is now, and is not believed.
  void forget() {
    changing_.within(kFileDeadline, [file = file_]() -> Result<> {
      std::error_code error;
      std::filesystem::remove(file, error);
      return {};
    });
    saved_s_.reset();
    state_.remembered = false;
  }

  std::unique_ptr<TimeWatch> watch_;
  std::filesystem::path file_;
  BootTime boot_;
  std::optional<double> saved_s_;
  OneAtATime<Result<>> changing_;  // the file
  ClockState state_;
};

}  // namespace

TimeSources machine_time_sources() {
  TimeSources sources;
  sources.kernel = ask_kernel;
  return sources;
}

std::unique_ptr<TimeWatch> watch_time(TimeSources sources) {
  return std::make_unique<MachineTimeWatch>(std::move(sources));
}

BootTime this_boot_time() {
  return {boot_id(), since_boot_s,
          [] { return std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now()); }};
}

std::unique_ptr<TimeWatch> remember_trust(std::unique_ptr<TimeWatch> watch, std::filesystem::path file, BootTime boot) {
  if (file.empty()) return watch;
  return std::make_unique<RememberedTrust>(std::move(watch), std::move(file), std::move(boot));
}

}  // namespace kasumi

#include "report/diagnosis/status_watch.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>

#include "base/outside/this_boot.hpp"
#include "base/unique_fd.hpp"

namespace kasumi::report {

std::string_view name_of(Contact contact) {
  switch (contact) {
    case Contact::heard: return "heard";
    case Contact::silent: return "silent";
    case Contact::stopped: return "stopped";
    case Contact::absent: return "absent";
    case Contact::unreadable: return "unreadable";
  }
  return "unknown";
}

Result<std::string> read_distrusted_file(const std::filesystem::path& path, std::size_t most_bytes) {
  const auto in_words = [&](int error) {
    const bool absent = error == ENOENT || error == ENOTDIR;
    return fail(absent ? FaultKind::bad_input : FaultKind::io, "{}: {}", path.string(), std::strerror(error));
  };
  // Without O_NONBLOCK a pipe would hold us until somebody writes.
  const UniqueFd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (!fd) return in_words(errno);
  struct stat status {};
  if (::fstat(fd.value(), &status) != 0) return in_words(errno);
  if (!S_ISREG(status.st_mode)) return fail(FaultKind::io, "{}: is no file", path.string());
  std::string text(most_bytes + 1, '\0');
  std::size_t done = 0;
  while (done < text.size()) {
    const auto n = ::read(fd.value(), text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return in_words(errno);
    if (n == 0) break;
    done += static_cast<std::size_t>(n);
  }
  if (done > most_bytes)
    return fail(FaultKind::io, "{}: larger than {} bytes, the most expected", path.string(), most_bytes);
  text.resize(done);
  return text;
}

ThisMachine this_machine() {
  return {boot_id(), since_boot_s,
          [](double pid) { return ::kill(static_cast<pid_t>(pid), 0) == 0 || errno != ESRCH; }};
}

// Of one that names no boot, an older version's, only what was seen is known. Not by the file's times, nor by the clock:
// the machine's time may be set while it lies there.
StatusWatch::Age StatusWatch::age_of(const ReportedStatus& status) const {
  Age age{clock_.now() - *changed_, false};
  if (status.boot.empty() || !status.values["since_boot_s"]) return age;
  if (!machine_.boot.empty() && status.boot != machine_.boot) return {kStopPassesBy + kSilent, true};
  const auto since = from_seconds(std::clamp(machine_.since_boot_s() - *status.values["since_boot_s"], 0.0, 1e9));
  age.gone = status.values["pid"] && !machine_.runs(*status.values["pid"]);
  age.silent = std::max<Duration>(age.silent, since);
  return age;
}

Heard StatusWatch::look() {
  const auto now = clock_.now();
  auto text = read_distrusted_file(file_, kMostStatusBytes);
  if (!text) {
    const bool absent = text.error().kind == FaultKind::bad_input;
    changed_.reset();
    text_.clear();
    // The service manager takes the folder away with the service; when that crashes it stays.
    const bool lately = absent && heard_at_ && now - *heard_at_ < kStopPassesBy;
    return {lately   ? Contact::stopped
            : absent ? Contact::absent
                     : Contact::unreadable,
            std::nullopt,
            text.error().message,
            {}};
  }
  if (!changed_ || *text != text_) changed_ = now;
  text_ = std::move(*text);
  auto status = parse_status(text_);
  Heard heard;
  if (!status) {
    heard.contact = Contact::unreadable;
    heard.why = fmt::format("{}: {}", file_.string(), status.error().message);
    heard.silent = now - *changed_;
    return heard;
  }
  const auto age = age_of(*status);
  heard.silent = age.silent;
  if (status->trouble == Trouble::stopped && age.silent < kStopPassesBy) {
    heard.contact = Contact::stopped;
    heard.why = "stopped";
  } else if (age.silent > (age.gone ? kGone : kSilent)) {
    heard.contact = Contact::silent;
    heard.why = fmt::format("{}: not written for {:.0f} s{}", file_.string(), to_seconds(heard.silent),
                            age.gone ? ": whoever wrote it has gone" : "");
  } else {
    heard.contact = Contact::heard;
    heard.status = std::move(*status);
    heard_at_ = now;
  }
  return heard;
}

}  // namespace kasumi::report

#include "report/status/status_watch.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>

#include "base/unique_fd.hpp"

namespace kasumi::report {

std::string_view name_of(Contact contact) {
  switch (contact) {
    case Contact::heard: return "heard";
    case Contact::silent: return "silent";
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

Heard StatusWatch::look() {
  const auto now = clock_.now();
  auto text = read_distrusted_file(file_, kMostStatusBytes);
  if (!text) {
    const bool absent = text.error().kind == FaultKind::bad_input;
    changed_.reset();
    text_.clear();
    return {absent ? Contact::absent : Contact::unreadable, std::nullopt, text.error().message, {}};
  }
  // By our own clock, not by the file's times: the machine's time may be set while it lies there.
  if (!changed_ || *text != text_) changed_ = now;
  text_ = std::move(*text);
  auto status = parse_status(text_);
  Heard heard;
  heard.silent = now - *changed_;
  if (!status) {
    heard.contact = Contact::unreadable;
    heard.why = fmt::format("{}: {}", file_.string(), status.error().message);
  } else if (heard.silent > kSilent) {
    heard.contact = Contact::silent;
    heard.why = fmt::format("{}: not written for {:.0f} s", file_.string(), to_seconds(heard.silent));
  } else {
    heard.contact = Contact::heard;
    heard.status = std::move(*status);
  }
  return heard;
}

}  // namespace kasumi::report

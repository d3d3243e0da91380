#include "report/channels/mail_channel.hpp"

#include <unistd.h>

#include "base/lasting_file.hpp"

namespace kasumi::report {

namespace {

constexpr std::size_t kMostMemoryBytes = 4096;

}  // namespace

MailChannel::MailChannel(MailOptions options, std::string name, Language language, Clock& clock)
    : options_(std::move(options)),
      name_(std::move(name)),
      language_(language),
      clock_(clock),
      watch_(options_.pause,
             parse_mail_memory(read_distrusted_file(options_.memory_file, kMostMemoryBytes).value_or("")), clock) {
  if (::access(options_.command[0].c_str(), X_OK) != 0)
    fmt::print(stderr, "<4>mail: {}: no such program: no mail can be sent\n", options_.command[0]);
}

void MailChannel::tell(const Heard& heard) {
  watch_.look(heard);
  if (running_) {
    const auto done = running_->turn();
    if (!done) return;
    running_.reset();
    return finish(*done);
  }
  auto news = watch_.due();
  if (!news) return;
  news_ = std::move(*news);
  auto started =
      Sendmail::start(options_.command, mail_text(news_, options_, name_, language_, watch_.pause()), clock_);
  if (started)
    running_.emplace(std::move(*started));
  else
    finish(fail(started.error()));
}

void MailChannel::finish(const Result<>& done) {
  std::string problem;
  if (done) {
    ++sent_;
    watch_.told(news_);
    if (const auto kept = update_text_file(options_.memory_file, text_of(watch_.memory())); !kept)
      problem = kept.error().message;
  } else {
    ++failed_;
    watch_.failed();
    problem = done.error().message;
  }
  if (problem == problem_) return;
  problem_ = problem;
  if (!problem.empty())
    fmt::print(stderr, "<4>mail: {}\n", problem);
  else
    fmt::print(stderr, "<5>mail: sent\n");
}

}  // namespace kasumi::report

#include "report/page/screen_asking.hpp"

#include <algorithm>

#include "base/socket/local_socket.hpp"

namespace kasumi::report {

namespace {

// Errors: those of the socket; bad_input: it is none.
Result<ScreenAnswer> read_answer(const UniqueFd& socket) {
  const auto line = read_line_within(socket, kLongestScreenLine, ScreenAsking::kAnswerDeadline);
  if (!line) return fail(line.error());
  auto answer = parse_screen_line(*line);
  if (!answer) return answer;
  auto& pixels = answer->picture.elements();
  const auto bytes = read_bytes_within(socket, 3 * pixels.size(), ScreenAsking::kAnswerDeadline);
  if (!bytes) return fail(bytes.error());
  auto at = bytes->begin();
  for (Rgb8& pixel : pixels)
    for (const int c : {0, 1, 2}) pixel[c] = static_cast<std::uint8_t>(*at++);
  return answer;
}

}  // namespace

ScreenReply ScreenAsking::ask() {
  const auto now = clock_.now();
  if (now < next_) return {ScreenOutcome::wait, {{}, {}, std::chrono::ceil<std::chrono::seconds>(next_ - now)}, {}};
  const auto socket = connect_to(socket_);
  if (!socket && socket.error().kind == FaultKind::disconnected) return {};
  if (!socket) return {ScreenOutcome::no_answer, {}, socket.error().message};
  const auto answer = read_answer(*socket);
  next_ = now + (answer && answer->wait ? Duration(*answer->wait) : kScreenPause);
  if (!answer) return {ScreenOutcome::no_answer, {}, answer.error().message};
  const auto outcome = answer->wait              ? ScreenOutcome::wait
                       : answer->picture.empty() ? ScreenOutcome::nothing
                                                 : ScreenOutcome::picture;
  return {outcome, *answer, {}};
}

}  // namespace kasumi::report

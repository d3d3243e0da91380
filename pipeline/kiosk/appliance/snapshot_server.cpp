#include "pipeline/kiosk/appliance/snapshot_server.hpp"

#include <spdlog/spdlog.h>

#include "base/socket/local_socket.hpp"
#include "base/socket/screen_answer.hpp"
#include "pipeline/kiosk/snapshot/blurred_picture.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

constexpr Duration kCallerWait = 250ms;         // bounds how late a stop is noticed
constexpr Duration kRequestDeadline = 1s;       // a caller of this machine has its request ready
constexpr Duration kPictureWait = 8s;           // visitors get a notice first, and a display may have to be reopened
constexpr Duration kAnswerTime = 2s;            // a caller that does not read for so long has ended
constexpr std::size_t kLongestRequest = 16;     // the longest word of the protocol, and a little
constexpr std::size_t kCommand = 0, kPage = 1;  // places of the two sockets
static_assert(kBlurredPixels <= kMostScreenPixels);

}  // namespace

SnapshotServer::SnapshotServer(const std::optional<std::filesystem::path>& folder,
                               std::function<void(SnapshotKind)> ask, SnapshotMailbox& answers, const Clock& clock)
    : ask_(std::move(ask)), answers_(answers), clock_(clock) {
  if (!folder) return;
  path_ = *folder / kSnapshotSocket;
  page_path_ = screen_socket(*folder);
  std::error_code ignored;
  std::filesystem::remove(page_path_, ignored);  // an earlier process may have been allowed to have it
  if (auto listening = listen_at(path_))
    listening_[kCommand] = std::move(*listening);
  else
    spdlog::warn("kasumi snapshot will not be answered: {}", listening.error().message);
}

SnapshotServer::~SnapshotServer() {
  std::error_code ignored;
  if (listening_[kCommand]) std::filesystem::remove(path_, ignored);
  if (listening_[kPage]) std::filesystem::remove(page_path_, ignored);
}

// The folder's permissions say which accounts may connect: the unit creates it for the reporter's group. Created here
// it is for this account alone.
void SnapshotServer::offer_page() {
  auto& listening = listening_[kPage];
  const bool wanted = answers_.for_page && !page_path_.empty();
  if (!wanted) page_failed_ = false;
  if (wanted == bool(listening) || page_failed_) return;
  std::error_code ignored;
  if (!wanted) {
    listening = UniqueFd();
    std::filesystem::remove(page_path_, ignored);
    return;
  }
  const auto folder = page_path_.parent_path();
  if (std::filesystem::create_directory(folder, ignored))
    std::filesystem::permissions(folder, std::filesystem::perms::owner_all, ignored);
  if (auto made = listen_at(page_path_)) {
    listening = std::move(*made);
  } else {
    page_failed_ = true;
    spdlog::warn("kasumi-report will get no picture of the screen: {}", made.error().message);
  }
}

void SnapshotServer::step() {
  offer_page();
  const auto caller = accept_within(listening_, kCallerWait);
  if (caller) caller->at == kPage ? answer_page(caller->socket) : answer(caller->socket);
}

void SnapshotServer::answer(const UniqueFd& caller) {
  const auto line = read_line_within(caller, kLongestRequest, kRequestDeadline);
  const auto kind = line ? parse_snapshot_request(*line) : fail(line.error());
  if (!kind) return;
  const auto snapshot = take(*kind);
  if (!snapshot) return;
  const auto sent = write_within(caller, snapshot_answer(*snapshot), kAnswerTime);
  if (!snapshot->picture.empty() && snapshot->kind == SnapshotKind::sharp)
    spdlog::info("snapshot: a sharp picture was {}", sent ? "sent" : "taken, but its caller had gone");
}

// One that is refused costs a line, which the socket takes at once.
void SnapshotServer::answer_page(const UniqueFd& caller) {
  const auto now = clock_.now();
  ScreenAnswer answer;
  if (now < next_page_) {
    answer.wait = std::chrono::ceil<std::chrono::seconds>(next_page_ - now);
  } else {
    next_page_ = now + kScreenPause;
    auto snapshot = take(SnapshotKind::page);
    if (!snapshot) return;
    answer.picture = std::move(snapshot->picture);
    answer.utc = snapshot->utc;
  }
  const auto sent = write_within(caller, screen_answer_bytes(answer), kAnswerTime);
  if (!answer.picture.empty())
    spdlog::info("snapshot: a blurred picture for the state page was {}",
                 sent ? "sent" : "taken, but its caller had gone");
}

// Nothing sharp leaves the process unless it was asked for and allowed. Empty: it did not come in time.
std::optional<Snapshot> SnapshotServer::take(SnapshotKind kind) {
  // Discard an answer meant for a caller that timed out.
  answers_.bell.wait_for({});
  answers_.taken.take();
  ask_(kind);
  if (!answers_.bell.wait_for(kPictureWait)) spdlog::warn("snapshot: the picture did not come in time");
  auto snapshot = answers_.taken.take();
  if (!snapshot || snapshot->kind != kind) return std::nullopt;
  if (kind != SnapshotKind::sharp) snapshot->picture = blurred_beyond_recognition(snapshot->picture);
  return snapshot;
}

}  // namespace kasumi

#include "pipeline/kiosk/appliance/snapshot_server.hpp"

#include <spdlog/spdlog.h>

#include "base/socket/local_socket.hpp"
#include "base/socket/screen_answer.hpp"
#include "pipeline/kiosk/snapshot/blurred_picture.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

constexpr Duration kCallerWait = 250ms;      // bounds how late a stop is noticed
constexpr Duration kFailedPause = 1min;      // where a folder is full, for one
constexpr Duration kFolderAnswers = 250ms;   // a folder in memory
constexpr Duration kRequestDeadline = 1s;    // a caller of this machine has its request ready
constexpr Duration kPictureWait = 8s;        // visitors get a notice first, and a display may have to be reopened
constexpr Duration kAnswerTime = 2s;         // a caller that does not read for so long has ended
constexpr std::size_t kLongestRequest = 16;  // the longest word of the protocol, and a little
static_assert(kBlurredPixels <= kMostScreenPixels);

}  // namespace

SnapshotServer::SnapshotServer(const std::optional<std::filesystem::path>& folder,
                               std::function<void(SnapshotKind)> ask, SnapshotMailbox& answers, const Clock& clock)
    : ask_(std::move(ask)), answers_(answers), clock_(clock) {
  if (!folder) return;
  command_.path = *folder / kSnapshotSocket;
  page_.path = screen_socket(*folder);
  offer_command();
}

SnapshotServer::~SnapshotServer() {
  shut(command_);
  shut(page_);
}

void SnapshotServer::open(Door& door, std::function<Result<UniqueFd>()> work) {
  if (listening_[door.at] || door.path.empty() || clock_.now() < door.again) return;
  auto made = door.opening.within(kFolderAnswers, std::move(work));
  if (!made) return;
  if (*made) {
    listening_[door.at] = std::move(**made);
  } else {
    door.again = clock_.now() + kFailedPause;
    if (!door.failed) spdlog::warn("{}: {}", door.lost, made->error().message);
  }
  door.failed = !*made;
}

void SnapshotServer::shut(Door& door) {
  if (!listening_[door.at]) return;
  listening_[door.at] = UniqueFd();
  OneAtATime<bool>().within(kFolderAnswers, [path = door.path] {
    std::error_code ignored;
    return std::filesystem::remove(path, ignored);
  });
}

void SnapshotServer::offer_command() {
  open(command_, [path = command_.path, page = page_.path] {
    std::error_code ignored;
    std::filesystem::remove(page, ignored);  // an earlier process may have been allowed to have it
    return listen_at(path);
  });
}

// The folder's permissions say which accounts may connect: the unit creates it for the reporter's group. Created here
// it is for this account alone.
void SnapshotServer::offer_page() {
  if (!answers_.for_page) {
    page_.failed = false;
    page_.again = Instant::min();
    return shut(page_);
  }
  open(page_, [path = page_.path] {
    const auto folder = path.parent_path();
    std::error_code ignored;
    if (std::filesystem::create_directory(folder, ignored))
      std::filesystem::permissions(folder, std::filesystem::perms::owner_all, ignored);
    return listen_at(path);
  });
}

void SnapshotServer::step() {
  offer_command();
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

#include "pipeline/appliance/snapshot_server.hpp"

#include <thread>

#include <spdlog/spdlog.h>

#include "base/socket/local_socket.hpp"
#include "pipeline/snapshot/blurred_picture.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

constexpr Duration kCallerWait = 250ms;
constexpr Duration kRequestDeadline = 1s;
constexpr Duration kPictureWait = 8s;  // visitors are told first, and a display may have to be reopened
constexpr Duration kAnswerTime = 2s;
constexpr std::size_t kLongestRequest = 16;

}  // namespace

SnapshotServer::SnapshotServer(const std::optional<std::filesystem::path>& folder,
                               std::function<void(SnapshotKind)> ask, SnapshotMailbox& answers)
    : ask_(std::move(ask)), answers_(answers) {
  if (!folder) return;
  path_ = *folder / kSnapshotSocket;
  if (auto listening = listen_at(path_))
    listening_ = std::move(*listening);
  else
    spdlog::warn("kasumi snapshot will not be answered: {}", listening.error().message);
}

SnapshotServer::~SnapshotServer() {
  std::error_code ignored;
  if (listening_) std::filesystem::remove(path_, ignored);
}

void SnapshotServer::step() {
  if (!listening_) return std::this_thread::sleep_for(kCallerWait);
  if (const auto caller = accept_within(listening_, kCallerWait)) answer(caller);
}

void SnapshotServer::answer(const UniqueFd& caller) {
  const auto line = read_line_within(caller, kLongestRequest, kRequestDeadline);
  const auto kind = line ? parse_snapshot_request(*line) : fail(line.error());
  if (!kind) return;
  // Of a caller who was given up.
  answers_.bell.wait_for({});
  answers_.taken.take();
  ask_(*kind);
  if (!answers_.bell.wait_for(kPictureWait)) spdlog::warn("snapshot: the picture did not come in time");
  auto snapshot = answers_.taken.take();
  if (!snapshot || snapshot->kind != *kind) return;
  // Nothing sharp leaves the process unless it was asked for and allowed.
  if (snapshot->kind != SnapshotKind::sharp) snapshot->picture = blurred_beyond_recognition(snapshot->picture);
  const auto sent = write_within(caller, snapshot_answer(*snapshot), kAnswerTime);
  if (!snapshot->picture.empty() && snapshot->kind == SnapshotKind::sharp)
    spdlog::info("snapshot: a sharp picture was {}", sent ? "sent" : "taken, but nobody waited for it");
}

}  // namespace kasumi

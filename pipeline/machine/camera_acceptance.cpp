#include "pipeline/machine/camera_acceptance.hpp"

#include <algorithm>
#include <set>

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kTrial = 4s;  // the appliance gives a camera up after that
constexpr int kEnoughBad = 10;   // frames in a row: a damaged one alone says nothing

bool is_here(const CameraOptions& options) {
  std::error_code error;
  if (const auto* replay = std::get_if<ReplayCamera>(&options)) return std::filesystem::exists(replay->fixture, error);
  if (const auto* v4l2 = std::get_if<V4l2Options>(&options)) return std::filesystem::exists(v4l2->device, error);
  return true;
}

// Empty: a frame that can be used has come, or nothing is known.
std::string problem_of(FrameSource& source, const Camera& camera, Clock& clock, Duration longest, bool recorded) {
  std::map<std::string, std::uint64_t> bad;
  int looked = 0;
  for (const auto until = clock.now() + longest; clock.now() < until && looked < kEnoughBad;) {
    const auto frame = source.next(until);
    if (!frame && frame.error().kind == FaultKind::timeout) continue;
    if (!frame) return recorded ? frame.error().message : std::string();
    ++looked;
    const auto why = why_unusable(*frame, camera);
    if (why.empty()) return {};
    ++bad[why];
  }
  if (!bad.empty()) return "no picture of it can be used: " + commonest(bad);
  return recorded ? "no picture came of it" : std::string();
}

}  // namespace

std::string why_unusable(const FrameMetadata& frame, const Camera& camera) {
  if (frame.width == camera.width && frame.height == camera.height) return {};
  return fmt::format("{}x{} instead of {}x{}", frame.width, frame.height, camera.width, camera.height);
}

std::string why_unusable(const Frame& frame, const Camera& camera) {
  if (frame.metadata.status != FrameStatus::good) return std::string(name_of(frame.metadata.status));
  if (auto why = why_unusable(frame.metadata, camera); !why.empty()) return why;
  const auto picture = decode(frame, camera.yuv_encoding);
  return picture ? std::string() : picture.error().message;
}

std::string commonest(const std::map<std::string, std::uint64_t>& reasons) {
  const auto most = std::ranges::max_element(reasons, {}, [](const auto& reason) { return reason.second; });
  return most == reasons.end() ? std::string() : fmt::format("{} ({})", most->first, most->second);
}

Result<> try_cameras(const RunConfig& config, Devices& devices, Clock& clock, std::vector<std::string>& untried) {
  Problems problems;
  std::set<std::string> reported;  // a recording that both cameras share is broken once
  const auto add = [&](const char* name, const std::string& why) {
    if (reported.insert(why).second) problems.add("[{}.camera]: {}", name, why);
  };
  struct Tried {
    const char* name;
    CameraRole role;
    const CameraOptions& options;
    const Camera& camera;
  };
  const auto& installation = config.installation;
  for (const auto& [name, role, options, camera] :
       {Tried{"scene", CameraRole::scene, config.scene_camera, installation.scene},
        Tried{"sky", CameraRole::sky, config.sky_camera, installation.sky}}) {
    if (!is_here(options)) {
      untried.push_back(fmt::format("{} camera: not here: whether its pictures can be used is not known", name));
      continue;
    }
    const auto opening = devices.camera(role, options);
    const auto source = opening.opener.open();
    if (!source && opening.recorded) add(name, source.error().message);
    if (!source && !opening.recorded)
      untried.push_back(fmt::format("{} camera: not tried: {}", name, source.error().message));
    if (!source) continue;
    const auto longest = std::max(kTrial, opening.frame_interval * 5 / 2);
    if (const auto why = problem_of(**source, camera, clock, longest, opening.recorded); !why.empty()) add(name, why);
  }
  if (!problems.empty()) return fail(problems.fault());
  return {};
}

}  // namespace kasumi

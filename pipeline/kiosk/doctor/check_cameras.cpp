#include <algorithm>

#include "pipeline/kiosk/doctor/checks.hpp"
#include "pipeline/machine/camera_acceptance.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr Duration kFirstFrame = 4s;  // the appliance gives up after that
constexpr double kSlowFirstFrame_s = 2.0;
constexpr double kUsb2Bytes = 24e6;  // per second: video that fits into USB 2.0's 480 Mbit/s
constexpr double kUsb2_mbit = 480.0;
constexpr const char* kRecordAgain = "record it again, or name another recording: fixture";

bool is_number_name(const std::filesystem::path& device) {
  const auto name = device.filename().string();
  return device.parent_path() == "/dev" && name.starts_with("video");
}

std::string offers(const std::vector<V4l2Listing>& cameras) {
  if (cameras.empty()) return "no camera is connected";
  std::string text = "connected:";
  for (const auto& camera : cameras)
    text += fmt::format(" {} ({})",
                        camera.stable_paths.empty() ? camera.node.string() : camera.stable_paths.front().string(),
                        camera.card);
  return text;
}

// Maps "/dev/v4l/..." into places.dev.
std::filesystem::path placed(const MachinePlaces& places, const std::filesystem::path& device) {
  const auto text = device.string();
  return text.starts_with("/dev/") ? places.dev / text.substr(5) : device;
}

double bytes_per_pixel(FourCc format) {
  if (format == four_cc("NV12") || format == four_cc("YU12")) return 1.5;
  if (format == four_cc("GREY")) return 1.0;
  if (format == four_cc("YUYV") || format == four_cc("UYVY")) return 2.0;
  if (format == four_cc("RGB3") || format == four_cc("BGR3")) return 3.0;
  return 4.0;
}

std::string list_of(const std::map<std::string, std::uint64_t>& counts) {
  std::string text;
  for (const auto& [reason, count] : counts) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, reason);
  return text;
}

}  // namespace

const CameraRequest* request_of(const CameraOptions& options) {
  if (const auto* v4l2 = std::get_if<V4l2Options>(&options)) return &v4l2->request;
  if (const auto* libcamera = std::get_if<LibcameraOptions>(&options)) return &libcamera->request;
  return nullptr;
}

OpeningTrial measure_camera(const SourceOpener& opener, const Camera& configured, Clock& clock, Duration length) {
  OpeningTrial measurement;
  auto source = opener.open();
  if (!source) {
    measurement.problem = source.error().message;
    return measurement;
  }
  measurement.opened = true;
  const auto opened_at = clock.now();
  std::optional<Instant> first;
  std::optional<std::uint32_t> sequence;
  for (;;) {
    const auto until = first ? *first + length : opened_at + kFirstFrame;
    if (clock.now() >= until) break;
    const auto frame = (*source)->next(until);
    if (!frame && frame.error().kind == FaultKind::timeout) continue;
    if (!frame) {
      measurement.problem = frame.error().message;
      break;
    }
    const auto& metadata = frame->metadata;
    const auto why = why_unusable(*frame, configured);
    const bool good = why.empty();
    if (!good) ++measurement.bad[why];
    if (sequence && metadata.sequence > *sequence + 1) measurement.gaps += metadata.sequence - *sequence - 1;
    sequence = metadata.sequence;
    if (first) {
      measurement.good += good;
    } else if (good) {
      first = clock.now();
      measurement.first_frame_s = to_seconds(*first - opened_at);
    }
  }
  if (first) measurement.lasted_s = to_seconds(clock.now() - *first);
  if (!first && measurement.problem.empty() && !measurement.bad.empty())
    measurement.problem = "no frame can be used: " + commonest(measurement.bad);
  if (!first && measurement.problem.empty())
    measurement.problem = fmt::format("no good frame arrived within {:.0f} s", to_seconds(kFirstFrame));
  if (const auto* camera = dynamic_cast<const CameraSource*>(source->get())) measurement.mode = camera->mode();
  return measurement;
}

void check_camera_path(const MachinePlaces& places, const std::string& name, const CameraOptions& options,
                       Findings& findings) {
  const auto check = name + ".path";
  if (const auto* replay = std::get_if<ReplayCamera>(&options)) {
    findings.good(check, "a recording: " + replay->fixture.string());
    return;
  }
  if (const auto* libcamera = std::get_if<LibcameraOptions>(&options)) {
    const auto cameras = list_libcamera_cameras();
    if (!cameras) {
      findings.fail(check, cameras.error().message, "install a build with libcamera, or use source = \"v4l2\"");
      return;
    }
    std::string ids;
    for (const auto& camera : *cameras) {
      if (camera.id == libcamera->camera) {
        findings.good(check, fmt::format("{}, {}", camera.id, camera.model));
        return;
      }
      ids += fmt::format("{}{} ({})", ids.empty() ? "" : ", ", camera.id, camera.model);
    }
    findings.fail(
        check, fmt::format("{} is not connected", libcamera->camera),
        ids.empty() ? "check cables and power; libcamera finds no camera (cam -l)" : "libcamera finds: " + ids);
    return;
  }
  const auto& device = std::get<V4l2Options>(options).device;
  const auto here = placed(places, device);
  std::error_code error;
  const auto node = std::filesystem::canonical(here, error);
  if (error) {
    findings.fail(check, device.string() + " does not exist",
                  "check cable, hub, power (dmesg | tail); " + offers(list_v4l2_cameras(places.dev)));
    return;
  }
  if (is_number_name(device)) {
    std::string stable = "ls -l /dev/v4l/by-id /dev/v4l/by-path";
    for (const auto& camera : list_v4l2_cameras(places.dev))
      if (camera.node == node && !camera.stable_paths.empty())
        stable = "write device = \"" + camera.stable_paths.front().string() + "\"";
    findings.warn(check, device.string() + " may be another camera after the next boot", stable);
    return;
  }
  findings.good(check, fmt::format("{} is {}", device.string(), node.filename().string()));
}

void check_camera_usb(const MachinePlaces& places, const std::string& name, const CameraOptions& options,
                      Findings& findings) {
  const auto* v4l2 = std::get_if<V4l2Options>(&options);
  if (!v4l2) return;
  std::error_code error;
  const auto node = std::filesystem::canonical(placed(places, v4l2->device), error);
  if (error) return;  // check_camera_path() reports it
  auto folder = std::filesystem::canonical(places.sys / "class/video4linux" / node.filename() / "device", error);
  if (error) return;
  std::optional<double> speed;
  for (; folder.has_relative_path() && folder != places.sys && !speed; folder = folder.parent_path())
    speed = number_of(folder / "speed");
  if (!speed) return;  // not on USB
  const auto& request = v4l2->request;
  const bool raw = request.format && *request.format != kMjpg;
  const double rate = request.frames_per_second > 0.0 ? request.frames_per_second : 30.0;
  const double need = raw ? rate * request.width * request.height * bytes_per_pixel(*request.format) : 0.0;
  const auto found = fmt::format("{:.0f} Mbit/s", *speed);
  auto& finding =
      *speed < kUsb2_mbit ? findings.fail(name + ".usb", found + ": too slow for video",
                                          "use another port or hub; a worn cable also causes this")
      : *speed <= kUsb2_mbit && need > kUsb2Bytes
          ? findings.warn(name + ".usb",
                          fmt::format("{}, and {} at this size and rate takes {:.0f} MB/s of the available {:.0f}",
                                      found, request.format->text(), need / 1e6, kUsb2Bytes / 1e6),
                          "format = \"MJPG\", fewer frames_per_second, or a USB 3 port with a USB 3 cable")
          : findings.good(name + ".usb", found);
  finding.values["mbit_per_s"] = *speed;
}

void check_camera(const std::string& name, const CameraOptions& options, const OpeningTrial& camera,
                  Findings& findings) {
  if (!camera.opened) {
    findings.fail(name + ".open", camera.problem,
                  request_of(options) ? "in use? sudo fuser -v /dev/video*; permission? id must show the group video"
                                      : kRecordAgain);
    return;
  }
  const auto* request = request_of(options);
  if (camera.mode) {
    const auto& mode = *camera.mode;
    std::string notes;
    for (const auto& note : mode.notes) notes += (notes.empty() ? "" : "; ") + note;
    const auto found = fmt::format("{} ({}, {}): {} {}x{} at {:.4g} frames a second", mode.card, mode.driver,
                                   mode.place, mode.format.text(), mode.width, mode.height, mode.frames_per_second);
    if (notes.empty())
      findings.good(name + ".mode", found);
    else
      findings.warn(name + ".mode", found + "; differs from the request: " + notes,
                    "v4l2-ctl -d DEVICE --list-formats-ext and --list-ctrls list what it supports; configure that");
  }
  if (!camera.first_frame_s) {
    const bool other_size = camera.problem.find(" instead of ") != std::string::npos;
    findings.fail(name + ".first_frame", camera.problem,
                  other_size ? "ask the camera for the size it was calibrated at, or calibrate it at this one"
                  : !request_of(options) ? kRecordAgain
                                         : "replug it; try another port; dmesg | tail; too little bandwidth for two "
                                           "cameras on one hub?");
    return;
  }
  const auto first = fmt::format("after {:.2f} s", *camera.first_frame_s);
  auto& finding = *camera.first_frame_s > kSlowFirstFrame_s
                      ? findings.warn(name + ".first_frame", first, "every reconnection takes this long")
                      : findings.good(name + ".first_frame", first);
  finding.values["seconds"] = *camera.first_frame_s;

  const double rate = camera.lasted_s > 0.0 ? static_cast<double>(camera.good) / camera.lasted_s : 0.0;
  double asked = request ? request->frames_per_second : 0.0;
  if (asked == 0.0 && camera.mode) asked = camera.mode->frames_per_second;
  const auto rates = asked > 0.0 ? fmt::format("{:.1f} frames a second of {:.4g}", rate, asked)
                                 : fmt::format("{:.1f} frames a second", rate);
  const char* advice = "dark scenes make cameras slow (exposure_s); USB bandwidth; the machine's load (top)";
  auto& rated = camera.good == 0 && asked > 1.0 ? findings.fail(name + ".rate", rates, advice)
                : 0.9 * asked * camera.lasted_s - static_cast<double>(camera.good) > 1.0
                    ? findings.warn(name + ".rate", rates, advice)
                    : findings.good(name + ".rate", rates);
  rated.values = {{"frames_per_second", rate}, {"asked_frames_per_second", asked}};

  std::uint64_t bad = 0;
  for (const auto& [reason, count] : camera.bad) bad += count;
  const char* cable = "cable, hub, interference; dmesg | tail";
  auto& frames = bad > camera.good / 10 ? findings.fail(name + ".frames", list_of(camera.bad), cable)
                 : bad > 0              ? findings.warn(name + ".frames", list_of(camera.bad), cable)
                 : camera.gaps > 0
                     ? findings.warn(name + ".frames", fmt::format("{} dropped by the driver", camera.gaps), cable)
                     : findings.good(name + ".frames", "all intact");
  frames.values = {{"bad", static_cast<double>(bad)}, {"dropped", static_cast<double>(camera.gaps)}};
}

}  // namespace kasumi

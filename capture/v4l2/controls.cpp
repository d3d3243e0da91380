#include "capture/v4l2/controls.hpp"

#include <linux/v4l2-controls.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>

namespace kasumi {

namespace {

constexpr double kExposureStep_s = 100e-6;  // unit of V4L2_CID_EXPOSURE_ABSOLUTE

// The controls of one device. Missing or refused controls are ordinary results; only an unplugged device is a fault.
class Controls {
 public:
  explicit Controls(VideoDevice& device) : device_(device) {}

  std::optional<v4l2_queryctrl> find(std::uint32_t id) {
    v4l2_queryctrl query{};
    query.id = id;
    if (!answered(device_.control(VIDIOC_QUERYCTRL, &query))) return std::nullopt;
    if ((query.flags & V4L2_CTRL_FLAG_DISABLED) != 0) return std::nullopt;
    return query;
  }

  bool set(std::uint32_t id, std::int32_t value) {
    v4l2_control control{id, value};
    return answered(device_.control(VIDIOC_S_CTRL, &control));
  }

  std::optional<std::int32_t> read(std::uint32_t id) {
    v4l2_control control{id, 0};
    if (!answered(device_.control(VIDIOC_G_CTRL, &control))) return std::nullopt;
    return control.value;
  }

  // Sets the first of these menu items that the driver offers.
  bool choose(std::uint32_t id, std::initializer_list<std::int32_t> items) {
    for (const auto item : items) {
      v4l2_querymenu query{};
      query.id = id;
      query.index = static_cast<std::uint32_t>(item);
      if (answered(device_.control(VIDIOC_QUERYMENU, &query)) && set(id, item)) return true;
    }
    return false;
  }

  Result<> gone() const {
    if (gone_) return fail(*gone_);
    return {};
  }

 private:
  bool answered(int error) {
    if (error == 0) return true;
    if (auto fault = device_fault(error, "camera controls"); fault.kind == FaultKind::disconnected)
      gone_ = std::move(fault);
    return false;
  }

  VideoDevice& device_;
  std::optional<Fault> gone_;
};

// The nearest value to `wanted` that the control accepts.
std::int32_t within(const v4l2_queryctrl& range, double wanted) {
  const double step = std::max(1, range.step);
  const double steps = std::round((std::clamp<double>(wanted, range.minimum, range.maximum) - range.minimum) / step);
  return static_cast<std::int32_t>(range.minimum + steps * step);
}

// Sets and reads back; empty when the control is missing or refuses. Notes differences of more than one percent.
std::optional<double> set_number(Controls& controls, std::uint32_t id, double wanted, double unit,
                                 std::string_view name, CameraMode& mode) {
  const auto range = controls.find(id);
  if (!range) {
    mode.notes.push_back(fmt::format("{}: the camera has no such control", name));
    return std::nullopt;
  }
  const bool taken = controls.set(id, within(*range, wanted / unit));
  const auto now = controls.read(id);
  if (!taken || !now) {
    mode.notes.push_back(fmt::format("{} {:.4g}: the driver refuses it", name, wanted));
    return now ? std::optional(*now * unit) : std::nullopt;
  }
  const double is = *now * unit;
  if (std::abs(is - wanted) > 0.01 * std::abs(wanted))
    mode.notes.push_back(fmt::format("{} {:.4g} requested: the camera uses {:.4g} ({:.4g} .. {:.4g})", name, wanted, is,
                                     range->minimum * unit, range->maximum * unit));
  return is;
}

void set_exposure(Controls& controls, std::optional<double> wanted_s, CameraMode& mode) {
  // The camera must not reduce its frame rate for longer exposures: motion would stutter at dusk.
  if (controls.find(V4L2_CID_EXPOSURE_AUTO_PRIORITY)) controls.set(V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0);
  const bool has_auto = controls.find(V4L2_CID_EXPOSURE_AUTO).has_value();
  if (!wanted_s) {
    if (has_auto) controls.choose(V4L2_CID_EXPOSURE_AUTO, {V4L2_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY});
    return;
  }
  if (has_auto && !controls.choose(V4L2_CID_EXPOSURE_AUTO, {V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_SHUTTER_PRIORITY}))
    mode.notes.push_back("exposure: the driver does not switch off auto exposure");
  mode.exposure_s =
      set_number(controls, V4L2_CID_EXPOSURE_ABSOLUTE, *wanted_s, kExposureStep_s, "exposure in seconds", mode);
}

void set_gain(Controls& controls, std::optional<double> wanted, CameraMode& mode) {
  const bool has_auto = controls.find(V4L2_CID_AUTOGAIN).has_value();
  if (!wanted) {
    if (has_auto) controls.set(V4L2_CID_AUTOGAIN, 1);
    return;
  }
  if (has_auto && !controls.set(V4L2_CID_AUTOGAIN, 0))
    mode.notes.push_back("gain: the driver does not switch off auto gain");
  const auto id = controls.find(V4L2_CID_GAIN) ? V4L2_CID_GAIN : V4L2_CID_ANALOGUE_GAIN;
  mode.gain = set_number(controls, id, *wanted, 1.0, "gain in the driver's units", mode);
}

void set_white_balance(Controls& controls, const CameraRequest& request, CameraMode& mode) {
  const bool has_auto = controls.find(V4L2_CID_AUTO_WHITE_BALANCE).has_value();
  if (!request.white_balance_k) {
    if (has_auto) controls.set(V4L2_CID_AUTO_WHITE_BALANCE, 1);
    return;
  }
  if (has_auto && !controls.set(V4L2_CID_AUTO_WHITE_BALANCE, 0))
    mode.notes.push_back("white balance: the driver does not switch off auto white balance");
  mode.white_balance_k = set_number(controls, V4L2_CID_WHITE_BALANCE_TEMPERATURE, *request.white_balance_k, 1.0,
                                    "white balance in kelvin", mode);
}

}  // namespace

Result<> set_v4l2_controls(VideoDevice& device, const CameraRequest& request, CameraMode& mode) {
  Controls controls(device);
  set_exposure(controls, request.exposure_s, mode);
  set_gain(controls, request.gain, mode);
  set_white_balance(controls, request, mode);
  return controls.gone();
}

Result<> lock_v4l2_white_balance(VideoDevice& device, CameraMode& mode) {
  Controls controls(device);
  if (!controls.find(V4L2_CID_AUTO_WHITE_BALANCE)) {
    if (auto gone = controls.gone(); !gone) return gone;
    mode.notes.push_back("white balance: the camera cannot lock it");
    return {};
  }
  if (!controls.set(V4L2_CID_AUTO_WHITE_BALANCE, 0)) mode.notes.push_back("white balance: the driver does not lock it");
  if (controls.find(V4L2_CID_WHITE_BALANCE_TEMPERATURE))
    if (const auto kelvin = controls.read(V4L2_CID_WHITE_BALANCE_TEMPERATURE)) mode.white_balance_k = *kelvin;
  return controls.gone();
}

}  // namespace kasumi

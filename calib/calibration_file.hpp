// The calibration file: [site], [sky] and [scene] as docs/cameras.md describes them, with the date and
// source of each measurement. Written step by step; each step keeps the results of the others and backs up the file.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "calib/camera.hpp"
#include "calib/lens/lens_description.hpp"

namespace kasumi {

constexpr int kCalibrationFormat = 1;

// The result of one step, under [CAMERA.measured.WHAT]. Nothing is computed from it.
struct Measured {
  std::string what;  // "lens", "orientation"
  std::string utc;   // ISO 8601
  std::string from;  // "15 pictures of a checkerboard of 6 x 8 inner corners: a.jpg, ..."
  std::vector<std::pair<std::string, double>> numbers;  // key with its unit, value
  std::vector<std::string> remarks;                     // dropped views, what is undetermined
  std::string picture{};  // file name of the step's drawing, next to the calibration file; empty: none
};

// A response as it was measured: linear light at evenly spaced values, for each channel; empty tables: linear.
struct MeasuredCurve {
  std::array<std::vector<double>, 3> light;
  bool linear() const { return light[0].empty(); }
};

struct CalibrationStep {
  std::string camera;  // "sky", "scene"
  int width = 0;
  int height = 0;
  std::string serial;  // of the camera; empty: as it was
  std::optional<LensDescription> lens;
  std::optional<glm::dmat3> to_world;   // written as heading_deg, pitch_deg, roll_deg
  std::optional<std::string> response;  // "srgb", "linear"; only where the file has none
  std::optional<MeasuredCurve> curve;   // replaces an existing response
  std::optional<Vignetting> vignetting;
  std::optional<std::string> sensitivity;  // file name, next to the calibration file; the sensor's spectral sensitivity
  std::optional<glm::dvec3> white_balance;
  std::optional<std::string> mask;  // file name, next to the calibration file
  // Shot and read noise; of the scene camera alone, whose pictures something is drawn into.
  struct Noise {
    double full_scale_electrons = 0.0;
    double read_electrons = 0.0;
  };
  std::optional<Noise> noise;
  // How its lens blurs, its processor sharpens and its stream is coded; of the scene camera alone, too.
  struct Focus {
    double point_spread_px = 0.0;
    double sharpening = 0.0;
    bool jpeg = false;
  };
  std::optional<Focus> focus;
  std::optional<Site> site;    // only where the file has none
  std::string calibrated_utc;  // ISO 8601; becomes [CAMERA] calibrated_utc
  std::vector<Measured> measured;
};

struct CalibrationWritten {
  std::optional<std::filesystem::path> backup;  // of the file that was there
};
// Errors: bad_input (the file there is no calibration file, or of pictures of another size), io.
Result<CalibrationWritten> write_calibration(const std::filesystem::path& path, const CalibrationStep& step);

// The file name of a step's drawing: calibration.CAMERA-WHAT.png next to calibration.toml. `kasumi calibrate report`
// looks there, and under the key `picture`.
std::filesystem::path drawing_name(const std::filesystem::path& calibration, std::string_view camera,
                                   std::string_view what);

// heading, pitch and roll of a camera, as camera_to_world takes them.
struct HeadingPitchRoll {
  Radians heading, pitch, roll;
};
HeadingPitchRoll heading_pitch_roll(const glm::dmat3& to_world);

}  // namespace kasumi

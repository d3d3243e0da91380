// The files of calibration programs, one function each. All take the file's text and give errors (bad_input) without
// its name.
#pragma once

#include <string>

#include "calib/lens/foreign_lens.hpp"

namespace kasumi {

// What a file leaves open: "auto", or "pinhole" or "opencv_fisheye" for coefficients that may be either's.
struct ImportQuestions {
  std::string model = "auto";
  std::string camera;  // which of several (choose_camera.hpp); empty: there is one
};

// OpenCV's samples and scripts, its interactive calibration (cameraResolution), omnidir (xi); ROS' camera_info; Kalibr's
// camchain; ORB-SLAM's settings.
Result<ForeignLens> read_keyed_lens(const std::string& text, const ImportQuestions& questions);
bool is_kalibr(const std::string& text);  // a camchain
bool is_colmap(const std::string& text);  // cameras.txt
Result<ForeignLens> read_colmap_lens(const std::string& text, const ImportQuestions& questions);
bool is_agisoft(const std::string& text);  // <calibration> of Metashape, PhotoScan
Result<ForeignLens> read_agisoft_lens(const std::string& text);
bool is_hugin(const std::string& text);  // a .pto project
Result<ForeignLens> read_hugin_lens(const std::string& text);

}  // namespace kasumi

// The structure as data: which folder may include which, and which files may include each library.
// docs/architecture.md shows the same to people, and test_architecture_page.cpp compares the two.
#pragma once

#include <map>
#include <set>
#include <string>

namespace kasumi::house {

using Walls = std::map<std::string, std::set<std::string>>;

// A room may include whole rooms. Inside, a room's own folder and each sub-room may include these of the same room,
// named in full; what a room may include of others, its sub-rooms may too.
inline const Walls kMayInclude = {
    {"base", {}},
    {"base/manual", {}},
    {"base/picture_files", {"base"}},
    {"base/sky", {"base"}},
    {"base/socket", {"base"}},
    {"base/table", {"base"}},
    {"base/words", {"base"}},

    {"calib", {"base", "calib/colour", "calib/lens", "calib/light"}},
    {"calib/board", {}},
    {"calib/colour", {"calib/light"}},
    {"calib/lens", {"calib/board"}},
    {"calib/light", {"calib/lens"}},
    {"calib/mask", {"calib"}},
    {"calib/pose", {"calib", "calib/lens", "calib/mask"}},

    {"capture", {"base"}},
    {"capture/codec", {"capture"}},
    {"capture/fixture", {"capture"}},
    {"capture/libcamera", {"capture"}},
    {"capture/v4l2", {"capture"}},

    {"estimator", {"base", "calib"}},
    {"estimator/air", {"estimator"}},
    {"estimator/cloud_cover", {"estimator", "estimator/turbidity"}},
    {"estimator/fusion", {"estimator", "estimator/air", "estimator/horizon", "estimator/sky", "estimator/sky_fit"}},
    {"estimator/ground", {}},
    {"estimator/haze", {"estimator/air"}},
    {"estimator/horizon", {}},
    {"estimator/landmarks", {"estimator/air", "estimator/fusion", "estimator/horizon"}},
    {"estimator/light", {"estimator", "estimator/air", "estimator/horizon", "estimator/sky", "estimator/turbidity"}},
    {"estimator/passers", {}},
    {"estimator/photograph", {"estimator/air", "estimator/horizon", "estimator/light"}},
    {"estimator/sky", {"estimator", "estimator/air"}},
    {"estimator/sky_camera", {"estimator", "estimator/air", "estimator/sky", "estimator/turbidity"}},
    {"estimator/sky_fit", {"estimator", "estimator/air", "estimator/sky"}},
    {"estimator/turbidity", {"estimator", "estimator/sky", "estimator/sky_fit"}},

    {"gles", {"base"}},
    {"gles/air", {"gles/gl"}},
    {"gles/display", {"gles/gl", "gles/picture"}},
    {"gles/gl", {"gles/model"}},
    {"gles/gpu_model", {"gles", "gles/gl", "gles/model"}},
    {"gles/light", {"gles", "gles/gl", "gles/model"}},
    {"gles/model", {}},
    {"gles/object", {"gles", "gles/gl", "gles/gpu_model", "gles/light", "gles/model", "gles/picture", "gles/shadow"}},
    {"gles/picture", {"gles", "gles/gl"}},
    {"gles/shadow", {"gles/gl", "gles/gpu_model"}},

    {"history", {"base"}},

    {"pipeline", {"base", "calib", "capture", "estimator", "gles", "history"}},
    {"pipeline/appliance",
     {"pipeline", "pipeline/camera_drift", "pipeline/config", "pipeline/content", "pipeline/doctor", "pipeline/loop",
      "pipeline/machine", "pipeline/scene", "pipeline/snapshot", "pipeline/stage", "pipeline/start"}},
    {"pipeline/bench", {"pipeline", "pipeline/scene", "pipeline/sky"}},
    {"pipeline/calibrate",
     {"pipeline", "pipeline/calibration_report", "pipeline/camera_drift", "pipeline/config", "pipeline/files",
      "pipeline/machine"}},
    {"pipeline/calibration_report", {"pipeline/config", "pipeline/files"}},
    {"pipeline/camera_drift", {"pipeline/config", "pipeline/files", "pipeline/machine"}},
    {"pipeline/comparison", {"pipeline", "pipeline/files"}},
    {"pipeline/config", {"pipeline/files"}},
    {"pipeline/content", {"pipeline", "pipeline/config", "pipeline/machine", "pipeline/stage", "pipeline/start"}},
    {"pipeline/doctor", {"pipeline", "pipeline/config", "pipeline/content", "pipeline/machine"}},
    {"pipeline/files", {}},
    {"pipeline/haze",
     {"pipeline", "pipeline/config", "pipeline/files", "pipeline/photographs", "pipeline/scene", "pipeline/stage"}},
    {"pipeline/loop", {"pipeline/machine"}},
    {"pipeline/machine", {"pipeline/config"}},
    {"pipeline/past", {"pipeline"}},
    {"pipeline/photographs", {"pipeline", "pipeline/config", "pipeline/files", "pipeline/machine"}},
    {"pipeline/recording",
     {"pipeline", "pipeline/config", "pipeline/files", "pipeline/machine", "pipeline/scene", "pipeline/stage"}},
    {"pipeline/scene", {"pipeline/config"}},
    {"pipeline/sky", {"pipeline", "pipeline/files", "pipeline/machine"}},
    {"pipeline/snapshot", {"pipeline"}},
    {"pipeline/stage", {"pipeline/config", "pipeline/scene"}},
    {"pipeline/start", {"pipeline/config", "pipeline/scene"}},

    {"report", {"base", "history", "report/channels", "report/page", "report/status", "report/web"}},
    {"report/channels", {"report/status", "report/web"}},
    {"report/page", {"report/status", "report/web"}},
    {"report/status", {}},
    {"report/web", {}},

    {"fixtures", {"base", "calib", "capture", "fixtures/generator", "fixtures/model", "fixtures/temple"}},
    {"fixtures/aerosol", {}},
    {"fixtures/assemble", {}},
    {"fixtures/atmosphere", {"fixtures/aerosol", "fixtures/model", "fixtures/spectrum"}},
    {"fixtures/generator",
     {"fixtures/in_front", "fixtures/landscape", "fixtures/light", "fixtures/model", "fixtures/noise",
      "fixtures/pagoda", "fixtures/spectrum", "fixtures/temple"}},
    {"fixtures/in_front", {"fixtures/landscape", "fixtures/light", "fixtures/noise", "fixtures/spectrum"}},
    {"fixtures/landscape", {"fixtures/light", "fixtures/model", "fixtures/noise", "fixtures/spectrum"}},
    {"fixtures/light", {"fixtures/aerosol", "fixtures/atmosphere", "fixtures/noise", "fixtures/spectrum"}},
    {"fixtures/model", {}},
    {"fixtures/noise", {}},
    {"fixtures/pagoda", {"fixtures/landscape", "fixtures/model", "fixtures/noise"}},
    {"fixtures/spectrum", {}},
    {"fixtures/temple", {"fixtures/model", "fixtures/noise"}},
};

// The sub-rooms of pipeline that each serve one purpose of the program: none includes another, but for the pairs named.
inline const std::set<std::string> kVerticals = {
    "pipeline/appliance",  "pipeline/bench",       "pipeline/calibrate", "pipeline/camera_drift",
    "pipeline/comparison", "pipeline/doctor",      "pipeline/haze",      "pipeline/past",
    "pipeline/sky",        "pipeline/photographs", "pipeline/recording",
};
inline const Walls kVerticalsMayInclude = {
    {"pipeline/appliance", {"pipeline/camera_drift", "pipeline/doctor"}},
    {"pipeline/calibrate", {"pipeline/camera_drift"}},
    {"pipeline/bench", {"pipeline/sky"}},
};

// Prefixes of a library's headers, and of the names of the files that may include them; * matches anything.
inline const Walls kLibraryDoors = {
    {"CLI/",
     {"base/finite_options.cpp", "base/manual/", "pipeline/air_options.cpp", "pipeline/command_line.cpp",
      "pipeline/main.cpp", "pipeline/*/command_", "pipeline/calibrate/board_options.cpp", "pipeline/haze/",
      "pipeline/photographs/", "report/main.cpp", "fixtures/*main.cpp"}},
    {"EGL/", {"gles/gl/"}},
    {"Eigen/",
     {"calib/", "estimator/horizon/", "estimator/landmarks/", "estimator/passers/", "estimator/sky_",
      "fixtures/atmosphere/", "fixtures/light/"}},
    {"GLES2/", {"gles/gl/", "pipeline/bench/gles_"}},
    {"SDL", {"gles/display/window.cpp"}},
    {"archive", {"pipeline/content/"}},
    {"ceres/", {"calib/lens/", "calib/pose/", "estimator/air/attenuation_nodes.cpp", "fixtures/atmosphere/"}},
    {"curl/", {"report/web/"}},
    {"date/", {"pipeline/config/opening_hours.cpp"}},
    {"drm", {"gles/display/kms_drm"}},
    {"erfa", {"estimator/sky/sun.cpp"}},
    {"ft2build.h", {"pipeline/stage/caption.cpp"}},
    {"gbm.h", {"gles/display/kms_scanout_gbm.cpp"}},
    {"jpeglib.h", {"base/picture_files/"}},
    {"libcamera/", {"capture/libcamera/"}},
    {"libudev.h", {"gles/display/kms_udev.cpp"}},
    {"linux/cec.h", {"pipeline/machine/television.cpp"}},
    {"linux/v4l2-controls.h", {"capture/v4l2/"}},
    {"linux/videodev2.h", {"capture/v4l2/"}},
    {"microhttpd.h", {"report/page/http_server.cpp"}},
    {"mosquitto.h", {"report/channels/mqtt_channel.cpp"}},
    {"nlohmann/",
     {"calib/colour/", "gles/model/", "pipeline/", "report/channels/mqtt_messages.cpp", "report/status/", "fixtures/"}},
    {"opencv2/", {"calib/board/",          "calib/lens/import_lens.cpp",   "calib/mask/",
                  "calib/pose/",           "calib/read_camera.cpp",        "estimator/cloud_cover/",
                  "estimator/haze/",       "estimator/horizon/",           "estimator/photograph/",
                  "estimator/sky_camera/", "estimator/turbidity/",         "pipeline/bench/haze.cpp",
                  "pipeline/calibrate/",   "pipeline/calibration_report/", "pipeline/comparison/",
                  "pipeline/files/",       "pipeline/photographs/",        "base/picture_files/",
                  "pipeline/sky/",         "pipeline/snapshot/",           "fixtures/"}},
    {"opencv2/aruco", {"calib/board/charuco.cpp"}},
    {"opencv2/calib3d", {"calib/board/board.cpp"}},
    {"png.h", {"base/picture_files/"}},
    {"sodium", {"pipeline/content/"}},
    {"spdlog/", {"pipeline/"}},
    {"systemd/", {"pipeline/machine/timedated.cpp", "report/main.cpp"}},
    {"tiny_gltf.h", {"gles/model/"}},
    {"toml++/", {"base/table/"}},
    {"xf86drm", {"gles/display/kms_drm"}},
};

}  // namespace kasumi::house

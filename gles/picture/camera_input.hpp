// How the camera's pictures come to the GPU: copied plane by plane, or read from the driver's own buffers.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/picture.hpp"
#include "base/result.hpp"
#include "gles/picture/camera_import.hpp"
#include "gles/picture/camera_planes.hpp"
#include "gles/scene.hpp"

namespace kasumi {

class CameraInput {
 public:
  CameraInput(const GlInfo& info, const RendererOptions& options) : info_(info), options_(options) {}

  // See Renderer. A refusal to import is told in `notes`, once for each kind of picture.
  Result<> upload(const PictureView& frame);
  Result<> import_frame(const ExternalPicture& frame, std::vector<std::string>& notes);

  const CameraTextures& newest() const { return newest_; }  // whichever way it came
  FrameCounts frames() const { return frames_; }

 private:
  Result<std::unique_ptr<ImageDevice>> open_image_device() const;

  const GlInfo& info_;
  const RendererOptions& options_;
  CameraPlanes planes_;
  std::optional<CameraImport> import_;
  std::optional<Fault> no_import_;                 // this driver's refusal of any
  std::optional<ExternalPicture> import_refused_;  // the kind of picture refused last
  CameraTextures newest_;
  FrameCounts frames_;
};

}  // namespace kasumi

// Brings the camera's pictures to the GPU: copied plane by plane, or imported from the driver's buffers.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/picture.hpp"
#include "base/result.hpp"
#include "gles/picture/plane_import.hpp"
#include "gles/picture/plane_upload.hpp"
#include "gles/scene.hpp"

namespace kasumi {

class CameraInput {
 public:
  CameraInput(const GlInfo& info, const RendererOptions& options) : info_(info), options_(options) {}

  // See Renderer. A refusal to import is reported in `notes`, once for each kind of picture.
  Result<> upload(const PictureView& frame);
  Result<> import_frame(const ExternalPicture& frame, std::vector<std::string>& notes);

  // The picture is in memory, where the processor mixes it: only its kind is taken. Counts as uploaded.
  void keep(const PictureView& frame);
  // Uploads it after all.
  Result<> upload_kept(const PictureView& frame);
  bool on_gpu() const { return on_gpu_; }

  // Gives the camera's buffers back. A picture read in one of them is gone: upload it before.
  void drop_buffers();

  const CameraTextures& newest() const { return newest_; }  // uploaded or imported
  FrameCounts frames() const { return frames_; }

 private:
  Result<std::unique_ptr<ImageDevice>> open_image_device() const;

  const GlInfo& info_;
  const RendererOptions& options_;
  PlaneUpload planes_;
  std::optional<PlaneImport> import_;
  std::optional<Fault> no_import_;                 // set if this driver cannot import at all
  std::optional<ExternalPicture> import_refused_;  // the last kind of picture refused
  CameraTextures newest_;
  bool on_gpu_ = false;  // the newest
  FrameCounts frames_;
};

}  // namespace kasumi

// The camera's buffers as the card scans them out; each is imported once.
#pragma once

#include <map>
#include <memory>

#include "base/result.hpp"
#include "gles/display/kms_device.hpp"
#include "gles/picture/external_picture.hpp"

namespace kasumi {

class KmsCameraBuffers {
 public:
  explicit KmsCameraBuffers(KmsDevice& device) : device_(device) {}
  // To be kept while the display reads it. Error: unsupported, with the driver's reason.
  Result<std::shared_ptr<const KmsFramebuffer>> import(const ExternalPicture& picture);
  void drop() { imported_.clear(); }

 private:
  struct Imported {
    ExternalPicture picture;
    std::shared_ptr<const KmsFramebuffer> framebuffer;
    std::uint64_t used = 0;
  };
  KmsDevice& device_;
  std::map<std::uint64_t, Imported> imported_;
  std::uint64_t imports_ = 0;
};

}  // namespace kasumi

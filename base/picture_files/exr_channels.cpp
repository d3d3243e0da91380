#include "base/picture_files/exr_channels.hpp"

#include <algorithm>
#include <cstring>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>

#include "base/picture_header.hpp"

namespace kasumi {

namespace {

class BytesStream final : public Imf::IStream {
 public:
  explicit BytesStream(std::span<const std::uint8_t> file) : Imf::IStream("EXR"), file_(file) {}
  bool read(char to[], int count) override {
    const auto wanted = static_cast<std::size_t>(count);
    if (count < 0 || at_ > file_.size() || file_.size() - at_ < wanted) throw std::runtime_error("it ends too early");
    std::memcpy(to, file_.data() + at_, wanted);
    at_ += wanted;
    return at_ < file_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t at) override { at_ = static_cast<std::size_t>(at); }

 private:
  std::span<const std::uint8_t> file_;
  std::size_t at_ = 0;
};

// The parts' channels, until one of them is wanted.
template <class Wanted>
void each_channel(Imf::MultiPartInputFile& file, Wanted wanted) {
  for (int part = 0; part < file.parts(); ++part) {
    const auto& header = file.header(part);
    if (header.hasType() && Imf::isDeepData(header.type())) continue;
    for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel)
      if (channel.channel().xSampling == 1 && channel.channel().ySampling == 1 && wanted(part, channel.name())) return;
  }
}

}  // namespace

std::vector<std::string> names_of_exr_channels(std::span<const std::uint8_t> bytes) try {
  BytesStream stream(bytes);
  Imf::MultiPartInputFile file(stream, 0);
  std::vector<std::string> names;
  each_channel(file, [&](int, const char* name) {
    if (std::ranges::find(names, name) == names.end()) names.emplace_back(name);
    return false;
  });
  return names;
} catch (const std::exception&) {
  return {};
}

cv::Mat read_exr_channel(std::span<const std::uint8_t> bytes, const std::string& wanted) try {
  BytesStream stream(bytes);
  Imf::MultiPartInputFile file(stream, 0);
  int found = -1;
  each_channel(file, [&](int part, const char* name) {
    if (name == wanted) found = part;
    return found >= 0;
  });
  if (found < 0) return {};
  Imf::InputPart part(file, found);
  const auto window = part.header().dataWindow();
  const auto width = std::int64_t{window.max.x} - window.min.x + 1,
             height = std::int64_t{window.max.y} - window.min.y + 1;
  const auto& most = kPhotographLimits;
  if (width < 1 || height < 1 || width > most.side_px || height > most.side_px || width * height > most.pixels)
    return {};
  cv::Mat channel = cv::Mat::zeros(static_cast<int>(height), static_cast<int>(width), CV_32F);
  const auto row = static_cast<std::ptrdiff_t>(channel.step);
  Imf::FrameBuffer target;
  // OpenEXR counts from the origin of the display, not of the data.
  auto* origin =
      reinterpret_cast<char*>(channel.data) - window.min.x * std::ptrdiff_t{sizeof(float)} - window.min.y * row;
  target.insert(wanted, Imf::Slice(Imf::FLOAT, origin, sizeof(float), channel.step));
  part.setFrameBuffer(target);
  part.readPixels(window.min.y, window.max.y);
  return channel;
} catch (const std::exception&) {
  return {};
}

}  // namespace kasumi

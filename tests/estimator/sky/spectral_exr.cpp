#include "tests/estimator/sky/spectral_exr.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <vector>

#include <zlib.h>

#include "base/files.hpp"

namespace kasumi::test {
namespace {

constexpr int kZip = 3, kRowsOfAZip = 16;
constexpr std::int32_t kFloat32 = 2;

class Bytes {
 public:
  explicit Bytes(std::vector<std::uint8_t> bytes) : bytes_(std::move(bytes)) {}
  void go(std::size_t at) { at_ = at; }
  template <class Number>
  Number number() {
    Number value;
    std::memcpy(&value, take(sizeof value), sizeof value);
    return value;
  }
  std::string text() {
    std::string text;
    for (char c; (c = number<char>()) != '\0';) text += c;
    return text;
  }
  const std::uint8_t* take(std::size_t count) {
    if (at_ + count > bytes_.size()) throw std::runtime_error("the picture ends too early");
    at_ += count;
    return bytes_.data() + (at_ - count);
  }
  std::size_t at() const { return at_; }

 private:
  std::vector<std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

struct Layout {
  std::vector<std::string> channels;
  int width = 0, height = 0, compression = 0;
};

Layout read_layout(Bytes& file) {
  Layout layout;
  file.go(8);  // magic, version
  for (std::string name; !(name = file.text()).empty();) {
    file.text();  // type
    const auto size = file.number<std::int32_t>();
    const std::size_t end = file.at() + static_cast<std::size_t>(size);
    if (name == "channels") {
      for (std::string channel; !(channel = file.text()).empty();) {
        if (file.number<std::int32_t>() != kFloat32) throw std::runtime_error(channel + " is not of 32-bit numbers");
        file.take(12);
        layout.channels.push_back(channel);
      }
    } else if (name == "dataWindow") {
      const auto left = file.number<std::int32_t>(), top = file.number<std::int32_t>();
      layout.width = file.number<std::int32_t>() - left + 1;
      layout.height = file.number<std::int32_t>() - top + 1;
    } else if (name == "compression") {
      layout.compression = file.number<std::uint8_t>();
    }
    file.go(end);
  }
  if (layout.compression != kZip) throw std::runtime_error("expected rows compressed by zip");
  return layout;
}

// Undoes zip, then the differences between bytes, then the splitting into even and odd ones.
std::vector<std::uint8_t> unzipped(const std::uint8_t* packed, std::size_t packed_size, std::size_t size) {
  if (packed_size >= size) return {packed, packed + size};
  std::vector<std::uint8_t> split(size), bytes(size);
  uLongf length = size;
  if (uncompress(split.data(), &length, packed, packed_size) != Z_OK || length != size)
    throw std::runtime_error("the rows cannot be unpacked");
  for (std::size_t i = 1; i < size; ++i) split[i] = static_cast<std::uint8_t>(split[i - 1] + split[i] - 128);
  const std::size_t odd = (size + 1) / 2;
  for (std::size_t i = 0; i < size; ++i) bytes[i] = split[i / 2 + (i % 2) * odd];
  return bytes;
}

}  // namespace

std::map<std::string, Image<float>> read_exr(const std::filesystem::path& path) {
  auto read = read_file(path);
  if (!read) throw std::runtime_error(read.error().message);
  Bytes file(std::move(*read));
  const Layout layout = read_layout(file);
  std::map<std::string, Image<float>> picture;
  for (const auto& channel : layout.channels) picture[channel] = Image<float>(layout.width, layout.height, 0.0f);
  std::vector<std::uint64_t> blocks;
  for (int y = 0; y < layout.height; y += kRowsOfAZip) blocks.push_back(file.number<std::uint64_t>());
  for (const auto block : blocks) {
    file.go(block);
    const auto top = file.number<std::int32_t>();
    const auto packed = static_cast<std::size_t>(file.number<std::int32_t>());
    const int rows = std::min(kRowsOfAZip, layout.height - top);
    const std::size_t row_bytes = static_cast<std::size_t>(layout.width) * sizeof(float);
    const auto bytes =
        unzipped(file.take(packed), packed, row_bytes * layout.channels.size() * static_cast<std::size_t>(rows));
    const std::uint8_t* from = bytes.data();
    for (int y = top; y < top + rows; ++y)
      for (const auto& channel : layout.channels) {
        std::memcpy(&picture[channel].at(0, y), from, row_bytes);
        from += row_bytes;
      }
  }
  return picture;
}

}  // namespace kasumi::test

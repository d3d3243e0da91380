#include "estimator/sky/tensor_file.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string_view>

#include <fmt/ranges.h>

#include "base/files.hpp"

namespace kasumi {
namespace {

static_assert(std::endian::native == std::endian::little);  // as the file is

// Mitsuba's tensor file, version 1: magic, versions, fields with names, types and shapes (docs/sky.md).
constexpr std::string_view kMagic{"tensor_file\0", 12};
constexpr std::uint8_t kMajorVersion = 1;
constexpr unsigned kFloat64 = 11;
// Far above any real file: bounds what a broken one can ask for.
constexpr std::size_t kMostFields = 1000, kMostDimensions = 16;

}  // namespace

// Reads on from byte to byte; ok() turns false where the file ends too early.
class TensorFile::Header {
 public:
  explicit Header(const std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

  bool ok() const { return ok_; }
  std::size_t at() const { return at_; }

  template <class Number>
  Number number() {
    Number value{};
    if (const auto* from = take(sizeof value)) std::memcpy(&value, from, sizeof value);
    return value;
  }
  std::string text(std::size_t length) {
    const auto* from = take(length);
    return from ? std::string(reinterpret_cast<const char*>(from), length) : std::string();
  }

 private:
  const std::uint8_t* take(std::size_t count) {
    if (!ok_ || count > bytes_.size() - at_) {
      ok_ = false;
      return nullptr;
    }
    at_ += count;
    return bytes_.data() + (at_ - count);
  }

  const std::vector<std::uint8_t>& bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

Result<TensorFile> TensorFile::read(const std::filesystem::path& file) {
  auto bytes = read_file(file);
  if (!bytes) return fail(bytes.error());
  TensorFile tensors;
  tensors.file_ = file;
  tensors.bytes_ = std::move(*bytes);

  Header header(tensors.bytes_);
  if (header.text(kMagic.size()) != kMagic)
    return fail(FaultKind::bad_input, "{}: expected a file of tensors, which begins with 'tensor_file'", file.string());
  const auto major = header.number<std::uint8_t>();
  header.number<std::uint8_t>();  // minor versions are read alike
  const auto count = header.number<std::uint32_t>();
  if (header.ok() && major != kMajorVersion)
    return fail(FaultKind::bad_input, "{}: version {} of a file of tensors: expected {}", file.string(), major,
                kMajorVersion);
  if (header.ok() && count > kMostFields)
    return fail(FaultKind::bad_input, "{}: {} tensors: expected at most {}", file.string(), count, kMostFields);
  for (std::uint32_t i = 0; i < count && header.ok(); ++i) {
    Field field;
    field.name = header.text(header.number<std::uint16_t>());
    const auto dimensions = header.number<std::uint16_t>();
    field.type = header.number<std::uint8_t>();
    field.offset = header.number<std::uint64_t>();
    if (dimensions > kMostDimensions)
      return fail(FaultKind::bad_input, "{}: tensor '{}' has {} dimensions: expected at most {}", file.string(),
                  field.name, dimensions, kMostDimensions);
    for (int k = 0; k < dimensions; ++k) field.shape.push_back(header.number<std::uint64_t>());
    tensors.fields_.push_back(std::move(field));
  }
  if (!header.ok())
    return fail(FaultKind::bad_input, "{}: ends after {} bytes, within the list of its {} tensors", file.string(),
                tensors.bytes_.size(), count);
  return tensors;
}

Result<std::vector<double>> TensorFile::doubles(const std::string& name, const std::vector<std::size_t>& shape) const {
  const auto field = std::find_if(fields_.begin(), fields_.end(), [&](const Field& f) { return f.name == name; });
  if (field == fields_.end()) return fail(FaultKind::bad_input, "{}: has no tensor '{}'", file_.string(), name);
  if (field->type != kFloat64)
    return fail(FaultKind::bad_input, "{}: tensor '{}' is of type {}: expected {}, numbers of 64 bits", file_.string(),
                name, field->type, kFloat64);
  if (field->shape != shape)
    return fail(FaultKind::bad_input, "{}: tensor '{}' is {}: expected {}", file_.string(), name,
                fmt::join(field->shape, " x "), fmt::join(shape, " x "));
  std::size_t count = 1;
  for (const auto extent : shape) count *= extent;
  if (field->offset > bytes_.size() || count * sizeof(double) > bytes_.size() - field->offset)
    return fail(FaultKind::bad_input, "{}: tensor '{}' begins at byte {} and has {}: the file ends at {}",
                file_.string(), name, field->offset, count * sizeof(double), bytes_.size());
  std::vector<double> values(count);
  std::memcpy(values.data(), bytes_.data() + field->offset, count * sizeof(double));
  const auto odd = std::find_if_not(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  if (odd != values.end())
    return fail(FaultKind::bad_input, "{}: tensor '{}': number {} is {}: expected a finite one", file_.string(), name,
                odd - values.begin() + 1, *odd);
  return values;
}

}  // namespace kasumi

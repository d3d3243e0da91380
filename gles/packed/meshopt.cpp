#include <meshoptimizer.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "gles/packed/meshopt_vertices.hpp"
#include "gles/packed/module.hpp"

namespace kasumi {

namespace {

template <class T>
int clamped_round(double value) {
  return static_cast<int>(
      std::lround(std::clamp(value, double(std::numeric_limits<T>::lowest()), double(std::numeric_limits<T>::max()))));
}

// YCoCg with the alpha's highest bit as the colours' scale, to RGBA (KHR_meshopt_compression, filter COLOR); the library
// of this age does not know it.
template <class Whole, class Signed>
void decode_colours(std::span<std::uint8_t> bytes) {
  constexpr std::size_t kSize = 4 * sizeof(Whole);
  for (std::size_t at = 0; at + kSize <= bytes.size(); at += kSize) {
    Whole texel[4];
    std::memcpy(texel, bytes.data() + at, kSize);
    const int y = texel[0], co = static_cast<Signed>(texel[1]), cg = static_cast<Signed>(texel[2]);
    const unsigned kept = texel[3];
    const unsigned scale = (1u << std::bit_width(kept)) - 1u;
    const unsigned alpha = kept & (scale >> 1);
    const double full = scale == 0 ? 0.0 : double(std::numeric_limits<Whole>::max()) / scale;
    const double out[4]{double(y + co - cg), double(y + cg), double(y - co - cg), double(alpha << 1 | (alpha & 1u))};
    for (int c = 0; c < 4; ++c) texel[c] = static_cast<Whole>(clamped_round<Whole>(out[c] * full));
    std::memcpy(bytes.data() + at, texel, kSize);
  }
}

Result<> unfilter(std::vector<std::uint8_t>& bytes, const MeshoptBuffer& view) {
  const auto strides = [&](std::initializer_list<std::size_t> allowed) {
    return std::ranges::find(allowed, view.stride) != allowed.end();
  };
  if (view.filter.empty() || view.filter == "NONE") return {};
  if (view.filter == "OCTAHEDRAL" && strides({4, 8})) {
    meshopt_decodeFilterOct(bytes.data(), view.count, view.stride);
  } else if (view.filter == "QUATERNION" && strides({8})) {
    meshopt_decodeFilterQuat(bytes.data(), view.count, view.stride);
  } else if (view.filter == "EXPONENTIAL" && view.stride % 4 == 0) {
    meshopt_decodeFilterExp(bytes.data(), view.count, view.stride);
  } else if (view.filter == "COLOR" && strides({4, 8})) {
    if (view.stride == 4)
      decode_colours<std::uint8_t, std::int8_t>(bytes);
    else
      decode_colours<std::uint16_t, std::int16_t>(bytes);
  } else {
    return fail(FaultKind::bad_input, "meshopt filter \"{}\" for elements of {} bytes", view.filter, view.stride);
  }
  return {};
}

}  // namespace

Result<std::vector<std::uint8_t>> read_meshopt(std::span<const std::uint8_t> stream, const MeshoptBuffer& view,
                                               std::size_t most) {
  const bool attributes = view.mode == "ATTRIBUTES", triangles = view.mode == "TRIANGLES";
  if (!attributes && !triangles && view.mode != "INDICES")
    return fail(FaultKind::bad_input, "meshopt mode \"{}\": expected ATTRIBUTES, TRIANGLES or INDICES", view.mode);
  const bool stride_fits = attributes ? view.stride >= 4 && view.stride <= 256 && view.stride % 4 == 0
                                      : view.stride == 2 || view.stride == 4;
  if (!stride_fits || (triangles && view.count % 3 != 0))
    return fail(FaultKind::bad_input, "meshopt {} of {} elements of {} bytes", view.mode, view.count, view.stride);
  if (view.count > most / view.stride)
    return fail(FaultKind::bad_input, "{} elements of {} bytes: expected {} bytes at most", view.count, view.stride,
                most);
  if (view.count * view.stride / kMostForAByte > stream.size())
    return fail(FaultKind::bad_input, "{} bytes of meshopt claim {} elements of {} bytes", stream.size(), view.count,
                view.stride);
  std::vector<std::uint8_t> bytes(view.count * view.stride);
  if (bytes.empty()) return bytes;
  bool whole = false;
  if (attributes && !stream.empty() && stream[0] == 0xa1)
    whole = decode_vertices_1(stream, view.count, view.stride, bytes);
  else if (attributes)
    whole = meshopt_decodeVertexBuffer(bytes.data(), view.count, view.stride, stream.data(), stream.size()) == 0;
  else if (triangles)
    whole = meshopt_decodeIndexBuffer(bytes.data(), view.count, view.stride, stream.data(), stream.size()) == 0;
  else
    whole = meshopt_decodeIndexSequence(bytes.data(), view.count, view.stride, stream.data(), stream.size()) == 0;
  if (!whole) return fail(FaultKind::bad_input, "damaged meshopt stream ({})", view.mode);
  if (auto done = unfilter(bytes, view); !done) return fail(done.error());
  return bytes;
}

}  // namespace kasumi

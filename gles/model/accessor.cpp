#include "gles/model/accessor.hpp"

#include <algorithm>
#include <cstring>

namespace kasumi {
namespace {

// Elements of one component type in a buffer view.
struct Elements {
  const std::uint8_t* data = nullptr;
  std::size_t count = 0;
  std::size_t stride = 0;
  int components = 0;
  int component_type = 0;
};

std::size_t component_bytes(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT: return 4;
    default: return 0;
  }
}

int component_count(int type) {
  switch (type) {
    case TINYGLTF_TYPE_SCALAR: return 1;
    case TINYGLTF_TYPE_VEC2: return 2;
    case TINYGLTF_TYPE_VEC3: return 3;
    case TINYGLTF_TYPE_VEC4: return 4;
    case TINYGLTF_TYPE_MAT4: return 16;  // of floats: no gaps between columns
    default: return 0;
  }
}

Result<Elements> elements_in(const tinygltf::Model& gltf, int view_index, std::size_t offset, std::size_t count,
                             int components, int component_type, bool strided, const std::string& what) {
  if (view_index < 0 || static_cast<std::size_t>(view_index) >= gltf.bufferViews.size())
    return fail(FaultKind::bad_input, "{}: buffer view {}: there are {}", what, view_index, gltf.bufferViews.size());
  const tinygltf::BufferView& view = gltf.bufferViews[static_cast<std::size_t>(view_index)];
  if (view.buffer < 0 || static_cast<std::size_t>(view.buffer) >= gltf.buffers.size())
    return fail(FaultKind::bad_input, "{}: buffer {}: there are {}", what, view.buffer, gltf.buffers.size());
  const auto& bytes = gltf.buffers[static_cast<std::size_t>(view.buffer)].data;
  if (view.byteOffset > bytes.size() || view.byteLength > bytes.size() - view.byteOffset)
    return fail(FaultKind::bad_input, "{}: buffer view {} covers bytes {} + {}: buffer {} has {}", what, view_index,
                view.byteOffset, view.byteLength, view.buffer, bytes.size());
  const std::size_t size = component_bytes(component_type) * static_cast<std::size_t>(components);
  if (size == 0) return fail(FaultKind::bad_input, "{}: component type {} is not allowed here", what, component_type);
  const std::size_t stride = strided && view.byteStride != 0 ? view.byteStride : size;
  if (stride < size)
    return fail(FaultKind::bad_input, "{}: a stride of {} for elements of {} bytes", what, stride, size);
  if (count > 0 && (offset > view.byteLength || size > view.byteLength - offset ||
                    (count - 1) > (view.byteLength - offset - size) / stride))
    return fail(FaultKind::bad_input,
                "{}: {} elements of {} bytes, {} apart, from byte {}: buffer view {} has {} bytes", what, count, size,
                stride, offset, view_index, view.byteLength);
  return Elements{bytes.data() + view.byteOffset + offset, count, stride, components, component_type};
}

template <class T>
T load(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

float as_float(const std::uint8_t* bytes, int type, bool normalized) {
  const auto scaled = [normalized](float value, float full) {
    return normalized ? std::max(value / full, -1.0f) : value;
  };
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: return scaled(load<std::int8_t>(bytes), 127.0f);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return scaled(*bytes, 255.0f);
    case TINYGLTF_COMPONENT_TYPE_SHORT: return scaled(load<std::int16_t>(bytes), 32767.0f);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return scaled(load<std::uint16_t>(bytes), 65535.0f);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return static_cast<float>(load<std::uint32_t>(bytes));
    default: return load<float>(bytes);
  }
}

Result<std::vector<std::uint32_t>> whole_numbers(const Elements& elements, const std::string& what) {
  if (elements.component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
      elements.component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
      elements.component_type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
    return fail(FaultKind::bad_input, "{}: indices of component type {}: expected unsigned integers", what,
                elements.component_type);
  std::vector<std::uint32_t> values(elements.count);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::uint8_t* at = elements.data + i * elements.stride;
    switch (component_bytes(elements.component_type)) {
      case 1: values[i] = *at; break;
      case 2: values[i] = load<std::uint16_t>(at); break;
      default: values[i] = load<std::uint32_t>(at); break;
    }
  }
  return values;
}

// Which elements a sparse accessor replaces, and by what.
struct SparseEntries {
  std::vector<std::uint32_t> places;
  Elements values;
};

Result<SparseEntries> sparse_entries(const tinygltf::Model& gltf, const tinygltf::Accessor& accessor, int components,
                                     const std::string& what) {
  const auto& sparse = accessor.sparse;
  if (sparse.count < 0 || static_cast<std::size_t>(sparse.count) > accessor.count || sparse.indices.byteOffset < 0 ||
      sparse.values.byteOffset < 0)
    return fail(FaultKind::bad_input, "{}: {} sparse entries for {} elements, or a negative offset", what, sparse.count,
                accessor.count);
  const auto count = static_cast<std::size_t>(sparse.count);
  const auto index_elements =
      elements_in(gltf, sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset), count, 1,
                  sparse.indices.componentType, false, what + ", sparse indices");
  if (!index_elements) return fail(index_elements.error());
  auto places = whole_numbers(*index_elements, what + ", sparse indices");
  if (!places) return fail(places.error());
  for (const std::uint32_t place : *places)
    if (place >= accessor.count)
      return fail(FaultKind::bad_input, "{}: sparse entry for element {}: there are {}", what, place, accessor.count);
  const auto values = elements_in(gltf, sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset),
                                  count, components, accessor.componentType, false, what + ", sparse values");
  if (!values) return fail(values.error());
  return SparseEntries{std::move(*places), *values};
}

}  // namespace

Result<const tinygltf::Accessor*> Accessors::find(int index, std::size_t limit, const std::string& what) {
  if (index < 0 || static_cast<std::size_t>(index) >= gltf_.accessors.size())
    return fail(FaultKind::bad_input, "{}: accessor {}: there are {}", what, index, gltf_.accessors.size());
  const tinygltf::Accessor& accessor = gltf_.accessors[static_cast<std::size_t>(index)];
  if (accessor.count > limit)
    return fail(FaultKind::bad_input, "{}: {} elements: expected {} at most", what, accessor.count, limit);
  const std::size_t numbers = accessor.count * static_cast<std::size_t>(component_count(accessor.type));
  if (numbers > left_)
    return fail(FaultKind::bad_input, "{}: with it more than {} million numbers are read: the same ones too often",
                what, most_ / 1'000'000);
  left_ -= numbers;
  return &accessor;
}

Result<AccessorFloats> Accessors::floats(int index, std::initializer_list<int> components, std::size_t limit,
                                         const std::string& what) {
  const std::string named = fmt::format("{} (accessor {})", what, index);
  const auto found = find(index, limit, named);
  if (!found) return fail(found.error());
  const tinygltf::Accessor& accessor = **found;
  AccessorFloats floats;
  floats.components = component_count(accessor.type);
  floats.count = accessor.count;
  if (std::ranges::find(components, floats.components) == components.end())
    return fail(FaultKind::bad_input, "{}: elements of {} components", named, floats.components);
  const std::size_t bytes = component_bytes(accessor.componentType);
  if (bytes == 0) return fail(FaultKind::bad_input, "{}: component type {}", named, accessor.componentType);

  const auto width = static_cast<std::size_t>(floats.components);
  floats.values.resize(floats.count * width);  // zeros where there is no buffer view
  if (accessor.bufferView >= 0) {
    const auto elements = elements_in(gltf_, accessor.bufferView, accessor.byteOffset, accessor.count,
                                      floats.components, accessor.componentType, true, named);
    if (!elements) return fail(elements.error());
    for (std::size_t i = 0; i < floats.count; ++i)
      for (std::size_t c = 0; c < width; ++c)
        floats.values[i * width + c] =
            as_float(elements->data + i * elements->stride + c * bytes, accessor.componentType, accessor.normalized);
  }
  if (!accessor.sparse.isSparse) return floats;
  const auto sparse = sparse_entries(gltf_, accessor, floats.components, named);
  if (!sparse) return fail(sparse.error());
  for (std::size_t i = 0; i < sparse->places.size(); ++i)
    for (std::size_t c = 0; c < width; ++c)
      floats.values[sparse->places[i] * width + c] = as_float(
          sparse->values.data + i * sparse->values.stride + c * bytes, accessor.componentType, accessor.normalized);
  return floats;
}

Result<std::vector<std::uint32_t>> Accessors::indices(int index, std::size_t limit, const std::string& what) {
  const std::string named = fmt::format("{} (accessor {})", what, index);
  const auto found = find(index, limit, named);
  if (!found) return fail(found.error());
  const tinygltf::Accessor& accessor = **found;
  if (component_count(accessor.type) != 1) return fail(FaultKind::bad_input, "{}: indices must be scalars", named);
  const auto elements = elements_in(gltf_, accessor.bufferView, accessor.byteOffset, accessor.count, 1,
                                    accessor.componentType, true, named);
  if (!elements) return fail(elements.error());
  auto indices = whole_numbers(*elements, named);
  if (!indices || !accessor.sparse.isSparse) return indices;
  const auto sparse = sparse_entries(gltf_, accessor, 1, named);
  if (!sparse) return fail(sparse.error());
  const auto values = whole_numbers(sparse->values, named + ", sparse values");
  if (!values) return fail(values.error());
  for (std::size_t i = 0; i < values->size(); ++i) (*indices)[sparse->places[i]] = (*values)[i];
  return indices;
}

}  // namespace kasumi

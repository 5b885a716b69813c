#include "worker/engine/scene/gltf_accessor.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>

#include "common/base/check.h"
#include "common/base/status_macros.h"
#include "common/base/work_limit.h"

namespace shutterline::engine {
namespace {

/// Elements that are read between two looks at the work's limit.
constexpr size_t kElementsPerCheck = 1 << 16;

int ComponentBytes(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    default:
      return 4;
  }
}

/// Bytes from an element's first to its last, with the padding that aligns the columns of small matrices.
uint64_t ElementBytes(const tinygltf::Accessor& accessor) {
  const uint64_t component = uint64_t(ComponentBytes(accessor.componentType));
  const auto columns = [&](uint64_t n) { return n * ((n * component + 3) / 4 * 4); };
  if (accessor.type == TINYGLTF_TYPE_MAT2) return columns(2);
  if (accessor.type == TINYGLTF_TYPE_MAT3) return columns(3);
  return component * uint64_t(GltfComponents(accessor));
}

/// Whether `count` elements fit into a view. Counts and offsets are at most 2^53 and strides at most 252,
/// so that nothing here overflows 64 bits.
absl::Status CheckFit(const GltfDocument& document, int view_index, uint64_t offset, uint64_t count,
                      uint64_t element, uint64_t stride) {
  const uint64_t length = document.model.bufferViews[size_t(view_index)].byteLength;
  if (count == 0) return absl::OkStatus();
  if (offset + (count - 1) * stride + element > length) {
    return absl::InvalidArgumentError(absl::StrCat("byteOffset ", offset, " + ", count, " × ", stride,
                                                   " exceeds bufferView ", view_index, " (length ", length,
                                                   ")"));
  }
  return absl::OkStatus();
}

absl::Status CheckView(const GltfDocument& document, const tinygltf::BufferView& view) {
  const uint64_t length = document.buffers[size_t(view.buffer)].size();
  if (uint64_t{view.byteOffset} + view.byteLength > length) {
    return absl::InvalidArgumentError(absl::StrCat("byteOffset ", view.byteOffset, " + byteLength ",
                                                   view.byteLength, " exceeds buffer ", view.buffer,
                                                   " (length ", length, ")"));
  }
  if (view.byteStride != 0 && (view.byteStride < 4 || view.byteStride > 252 || view.byteStride % 4 != 0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("byteStride ", view.byteStride, " is not a multiple of 4 from 4 to 252"));
  }
  return absl::OkStatus();
}

absl::Status CheckSparse(const GltfDocument& document, const tinygltf::Accessor& accessor) {
  const auto& sparse = accessor.sparse;
  if (sparse.count < 1 || uint64_t(sparse.count) > accessor.count) {
    return absl::InvalidArgumentError(absl::StrCat(
        "sparse.count ", sparse.count, " is not from 1 to the accessor's count ", accessor.count));
  }
  for (const int view : {sparse.indices.bufferView, sparse.values.bufferView}) {
    if (document.model.bufferViews[size_t(view)].byteStride != 0) {
      return absl::InvalidArgumentError(absl::StrCat("sparse: bufferView ", view, " has a byteStride"));
    }
  }
  const uint64_t index_bytes = uint64_t(ComponentBytes(sparse.indices.componentType));
  const uint64_t value_bytes = ElementBytes(accessor);
  SL_RETURN_IF_ERROR(
      Annotate(CheckFit(document, sparse.indices.bufferView, uint64_t(sparse.indices.byteOffset),
                        uint64_t(sparse.count), index_bytes, index_bytes),
               "sparse.indices"));
  return Annotate(CheckFit(document, sparse.values.bufferView, uint64_t(sparse.values.byteOffset),
                           uint64_t(sparse.count), value_bytes, value_bytes),
                  "sparse.values");
}

absl::Status CheckAccessor(const GltfDocument& document, const tinygltf::Accessor& accessor) {
  if (accessor.bufferView >= 0) {
    const tinygltf::BufferView& view = document.model.bufferViews[size_t(accessor.bufferView)];
    const uint64_t element = ElementBytes(accessor);
    if (view.byteStride != 0 && view.byteStride < element) {
      return absl::InvalidArgumentError(absl::StrCat("its elements of ", element,
                                                     " bytes exceed the byteStride ", view.byteStride,
                                                     " of bufferView ", accessor.bufferView));
    }
    SL_RETURN_IF_ERROR(CheckFit(document, accessor.bufferView, accessor.byteOffset, accessor.count, element,
                                view.byteStride != 0 ? view.byteStride : element));
  }
  return accessor.sparse.isSparse ? CheckSparse(document, accessor) : absl::OkStatus();
}

/// A component as the reader wants it.
template <typename Stored, typename Out>
Out Convert(Stored value, bool normalized) {
  if constexpr (std::is_same_v<Out, float> && std::is_integral_v<Stored>) {
    if (!normalized) return float(value);
    // The glTF rule: c / max, and -max - 1 becomes -1 as well.
    return std::max(float(double(value) / double(std::numeric_limits<Stored>::max())), -1.0f);
  } else {
    return Out(value);
  }
}

/// Files are not bound to keep their data aligned, hence memcpy.
template <typename Stored, typename Out>
void CopyElement(const char* from, int components, bool normalized, Out* to) {
  for (int c = 0; c < components; ++c) {
    Stored value;
    std::memcpy(&value, from + size_t(c) * sizeof(Stored), sizeof(Stored));
    to[c] = Convert<Stored, Out>(value, normalized);
  }
}

template <typename Out>
void CopyElement(const tinygltf::Accessor& accessor, int components, const char* from, Out* to) {
  switch (accessor.componentType) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return CopyElement<uint8_t>(from, components, accessor.normalized, to);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return CopyElement<uint16_t>(from, components, accessor.normalized, to);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return CopyElement<uint32_t>(from, components, accessor.normalized, to);
    default:
      break;
  }
  if constexpr (std::is_same_v<Out, float>) {
    switch (accessor.componentType) {
      case TINYGLTF_COMPONENT_TYPE_BYTE:
        return CopyElement<int8_t>(from, components, accessor.normalized, to);
      case TINYGLTF_COMPONENT_TYPE_SHORT:
        return CopyElement<int16_t>(from, components, accessor.normalized, to);
      case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return CopyElement<float>(from, components, false, to);
      default:
        break;
    }
  }
  SL_CHECK(!"component type was checked");
}

uint32_t SparseIndex(const char* from, int component_type, size_t i) {
  uint32_t value = 0;
  const size_t bytes = size_t(ComponentBytes(component_type));
  // glTF is little-endian, as is every machine that we build for.
  std::memcpy(&value, from + i * bytes, bytes);
  return value;
}

template <typename Out>
absl::Status Read(const GltfDocument& document, int index, Out* out) {
  const tinygltf::Accessor& accessor = document.model.accessors[size_t(index)];
  const int components = GltfComponents(accessor);
  const size_t element = ElementBytes(accessor);
  CheckWork();
  if (accessor.bufferView < 0) {
    std::fill_n(out, accessor.count * size_t(components), Out{0});
  } else {
    const size_t view_stride = document.model.bufferViews[size_t(accessor.bufferView)].byteStride;
    const size_t stride = view_stride != 0 ? view_stride : element;
    const char* from = document.ViewBytes(accessor.bufferView).data() + accessor.byteOffset;
    for (size_t i = 0; i < accessor.count; ++i) {
      if (i % kElementsPerCheck == 0) CheckWork();
      CopyElement(accessor, components, from + i * stride, out + i * size_t(components));
    }
  }
  if (!accessor.sparse.isSparse) return absl::OkStatus();

  const auto& sparse = accessor.sparse;
  const char* indices = document.ViewBytes(sparse.indices.bufferView).data() + sparse.indices.byteOffset;
  const char* values = document.ViewBytes(sparse.values.bufferView).data() + sparse.values.byteOffset;
  uint64_t next = 0;  // The smallest index allowed: they increase strictly.
  for (size_t i = 0; i < size_t(sparse.count); ++i) {
    const uint32_t target = SparseIndex(indices, sparse.indices.componentType, i);
    if (target >= accessor.count || target < next) {
      return absl::InvalidArgumentError(
          absl::StrCat("accessor ", index, ": sparse index ", i, " (", target,
                       target >= accessor.count ? ") is not below the count " : ") does not increase; count ",
                       accessor.count));
    }
    next = uint64_t{target} + 1;
    CopyElement(accessor, components, values + i * element, out + size_t(target) * size_t(components));
  }
  return absl::OkStatus();
}

}  // namespace

int GltfComponents(const tinygltf::Accessor& accessor) {
  switch (accessor.type) {
    case TINYGLTF_TYPE_SCALAR:
      return 1;
    case TINYGLTF_TYPE_VEC2:
      return 2;
    case TINYGLTF_TYPE_VEC3:
      return 3;
    case TINYGLTF_TYPE_VEC4:
    case TINYGLTF_TYPE_MAT2:
      return 4;
    case TINYGLTF_TYPE_MAT3:
      return 9;
    default:
      return 16;
  }
}

std::string GltfAccessorElement(int accessor, absl::string_view role) {
  return absl::StrCat("accessor ", accessor, " (", role, ")");
}

absl::Status CheckGltfAccessors(const GltfDocument& document) {
  const tinygltf::Model& model = document.model;
  for (size_t i = 0; i < model.bufferViews.size(); ++i) {
    SL_RETURN_IF_ERROR(Annotate(CheckView(document, model.bufferViews[i]), absl::StrCat("bufferView ", i)));
  }
  for (size_t i = 0; i < model.accessors.size(); ++i) {
    SL_RETURN_IF_ERROR(Annotate(CheckAccessor(document, model.accessors[i]), absl::StrCat("accessor ", i)));
  }
  return absl::OkStatus();
}

absl::Status CheckGltfAccessorType(const GltfDocument& document, int index, const GltfAccessorNeed& need) {
  const tinygltf::Accessor& accessor = document.model.accessors[size_t(index)];
  const auto among = [](const std::vector<int>& all, int one) {
    return std::find(all.begin(), all.end(), one) != all.end();
  };
  if (!among(need.types, accessor.type)) {
    return absl::InvalidArgumentError(absl::StrCat(GltfAccessorElement(index, need.role), ": elements of ",
                                                   GltfComponents(accessor),
                                                   " components do not fit its use"));
  }
  if (!need.component_types.empty() && !among(need.component_types, accessor.componentType)) {
    return absl::InvalidArgumentError(absl::StrCat(GltfAccessorElement(index, need.role), ": componentType ",
                                                   accessor.componentType, " does not fit its use"));
  }
  return absl::OkStatus();
}

absl::Status ReadGltfFloats(const GltfDocument& document, int accessor, float* out) {
  return Read(document, accessor, out);
}

absl::Status ReadGltfUints(const GltfDocument& document, int accessor, uint32_t* out) {
  return Read(document, accessor, out);
}

}  // namespace shutterline::engine

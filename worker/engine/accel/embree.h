#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>

#include <utility>

// SHUTTERLINE_EMBREE_MAJOR comes with the target shutterline_embree.
#if SHUTTERLINE_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

/// Embree 3 and 4 as one: owning handles, and the few calls that differ between the two.
namespace shutterline::engine {

/// Owns one reference of an Embree object. Move-only.
template <typename Handle, void (*kRelease)(Handle)>
class EmbreeHandle {
 public:
  EmbreeHandle() = default;
  explicit EmbreeHandle(Handle handle) : handle_(handle) {}
  EmbreeHandle(EmbreeHandle&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  EmbreeHandle& operator=(EmbreeHandle&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~EmbreeHandle() {
    if (handle_ != nullptr) kRelease(handle_);
  }

  Handle get() const { return handle_; }

 private:
  Handle handle_ = nullptr;
};

using EmbreeDevice = EmbreeHandle<RTCDevice, &rtcReleaseDevice>;
using EmbreeScene = EmbreeHandle<RTCScene, &rtcReleaseScene>;
using EmbreeGeometry = EmbreeHandle<RTCGeometry, &rtcReleaseGeometry>;
using EmbreeBvh = EmbreeHandle<RTCBVH, &rtcReleaseBVH>;

/// The device's error since the last call, as a status: RESOURCE_EXHAUSTED for memory, else INTERNAL.
/// Errors are kept by thread: ask on the thread that called Embree.
inline absl::Status EmbreeStatus(RTCDevice device, absl::string_view what) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_NONE) return absl::OkStatus();
  if (error == RTC_ERROR_OUT_OF_MEMORY) {
    return absl::ResourceExhaustedError(absl::StrCat(what, ": Embree is out of memory"));
  }
  return absl::InternalError(absl::StrCat(what, ": Embree error ", int(error)));
}

/// `config` is Embree's ("threads=4"). INTERNAL where the processor is not supported.
inline absl::StatusOr<EmbreeDevice> MakeEmbreeDevice(const char* config = nullptr) {
  EmbreeDevice device(rtcNewDevice(config));
  if (device.get() == nullptr) {
    absl::Status status = EmbreeStatus(nullptr, "open Embree device");
    return status.ok() ? absl::InternalError("open Embree device: no device") : status;
  }
  return device;
}

/// Another reference of the same device: Embree allows a process about a thousand devices.
inline EmbreeDevice Share(const EmbreeDevice& device) {
  rtcRetainDevice(device.get());
  return EmbreeDevice(device.get());
}

/// What travels with a query and reaches filter functions as `args->context`: derive from it.
#if SHUTTERLINE_EMBREE_MAJOR >= 4
using EmbreeQueryContext = RTCRayQueryContext;
#else
using EmbreeQueryContext = RTCIntersectContext;
#endif

inline void InitCoherentQuery(EmbreeQueryContext& context) {
#if SHUTTERLINE_EMBREE_MAJOR >= 4
  rtcInitRayQueryContext(&context);  // Coherence is an argument of the query there.
#else
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
#endif
}

#if SHUTTERLINE_EMBREE_MAJOR >= 4
#define SHUTTERLINE_EMBREE_INTERSECT(width)                                                    \
  inline void IntersectCoherent(const int* valid, RTCScene scene, EmbreeQueryContext& context, \
                                RTCRayHit##width& rays) {                                      \
    RTCIntersectArguments arguments;                                                           \
    rtcInitIntersectArguments(&arguments);                                                     \
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;                                             \
    arguments.context = &context;                                                              \
    rtcIntersect##width(valid, scene, &rays, &arguments);                                      \
  }
#else
#define SHUTTERLINE_EMBREE_INTERSECT(width)                                                    \
  inline void IntersectCoherent(const int* valid, RTCScene scene, EmbreeQueryContext& context, \
                                RTCRayHit##width& rays) {                                      \
    rtcIntersect##width(valid, scene, &context, &rays);                                        \
  }
#endif
/// Nearest hits of a packet of rays; lanes whose `valid` is 0 are left alone, others have -1. `valid` is
/// aligned as the packet is.
SHUTTERLINE_EMBREE_INTERSECT(4)
SHUTTERLINE_EMBREE_INTERSECT(8)
SHUTTERLINE_EMBREE_INTERSECT(16)
#undef SHUTTERLINE_EMBREE_INTERSECT

/// Whether anything is met within the ray's interval; the ray may be changed.
inline bool IsOccluded(RTCScene scene, RTCRay& ray) {
#if SHUTTERLINE_EMBREE_MAJOR >= 4
  rtcOccluded1(scene, &ray, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
#endif
  return ray.tfar < 0;
}

}  // namespace shutterline::engine

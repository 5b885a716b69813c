#include "common/job/output_channels.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

namespace shutterline {
namespace {

std::vector<OutputChannel> ChannelsOf(Aov aov) {
  switch (aov) {
    case Aov::kDepth:
      return {{"Z", true}, {"depth.mean", true}};
    case Aov::kPosition:
      return {{"P.X", true}, {"P.Y", true}, {"P.Z", true}};
    case Aov::kNormal:
      return {{"N.X"}, {"N.Y"}, {"N.Z"}};
    case Aov::kMotion:
      return {{"motion.X", true}, {"motion.Y", true}};
    case Aov::kAlbedo:
      return {{"albedo.R"}, {"albedo.G"}, {"albedo.B"}};
    case Aov::kAmbientOcclusion:
      return {{"ao"}};
    case Aov::kSamples:
      return {{"samples.pairs", true}, {"samples.instants", true}};
    case Aov::kObjectId:
      return {{"object-id", true}};
    case Aov::kMaterialId:
      return {{"material-id", true}};
  }
  return {};
}

}  // namespace

int ChannelCount(Aov aov) {
  return int(ChannelsOf(aov).size());
}

int MatteChannelCount(int ranks) {
  return 4 * ((ranks + 1) / 2);
}

std::string MatteName(Matte matte) {
  return matte == Matte::kObject ? "CryptoObject" : "CryptoMaterial";
}

std::vector<OutputChannel> OutputChannelsOf(const RenderSettings& settings) {
  std::vector<OutputChannel> channels{{"R"}, {"G"}, {"B"}, {"A"}};
  for (const Aov aov : settings.aovs) {
    const std::vector<OutputChannel> added = ChannelsOf(aov);
    channels.insert(channels.end(), added.begin(), added.end());
  }
  for (const Matte matte : settings.mattes) {
    for (int i = 0; i < MatteChannelCount(settings.matte_ranks); ++i) {
      channels.push_back({absl::StrFormat("%s%02d.%c", MatteName(matte), i / 4, "RGBA"[i % 4]), true});
    }
  }
  return channels;
}

int OutputChannelCount(const RenderSettings& settings) {
  int count = 4;
  for (const Aov aov : settings.aovs) count += ChannelCount(aov);
  return count + int(settings.mattes.size()) * MatteChannelCount(settings.matte_ranks);
}

}  // namespace shutterline

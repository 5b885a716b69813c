#include "common/job/output_channels.h"

#include <gtest/gtest.h>

#include <set>

namespace shutterline {
namespace {

RenderSettings Everything() {
  RenderSettings settings;
  settings.occlusion = OcclusionSettings();
  for (int i = 0; i <= int(Aov::kMaterialId); ++i) settings.aovs.push_back(Aov(i));
  settings.mattes = {Matte::kObject, Matte::kMaterial};
  settings.matte_ranks = kMaxMatteRanks;
  return settings;
}

TEST(OutputChannels, OfAPlainFrameAreItsColour) {
  EXPECT_EQ(OutputChannelsOf({}), (std::vector<OutputChannel>{{"R"}, {"G"}, {"B"}, {"A"}}));
  EXPECT_EQ(OutputChannelCount({}), 4);
}

TEST(OutputChannels, AllAreCountedNamedOnceAndWithinTheBound) {
  const RenderSettings settings = Everything();
  ASSERT_TRUE(Validate(settings).ok()) << Validate(settings);
  const std::vector<OutputChannel> channels = OutputChannelsOf(settings);
  EXPECT_EQ(int(channels.size()), OutputChannelCount(settings));
  EXPECT_EQ(int(channels.size()), kMaxOutputChannels);
  std::set<std::string> names;
  for (const OutputChannel& channel : channels)
    EXPECT_TRUE(names.insert(channel.name).second) << channel.name;
  EXPECT_TRUE(names.contains("CryptoObject00.R"));
  EXPECT_TRUE(names.contains("CryptoMaterial15.A"));
  EXPECT_EQ(MatteChannelCount(1), 4);
  EXPECT_EQ(MatteChannelCount(2), 4);
  EXPECT_EQ(MatteChannelCount(3), 8);
}

}  // namespace
}  // namespace shutterline

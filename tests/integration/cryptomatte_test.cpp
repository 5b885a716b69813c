// A frame with everything in it, rendered through the service and read back with OpenEXR alone, as a
// compositor would: ids through the manifest of the file's header.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/integration/farm.h"

namespace shutterline {
namespace {

/// A file's channels, each an array of floats.
class Picture {
 public:
  explicit Picture(const std::string& path) : file_(path.c_str()) {
    const Imath::Box2i window = file_.header().dataWindow();
    width_ = window.max.x - window.min.x + 1;
    height_ = window.max.y - window.min.y + 1;
    Imf::FrameBuffer frame;
    for (auto c = file_.header().channels().begin(); c != file_.header().channels().end(); ++c) {
      std::vector<float>& values = channels_[c.name()];
      types_[c.name()] = c.channel().type;
      values.resize(size_t(width_) * size_t(height_));
      frame.insert(c.name(), Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), sizeof(float),
                                        sizeof(float) * size_t(width_)));
    }
    file_.setFrameBuffer(frame);
    file_.readPixels(window.min.y, window.max.y);
  }
  size_t pixels() const { return size_t(width_) * size_t(height_); }
  const std::vector<float>& operator[](const std::string& name) const { return channels_.at(name); }
  bool Has(const std::string& name) const { return channels_.contains(name); }
  Imf::PixelType TypeOf(const std::string& name) const { return types_.at(name); }

  /// Ids by name of the Cryptomatte with this name.
  std::map<std::string, uint32_t> Manifest(const std::string& layer) const {
    std::map<std::string, uint32_t> ids;
    for (auto a = file_.header().begin(); a != file_.header().end(); ++a) {
      const std::string name = a.name();
      const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute());
      if (text == nullptr || name.find("cryptomatte/") != 0 || name.find("/name") == std::string::npos)
        continue;
      if (text->value() != layer) continue;
      const std::string prefix = name.substr(0, name.size() - 4);
      const auto& header = file_.header();
      EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>(prefix + "conversion").value(),
                "uint32_to_float32");
      const auto manifest =
          nlohmann::json::parse(header.typedAttribute<Imf::StringAttribute>(prefix + "manifest").value());
      for (const auto& [key, id] : manifest.items())
        ids[key] = uint32_t(std::stoul(id.get<std::string>(), nullptr, 16));
    }
    return ids;
  }

  /// By pixel: what of it belongs to the id.
  std::vector<float> Matte(const std::string& layer, uint32_t id) const {
    std::vector<float> matte(pixels());
    for (int part = 0; Has(Name(layer, part, 'R')); ++part) {
      for (const auto& [ids, coverages] : {std::pair('R', 'G'), std::pair('B', 'A')}) {
        const std::vector<float>&i = (*this)[Name(layer, part, ids)],
              &c = (*this)[Name(layer, part, coverages)];
        for (size_t p = 0; p < pixels(); ++p) {
          if (std::bit_cast<uint32_t>(i[p]) == id) matte[p] += c[p];
        }
      }
    }
    return matte;
  }

 private:
  static std::string Name(const std::string& layer, int part, char channel) {
    return layer + std::string(part < 10 ? "0" : "") + std::to_string(part) + "." + channel;
  }

  Imf::InputFile file_;
  int width_ = 0, height_ = 0;
  std::map<std::string, std::vector<float>> channels_;
  std::map<std::string, Imf::PixelType> types_;
};

TEST(Cryptomatte, OfAFrameThroughTheServiceIsWhatACompositorReads) {
  Farm farm;
  const std::string scene = farm.Scene("demo");
  farm.StartServer();
  farm.StartWorker("one", 2);
  const std::string job = farm.Submit({scene, "--size", "160x120", "--frame", "12", "--aov",
                                       "depth,object-id,normal,albedo,samples", "--cryptomatte",
                                       "object,material", "--cryptomatte-ranks", "16"});
  const std::string file = (farm.folder() / "all.exr").string();
  farm.Fetch(job, file);

  const Picture picture(file);
  EXPECT_EQ(picture.TypeOf("R"), Imf::HALF);
  EXPECT_EQ(picture.TypeOf("CryptoObject00.R"), Imf::FLOAT);
  EXPECT_EQ(picture.TypeOf("Z"), Imf::FLOAT);
  for (const std::string layer : {"CryptoObject", "CryptoMaterial"}) {
    const std::map<std::string, uint32_t> manifest = picture.Manifest(layer);
    ASSERT_GT(manifest.size(), 1u) << layer;
    std::vector<double> sum(picture.pixels());
    int seen = 0;
    for (const auto& [name, id] : manifest) {
      const std::vector<float> matte = picture.Matte(layer, id);
      double area = 0;
      for (size_t p = 0; p < picture.pixels(); ++p) {
        EXPECT_GE(matte[p], 0) << name;
        sum[p] += double(matte[p]);
        area += double(matte[p]);
      }
      if (area > 1) ++seen;
    }
    EXPECT_GT(seen, 1) << layer;
    // Alpha is stored as half: that of 0 and 1 is exact.
    for (size_t p = 0; p < picture.pixels(); ++p) EXPECT_NEAR(sum[p], double(picture["A"][p]), 1e-3) << layer;
  }
  // Independent of one another: where one object fills a pixel, it is the one that object-id names.
  std::map<float, std::map<uint32_t, int>> names;
  for (size_t p = 0; p < picture.pixels(); ++p) {
    if (picture["CryptoObject00.G"][p] > 0.9f) {
      ++names[picture["object-id"][p]][std::bit_cast<uint32_t>(picture["CryptoObject00.R"][p])];
    }
  }
  EXPECT_GT(names.size(), 1u);
  for (const auto& [object, ids] : names) EXPECT_EQ(ids.size(), 1u) << object;
}

TEST(Cryptomatte, LossyCompressionIsRefused) {
  Farm farm;
  const Farm::Ended ended = farm.Client({"render", farm.Scene("demo"), "--cryptomatte", "object",
                                         "--compression", "dwaa", "-o", (farm.folder() / "x.exr").string()});
  EXPECT_EQ(ended.status, 2);
  EXPECT_NE(ended.errors.find("dwaa"), std::string::npos) << ended.errors;
}

}  // namespace
}  // namespace shutterline

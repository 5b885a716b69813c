#pragma once

#include <Iex.h>
#include <ImfIO.h>
#include <absl/strings/string_view.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>

namespace shutterline {

/// OpenEXR's input from memory; reading past the end throws, as the library expects. Internal to
/// common/image.
class ExrMemoryInput : public Imf::IStream {
 public:
  ExrMemoryInput(absl::string_view bytes, const char* name) : Imf::IStream(name), bytes_(bytes) {}

  bool read(char* target, int count) override {
    if (count < 0 || position_ > bytes_.size() || uint64_t(count) > bytes_.size() - position_) {
      throw Iex::InputExc("Unexpected end of file.");
    }
    std::memcpy(target, bytes_.data() + position_, size_t(count));
    position_ += uint64_t(count);
    return position_ < bytes_.size();
  }
  uint64_t tellg() override { return position_; }
  void seekg(uint64_t position) override { position_ = position; }

 private:
  absl::string_view bytes_;
  uint64_t position_ = 0;
};

/// OpenEXR's output into a string. The library swallows what is thrown while it closes a file, so
/// `failed()` must be asked after that. Internal to common/image.
class ExrMemoryOutput : public Imf::OStream {
 public:
  explicit ExrMemoryOutput(const char* name) : Imf::OStream(name) {}

  void write(const char* source, int count) override {
    if (count <= 0) return;
    try {
      const size_t end = size_t(position_) + size_t(count);
      if (end > bytes_.size()) bytes_.resize(end);
      std::memcpy(&bytes_[size_t(position_)], source, size_t(count));
      position_ = end;
    } catch (...) {
      failed_ = true;
      throw;
    }
  }
  uint64_t tellp() override { return position_; }
  void seekp(uint64_t position) override { position_ = position; }

  bool failed() const { return failed_; }
  std::string&& TakeBytes() { return std::move(bytes_); }

 private:
  std::string bytes_;
  uint64_t position_ = 0;
  bool failed_ = false;
};

}  // namespace shutterline

#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

namespace shutterline::engine {

/// INVALID_ARGUMENT where a Huffman table of a JPEG file has more than the 256 codes that the format
/// allows. stb_image 2.27 writes past its tables then, so no JPEG goes there unchecked.
absl::Status CheckJpegHuffmanTables(absl::string_view bytes);

}  // namespace shutterline::engine

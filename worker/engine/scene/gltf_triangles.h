#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace shutterline::engine {

/// The corners of the triangles of a TRIANGLES, STRIP or FAN primitive (`mode` 4, 5, 6) over a list of
/// vertices, with glTF's winding. Corners that make no whole triangle are left out.
std::vector<std::array<uint32_t, 3>> CutGltfTriangles(int mode, const std::vector<uint32_t>& vertices);

/// How many triangles that gives of `count` corners; 0 for points and lines.
uint64_t CountGltfTriangles(int mode, uint64_t count);

/// How many segments a LINES, LINE_LOOP or LINE_STRIP primitive (1, 2, 3) draws with `count` vertices.
uint64_t CountGltfLines(int mode, uint64_t count);

}  // namespace shutterline::engine

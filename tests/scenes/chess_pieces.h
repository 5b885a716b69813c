#pragma once

#include "tests/scenes/glb_scene.h"

namespace shutterline::scenes {

/// One chess piece, standing on y = 0 about the y axis, on a square of side 1; `kind` is one of "PRNBQK".
/// About a thousand triangles. With texture coordinates whose v runs down, along the grain of turned wood.
Primitive MakeChessPiece(char kind);

}  // namespace shutterline::scenes

#!/bin/sh
# Renders the scenes of docs/materials.md and puts each beside the screenshot that came with it.
#
#   compare_screenshots.sh SHUTTERLINE SCENES OUT
#
# SHUTTERLINE: the program; SCENES: a folder with NAME/NAME.glb and NAME/screenshot.*; OUT: a folder, made if
# need be, that gets NAME.exr, NAME.png and NAME_pair.png (ours on the left), the last where ImageMagick is
# installed and there is a screenshot.
set -eu
[ $# -eq 3 ] || { sed -n '2,9p' "$0" >&2; exit 2; }
program=$1 scenes=$2 out=$3
mkdir -p "$out"

compare() {
  name=$1
  shift
  "$program" render "$scenes/$name/$name.glb" --size 480x360 --png -q -o "$out/$name.exr" "$@"
  command -v convert >/dev/null || return 0
  for screenshot in "$scenes/$name"/screenshot.*; do
    [ -e "$screenshot" ] || continue
    convert "$out/$name.png" "${screenshot}[0]" -resize x360 +append "$out/${name}_pair.png"
  done
}

compare OpenChessSet
compare ToyCar
compare VintageDeskFan --frame 10
compare CesiumMan --frame 24
compare AlphaBlendModeTest
compare VertexColorTest

#!/bin/bash
# tidy.sh BUILD_DIR [REGEX]: runs clang-tidy with the checks of .clang-tidy over the compiled sources of
# ours whose path matches REGEX (default: all but the tests).
set -euo pipefail
build=$1
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
runner=$(command -v run-clang-tidy-14 || command -v run-clang-tidy || true)
if [[ -z $runner ]]; then
  echo "clang-tidy is not installed: apt-get install clang-tidy" >&2
  exit 1
fi
"$runner" -quiet -p "$build" "${2-^$root/(common|proto|worker|server|client)/.*\.cpp\$}"

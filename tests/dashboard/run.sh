#!/bin/bash
# Runs the dashboard's test in a browser: run.sh PROGRAMS BUILD_FOLDER [PICTURES]. Exits with 77, which ctest
# reports as skipped, where node, chromium or the npm package are missing; deploy/install installs all three.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
programs=$1 folder=$2 pictures=${3-}

skip() {
  printf 'SKIPPED: the dashboard was not tested: %s; deploy/test installs what it needs\n' "$*" >&2
  exit 77
}
node=$(command -v node || command -v nodejs) || skip "there is no node"
chromium=$(command -v chromium || command -v chromium-browser) || skip "there is no chromium"
# Of the locked packages, those of this very lock.
if ! cmp --quiet "$here/package-lock.json" "$folder/installed-lock.json"; then
  command -v npm >/dev/null || skip "there is no npm"
  mkdir -p "$folder"
  cp "$here/package.json" "$here/package-lock.json" "$folder"
  (cd "$folder" && npm ci --no-audit --no-fund --ignore-scripts) || skip "npm could not install playwright-core"
  cp "$here/package-lock.json" "$folder/installed-lock.json"
fi
cd "$folder"
exec "$node" "$here/dashboard_test.mjs" "$programs" "$folder" "$chromium" ${pictures:+"$pictures"}

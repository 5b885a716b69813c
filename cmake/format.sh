#!/bin/bash
# Formats the C++ sources in place; with --check, names the files that are not formatted instead and
# exits with 1. Exits with 77 where clang-format 14, Debian 12's, is not installed: other versions format
# differently.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

version=14
tool=""
for candidate in "clang-format-$version" clang-format; do
  if command -v "$candidate" >/dev/null && "$candidate" --version | grep -q "version $version\."; then
    tool=$candidate
    break
  fi
done
if [[ -z $tool ]]; then
  echo "SKIPPED: clang-format $version is not installed (Debian package clang-format); nothing was checked" >&2
  exit 77
fi

sources() {
  find common proto worker server client tests \( -name '*.h' -o -name '*.cpp' \) -print0
}
if [[ ${1-} == --check ]]; then
  sources | xargs -0 "$tool" --dry-run --Werror
  echo "every source is formatted"
else
  sources | xargs -0 "$tool" -i
fi

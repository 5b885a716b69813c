# shellcheck shell=bash
# Shared by deploy/install, deploy/demo and deploy/test, which source it. Sets `root`, the source tree.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# With the seconds since the start: what takes long is seen in any log.
say() { printf '\n== %s (at %d s)\n' "$*" "$SECONDS"; }
die() {
  printf 'error: %s\n' "$*" >&2
  exit 1
}

# listed_packages [programs]: the packages of deploy/packages.txt, one a line, without comments; `programs`: without
# those for tests alone.
listed_packages() {
  local end='/^$/d'
  if [[ ${1-} == programs ]]; then end='/^# Tests alone/,$d'; fi
  sed -e "$end" -e 's/#.*//' -e 's/[[:space:]]//g' -e '/^$/d' "$root/deploy/packages.txt"
}

# Those of them that are not installed, likewise.
missing_packages() {
  local package
  while read -r package; do
    # These often come from elsewhere (Node with npm in it), and Debian's packages would conflict with those.
    case $package in
      kubernetes-client) if command -v kubectl >/dev/null; then continue; fi ;;
      nodejs) if command -v node >/dev/null; then continue; fi ;;
      npm) if command -v npm >/dev/null; then continue; fi ;;
    esac
    if [[ $(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null) != installed ]]; then
      echo "$package"
    fi
  done < <(listed_packages "$@")
}

# install_packages [programs]: installs what is missing, as root or through sudo. Needs no network where nothing is missing.
install_packages() {
  [[ -r $root/deploy/packages.txt ]] || die "$root/deploy/packages.txt is missing"
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    die "this needs Debian 12 (no dpkg-query or apt-get here); install by hand what deploy/packages.txt names"
  fi
  local missing as_root=()
  mapfile -t missing < <(missing_packages "$@")
  if [[ ${#missing[@]} -eq 0 ]]; then
    say "All packages of deploy/packages.txt are installed"
    return
  fi
  say "Installing ${#missing[@]} packages: ${missing[*]}"
  if [[ $(id -u) -ne 0 ]]; then
    command -v sudo >/dev/null \
      || die "neither root nor sudo; as root: apt-get install --no-install-recommends ${missing[*]}"
    as_root=(sudo)
  fi
  # An `env` in between, because sudo drops the caller's environment.
  "${as_root[@]}" apt-get update \
    || die "apt-get update failed; is there a network, and may this user install packages?"
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install --yes --no-install-recommends "${missing[@]}" \
    || die "apt-get could not install: ${missing[*]}"
}

# How many compilers run at once: one a core, but none without 1.5 GB of memory to itself.
build_jobs() {
  local cores memory_jobs
  cores=$(nproc)
  memory_jobs=$(awk '/^MemAvailable:/ { print int($2 / 1500000) }' /proc/meminfo)
  if ((memory_jobs < 1)); then memory_jobs=1; fi
  echo $((cores < memory_jobs ? cores : memory_jobs))
}

# build PRESET [TARGET...]: configures and builds, everything where no target is named.
build() {
  local preset=$1
  shift
  say "Building ($preset, $(build_jobs) at a time)"
  (
    cd "$root" || exit
    cmake --preset "$preset"
    cmake --build --preset "$preset" --parallel "$(build_jobs)" ${1+--target "$@"}
  )
}

#!/usr/bin/env bash
# Installs what is missing, configures and builds in build/ (or $CHAINMAIL_BUILD_DIR): bash Testing/prepare.sh [options
# for CMake]. Can be run again at little cost. Testing/run-all.sh and Data/main-job.sh source it for its functions.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=${CHAINMAIL_BUILD_DIR:-$root/build}

say() { printf '\n== %s\n' "$*"; }
fail() { printf '\nERROR: %s\n' "$*" >&2; exit 1; }

build_packages=(g++ cmake make ocl-icd-opencl-dev opencl-clhpp-headers paraview-dev python3-paraview python3-dev
  libopenmpi-dev libdouble-conversion-dev)
run_packages=(pocl-opencl-icd python3-numpy xvfb xauth)
test_packages=(libgtest-dev imagemagick xdotool python3-scipy python3-pydicom dpkg-dev file)
benchmark_packages=(python3-matplotlib)
check_packages=(valgrind plastimatch elastix debootstrap g++-mingw-w64-x86-64-posix mesa-opencl-icd)
# ParaView's window is of Qt 5 in Debian 12 and of Qt 6 since; its icons are blank without the package for SVG. What
# needs CalculiX, oclgrind or Wine skips where Debian has none.
system=$(. /etc/os-release 2>/dev/null && echo "${ID-} ${VERSION_ID-}")
case $system in
  "debian 12") build_packages+=(qtbase5-dev qttools5-dev libqt5svg5-dev libqt5opengl5-dev qtxmlpatterns5-dev-tools)
    test_packages+=(libqt5svg5 calculix-ccx); check_packages+=(oclgrind wine64) ;;
  *) check_packages+=(ants); build_packages+=(qt6-base-dev qt6-tools-dev qt6-svg-dev qt6-5compat-dev qtxmlpatterns5-dev-tools)
    test_packages+=(qt6-svg-plugins) ;;
esac
# Up to Debian 13, ParaView brings its own VTK. Since then it is built on the system's, and does not ask for its
# development files. Testing names no version.
case $system in
  "debian 12") ;;
  "debian 13") check_packages+=(wine64) ;;
  debian\ *) build_packages+=(libvtk9-dev libvtk9-qt-dev); test_packages+=(calculix-ccx) ;;
esac

# Installs those of the named Debian packages that are missing; asks for nothing when none is.
install_packages() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    say "This is not a Debian system: nothing is installed. What is needed, by Debian's names: $*"
    return 0
  fi
  local missing=() package
  for package in "$@"; do
    case $(dpkg-query -W -f '${Status}' "$package" 2>/dev/null) in
      "install ok installed") ;;
      *) missing+=("$package") ;;
    esac
  done
  [ ${#missing[@]} -eq 0 ] && return 0

  local command="apt-get install --no-install-recommends ${missing[*]}"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || fail "Packages are missing and installing them needs root. As root, run:
  apt-get update && $command"
    as_root=(sudo)
  fi
  say "Installing ${missing[*]} (up to 3 GB on disk when nothing is there yet)"
  "${as_root[@]}" apt-get update || fail "apt-get update failed, see above. Is the network there?"
  for package in "${missing[@]}"; do
    [ -n "$(apt-cache show "$package" 2>/dev/null)" ] ||
      fail "The package $package is not in this system's package lists. Debian 12, 13 and testing have it in their section main: see /etc/apt/sources.list."
  done
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install --yes --no-install-recommends -o Dpkg::Use-Pty=0 "${missing[@]}" ||
    fail "Packages could not be installed, see above. The command was:
  $command"
}

# configure_and_build [CMake options]
configure_and_build() {
  command -v cmake >/dev/null || fail "cmake was not found."
  say "Configuring in $build"
  cmake -S "$root" -B "$build" "$@" || fail "CMake could not configure the project, see above."
  say "Building"
  cmake --build "$build" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}" || fail "The build failed, see above."
}

# Without /sys, as in a bare chroot, hwloc sees neither cores nor memory, and PoCL and Open MPI, which ask it, give up.
# Then the machine is described to it in words.
describe_machine() {
  [ -d /sys/devices/system/cpu ] && return 0
  [ -z "${HWLOC_SYNTHETIC-}${HWLOC_XMLFILE-}" ] || return 0
  local memory
  memory=$(sed -n 's/^MemAvailable: *\([0-9]*\) kB$/\1/p' /proc/meminfo 2>/dev/null)
  [ -n "$memory" ] || fail "Neither /sys nor /proc is there, so the machine's memory and cores cannot be known. In a chroot run
  mount -t proc proc /proc"
  say "There is no /sys: telling PoCL and MPI of $(nproc) cores and $((memory / 1024)) MiB of memory"
  # Open MPI 5 maps processes to cores and finds none where only processing units are named.
  export HWLOC_SYNTHETIC="numa:1(memory=$((memory * 1024))) core:$(nproc) pu:1"
  export UCX_LOG_LEVEL=fatal # Open MPI 5 asks it for networks, which it looks for there, too
}

# One X server of our own for everything that renders, until the script ends: Debian's ParaView cannot render without
# one, and nothing is to appear on a user's screen. Without -noreset the server starts anew when its last client leaves,
# and refuses the next one if that comes too soon.
start_display() {
  command -v Xvfb >/dev/null || fail "Xvfb was not found: rendering needs an X server (on Debian the package xvfb)."
  local number_file
  number_file=$(mktemp)
  Xvfb -displayfd 3 -screen 0 1600x1200x24 -nolisten tcp -noreset 3>"$number_file" 2>"$number_file.log" &
  xvfb=$!
  trap 'kill "$xvfb" 2>/dev/null; wait "$xvfb" 2>/dev/null' EXIT
  local tries
  for ((tries = 0; tries < 150; ++tries)); do
    [ -s "$number_file" ] && break
    kill -0 "$xvfb" 2>/dev/null || break
    sleep 0.1
  done
  [ -s "$number_file" ] || fail "Xvfb did not start: $(tail -n 3 "$number_file.log")"
  export DISPLAY=":$(tr -d '[:space:]' <"$number_file")"
  rm -f "$number_file" "$number_file.log"
}

if [ "${BASH_SOURCE[0]}" = "$0" ]; then
  set -u
  install_packages "${build_packages[@]}" "${run_packages[@]}" "${test_packages[@]}"
  configure_and_build "$@"
fi

#!/usr/bin/env bash
# The Debian package in a bare system of its own: bash Testing/Roles/tryPackage.sh PACKAGE.deb FOLDER [SUITE]. Makes the
# system in FOLDER with debootstrap (SUITE: bookworm or trixie; default: this machine's), installs the package as a user
# would, and uses it in pvpython and in ParaView's window. Needs root and the network; takes ten minutes and 3 GB.
set -u
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
package=$1 system=$2
suite=${3-$(. /etc/os-release && echo "$VERSION_CODENAME")}
fail() { printf 'FAILED: %s\n' "$*" >&2; exit 1; }
if [ "$(id -u)" -ne 0 ] || ! command -v debootstrap >/dev/null; then
  echo "SKIPPED: it takes root and debootstrap to make a bare system"
  exit 125
fi

rm -rf "$system"
debootstrap --variant=minbase "$suite" "$system" || { echo "SKIPPED: no system could be made of $suite"; exit 125; }
mount -t proc proc "$system/proc" || { echo "SKIPPED: nothing can be mounted here"; exit 125; }
trap 'umount "$system/proc"' EXIT
inside() {
  env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    ${HWLOC_SYNTHETIC:+"HWLOC_SYNTHETIC=$HWLOC_SYNTHETIC"} chroot "$system" "$@"
}
# There is no /sys in it, see Data/Install.md.
HWLOC_SYNTHETIC="numa:1(memory=$((2 << 30))) core:$(nproc) pu:1"

cp "$package" "$here/usePlugin.py" "$here/usePlugin.xml" "$system/root/" || fail "what is tried cannot be copied"
inside apt-get update || fail "no lists of packages"
inside apt-get install --yes "/root/$(basename "$package")" || fail "the package cannot be installed"
inside apt-get install --yes --no-install-recommends xvfb xauth || fail "there is no X server"

inside pvpython /root/usePlugin.py || fail "pvpython does not have the plugin"
inside bash -c 'xvfb-run -a paraview --dr --test-directory=/root --test-script=/root/usePlugin.xml --exit' >"$system/root/log.txt" 2>&1 ||
  fail "ParaView's window does not have the plugin: $(tail -n 20 "$system/root/log.txt")"
inside bash -c 'python3 -c "from paraview import vtk; from chainmail.ChainMailFilters import vtkChainMailDeformation"' ||
  fail "Python does not find the module"
inside apt-get remove --yes chainmail || fail "the package cannot be removed"
inside bash -c 'pvpython /root/usePlugin.py' >/dev/null 2>&1 && fail "the plugin is still there when the package is gone"
echo "installed, used and removed in a bare $suite"

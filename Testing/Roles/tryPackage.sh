#!/usr/bin/env bash
# The Debian package in a bare system of its own: bash Testing/Roles/tryPackage.sh PACKAGE.deb FOLDER [SUITE]. Makes the
# system in FOLDER (SUITE: bookworm, trixie or testing; default: this machine's), installs the package as a user would, and
# uses it in pvpython and in ParaView's window. Needs root and the network; takes ten minutes and 3 GB.
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/bareSystem.sh"
package=$1
make_bare_system "${3-$(. /etc/os-release && echo "$VERSION_CODENAME")}" "$2"
# There is no /sys in it, see Data/Install.md.
described=("HWLOC_SYNTHETIC=numa:1(memory=$((2 << 30))) core:$(nproc) pu:1")

cp "$package" "$here/usePlugin.py" "$here/usePlugin.xml" "$system/root/" || fail "what is tried cannot be copied"
inside apt-get update || fail "no lists of packages"
inside apt-get install --yes "/root/$(basename "$package")" || fail "the package cannot be installed"
inside apt-get install --yes --no-install-recommends xvfb xauth || fail "there is no X server"

inside env "${described[@]}" pvpython /root/usePlugin.py || fail "pvpython does not have the plugin"
inside env "${described[@]}" xvfb-run -a paraview --dr --test-directory=/root --test-script=/root/usePlugin.xml --exit \
  >"$system/root/log.txt" 2>&1 || fail "ParaView's window does not have the plugin: $(tail -n 20 "$system/root/log.txt")"
inside python3 -c "from paraview import vtk; from chainmail.ChainMailFilters import vtkChainMailDeformation" ||
  fail "Python does not find the module"
inside apt-get remove --yes chainmail || fail "the package cannot be removed"
inside pvpython /root/usePlugin.py >/dev/null 2>&1 && fail "the plugin is still there when the package is gone"
unmake_bare_system
echo "installed, used and removed in a bare $suite"

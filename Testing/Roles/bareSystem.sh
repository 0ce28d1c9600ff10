# Bare Debian systems to try things in, in folders of their own; those who need one source this file. It takes root, the
# network and debootstrap. What is downloaded is kept beside the systems for the next time.
#
# make_bare_system SUITE FOLDER   makes FOLDER/SUITE anew: bookworm, trixie or testing, with /proc and no more than apt needs
# inside COMMAND...               runs a command in it, as root, with none of this shell's variables
# unmake_bare_system              removes it; without this it stays to be looked at, with nothing mounted

set -u
fail() { printf 'FAILED: %s\n' "$*" >&2; exit 1; }
skip() { echo "SKIPPED: $*"; exit 125; }

make_bare_system() {
  suite=$1 system=$2/$1
  local base=$2/$suite.tar packages=$2/$suite.packages
  [ "$(id -u)" -eq 0 ] && command -v debootstrap >/dev/null || skip "it takes root and debootstrap to make a bare system"
  mkdir -p "$packages/partial" || fail "cannot write to $2"
  remove_system
  find "$base" -mtime +30 -delete 2>/dev/null # as testing goes on
  if [ ! -f "$base" ]; then
    debootstrap --variant=minbase "$suite" "$system" http://deb.debian.org/debian || skip "no system could be made of $suite"
    # The lists of a mirror that is a copy may have run out, as those of a real system do not.
    echo 'Acquire::Check-Valid-Until "false";' >"$system/etc/apt/apt.conf.d/90mirror"
    tar -C "$system" -cf "$base.part" . && mv "$base.part" "$base" || fail "cannot write to $2"
  else
    mkdir "$system" && tar -C "$system" -xf "$base" || fail "$base cannot be unpacked"
  fi
  trap unmount_system EXIT
  mount -t proc proc "$system/proc" && mount --bind "$packages" "$system/var/cache/apt/archives" ||
    skip "nothing can be mounted here"
}

inside() {
  env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive chroot "$system" "$@"
}

unmount_system() {
  local mounted
  for mounted in $(cut -d' ' -f2 /proc/mounts | grep "^$(realpath -m "$system")/" | sort -r); do
    umount "$mounted" || umount --lazy "$mounted"
  done
}

# What still runs there, such as a compilation ahead of need, would write on while files are removed.
end_processes() {
  local process
  for process in /proc/[0-9]*; do
    [ "$(readlink "$process/root")" = "$(realpath -m "$system")" ] && kill -KILL "${process##*/}"
  done 2>/dev/null
}

# Never with something mounted in it: that would be removed as well.
remove_system() {
  end_processes
  unmount_system
  grep -q " $(realpath -m "$system")/" /proc/mounts && fail "something is still mounted in $system"
  rm -rf "$system"
}

unmake_bare_system() {
  inside apt-get autoclean >/dev/null # keeps what the next time needs
  remove_system
}

#!/usr/bin/env bash
# The README's two commands in a bare system: bash Testing/Roles/tryCommands.sh SUITE FOLDER [COMMAND]. Makes the system in
# FOLDER (SUITE: bookworm, trixie or testing) with a copy of this working tree, and runs `bash Data/main-job.sh`, then `bash
# Testing/run-all.sh` with compiler warnings as errors; or COMMAND instead. Says what time and disk each took. Needs root
# and the network; takes an hour on two cores and 6 GB.
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
. "$here/bareSystem.sh"
root=$(cd "$here/../.." && pwd)
command -v git >/dev/null && git -C "$root" rev-parse HEAD >/dev/null 2>&1 || skip "it takes git to know the files of the working tree"
make_bare_system "$1" "$2"

tree=$system/root/chainmail
mkdir "$tree" && cd "$root" && git ls-files -z --cached --others --exclude-standard |
  while IFS= read -r -d '' file; do [ ! -e "$file" ] || printf '%s\0' "$file"; done |
  tar --create --null --files-from=- | tar -C "$tree" --extract || fail "the working tree cannot be copied"
variables=(CI=true)
if [ -d "${CHAINMAIL_VOLUMES:=$root/../shared/volumes}" ]; then
  mkdir "$system/root/volumes" && mount --bind -o ro "$CHAINMAIL_VOLUMES" "$system/root/volumes" || skip "nothing can be mounted here"
  variables+=(CHAINMAIL_VOLUMES=/root/volumes)
fi

# Without what is mounted: there is nothing of the user's, and apt's archives are those of earlier runs, too.
megabytes() {
  du --summarize --block-size=1M --exclude="$system/proc" --exclude="$system/root/volumes" \
    --exclude="$system/var/cache/apt/archives" "$system" | cut -f1
}
# try COMMAND: runs it where the code is, and says what it took.
try() {
  local before=$(megabytes) began=$SECONDS status
  inside env -C /root/chainmail "${variables[@]}" bash -c "$1"
  status=$?
  printf '\n== %s in a bare %s: status %d, %d:%02d minutes, %d MB more on disk\n' "$1" "$suite" "$status" \
    $(((SECONDS - began) / 60)) $(((SECONDS - began) % 60)) $(($(megabytes) - before))
  [ "$status" -eq 0 ] || fail "'$1' does not work in a bare $suite; it stays in $system"
}
if [ $# -gt 2 ]; then
  try "$3"
else
  try "bash Data/main-job.sh"
  for file in input.png deformed.png cut.png deformed.vti cut.vti; do
    [ -s "$tree/output/$file" ] || fail "the main job has left no output/$file"
  done
  try "bash Testing/run-all.sh"
fi
unmake_bare_system

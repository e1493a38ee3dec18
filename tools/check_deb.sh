#!/bin/bash
# check_deb.sh PACKAGE: lintian without errors; then, in a fresh Debian 12, the package is installed
# with what it depends on, maps a simulated recording, and is removed without a trace.
set -euo pipefail

package=$(readlink -f "$1")
skip() {
  echo "SKIPPED: check_deb: $1" >&2
  exit 0
}

command -v lintian >/dev/null || skip "lintian is not installed"
lintian --allow-root --fail-on error "$package"

command -v mmdebstrap >/dev/null || skip "mmdebstrap is not installed"
[[ $(id -u) -eq 0 ]] || skip "a chroot needs root"
mirror=$(grep -rhoE 'https?://[^ ]+/debian/?( |$)' /etc/apt/sources.list /etc/apt/sources.list.d 2>/dev/null |
  head -n 1 | tr -d ' ' || true)
[[ -n $mirror ]] || mirror=$(grep -rhE '^URIs:' /etc/apt/sources.list.d 2>/dev/null | awk '{print $2; exit}')
[[ -n $mirror ]] || skip "no mirror of Debian is configured"

root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
chmod 755 "$root"
options=(--mode=root --variant=minbase --aptopt='Acquire::Check-Valid-Until "false"')
mmdebstrap "${options[@]}" bookworm "$root/tree" "$mirror" >&2 || skip "the mirror $mirror does not answer"

tree=$root/tree
cp "$package" "$tree/tmp/rali.deb"
chroot "$tree" apt-get update -q >&2
chroot "$tree" apt-get install -y -q --no-install-recommends /tmp/rali.deb >&2
chroot "$tree" rali --version
chroot "$tree" rali simulate corridor --seed 1 --vehicles 1 -o /tmp/sim --duration 20 >&2
chroot "$tree" rali map /tmp/sim/fleet.yaml -o /tmp/out
[[ -s $tree/tmp/out/map.pcd && -s $tree/tmp/out/report.html ]]
chroot "$tree" dpkg --purge rali >&2
left=$(chroot "$tree" sh -c 'find / -xdev -path /tmp -prune -o -path /proc -prune -o -path /var/log -prune -o \( -name rali -o -name "rali[._-]*" \) -print')
if [[ -n $left ]]; then
  echo "left behind: $left" >&2
  exit 1
fi
echo "check_deb: installed, run and removed"

#!/bin/bash
# check_deb.sh PACKAGES...: lintian without errors; then, in a fresh Debian 12, the packages are
# installed with what they depend on and used: the program maps a simulated recording, a program
# outside compiles against librali-dev, python3-rali maps as well. Then all are removed without a
# trace.
set -euo pipefail

skip() {
  echo "SKIPPED: check_deb: $1" >&2
  exit 0
}

packages=()
names=()
for file in "$@"; do
  packages+=("$(readlink -f "$file")")
  names+=("$(dpkg-deb --field "$file" Package)")
done
examples=$(cd "$(dirname "$0")/../examples" && pwd)

command -v lintian >/dev/null || skip "lintian is not installed"
lintian --allow-root --fail-on error "${packages[@]}"

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
inside() { chroot "$tree" "$@"; }
has() { [[ " ${names[*]} " == *" $1 "* ]]; }

mkdir "$tree/tmp/packages"
cp "${packages[@]}" "$tree/tmp/packages"
inside apt-get update -q >&2
inside sh -c 'apt-get install -y -q --no-install-recommends /tmp/packages/*.deb' >&2
inside rali --version
inside rali simulate corridor --seed 1 --vehicles 1 -o /tmp/sim --duration 20 >&2
inside rali map /tmp/sim/fleet.yaml -o /tmp/out
[[ -s $tree/tmp/out/map.pcd && -s $tree/tmp/out/report.html ]]

if has librali-dev; then
  inside apt-get install -y -q --no-install-recommends g++ cmake make >&2
  cp -r "$examples" "$tree/tmp/examples"
  inside cmake -S /tmp/examples -B /tmp/consumer >&2
  inside cmake --build /tmp/consumer >&2
  inside /tmp/consumer/map_recording /tmp/sim/fleet.yaml /tmp/out_library /tmp/sim/truth
  cmp "$tree/tmp/out/trajectory/v1.tum" "$tree/tmp/out_library/trajectory/v1.tum"
fi
if has python3-rali; then
  inside python3 -c "
import rali
summary = rali.map('/tmp/sim/fleet.yaml', out='/tmp/out_python')
print(rali.__version__, summary.status, rali.read_map('/tmp/out_python/map.pcd').xyz_m.shape)"
  cmp "$tree/tmp/out/trajectory/v1.tum" "$tree/tmp/out_python/trajectory/v1.tum"
fi

inside dpkg --purge "${names[@]}" >&2
left=$(inside sh -c 'find / -xdev -path /tmp -prune -o -path /proc -prune -o -path /var/log -prune -o \( -name rali -o -name "rali[._-]*" -o -name "*librali*" -o -name "_rali*" \) -print')
if [[ -n $left ]]; then
  echo "left behind: $left" >&2
  exit 1
fi
echo "check_deb: ${names[*]}: installed, used and removed"

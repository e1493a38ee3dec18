#!/bin/bash
# read_clouds.sh RUN: CloudCompare opens map.ply, map.pcd and map.las and writes them as text; each has
# as many points as the header of map.ply states, and the first one lies where the PLY's does.
# Exit 77: CloudCompare or Xvfb is not there.
set -euo pipefail

for tool in CloudCompare xvfb-run; do
  command -v "$tool" >/dev/null && continue
  echo "SKIPPED: $tool is not there; install cloudcompare and xvfb (tools/conformance.sh)"
  exit 77
done

run=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
wanted=$(head -c 2000 "$run/map.ply" | grep -a -m1 '^element vertex' | cut -d' ' -f3)
export XDG_RUNTIME_DIR=$work

for kind in ply pcd las; do
  cp "$run/map.$kind" "$work/cloud.$kind"
  ok=0
  xvfb-run -a timeout 120 CloudCompare -SILENT -AUTO_SAVE OFF -NO_TIMESTAMP -O "$work/cloud.$kind" \
    -C_EXPORT_FMT ASC -PREC 3 -EXT txt -SAVE_CLOUDS FILE "$work/$kind.txt" >"$work/log" 2>&1 || ok=$?
  if grep -qi "unhandled file extension" "$work/log"; then
    echo "SKIPPED $kind: this CloudCompare has no reader for it"
    continue
  fi
  if [[ $ok -ne 0 || ! -s $work/$kind.txt ]]; then
    echo "CloudCompare refuses map.$kind:"
    tail -20 "$work/log"
    exit 1
  fi
  points=$(grep -c '^[-0-9]' "$work/$kind.txt")
  first=$(grep -m1 '^[-0-9]' "$work/$kind.txt" | cut -d' ' -f1-3)
  echo "map.$kind: $points points, first $first"
  [[ $points -eq $wanted ]] || { echo "map.ply states $wanted"; exit 1; }
  [[ $kind == ply ]] && ply_first=$first
  [[ $first == "$ply_first" ]] || { echo "the first point of map.ply is $ply_first"; exit 1; }
done

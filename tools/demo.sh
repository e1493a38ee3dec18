#!/bin/bash
# demo.sh: simulates a recording, maps it and judges it by the truth; leaves rali-demo/out/report.html
# and rali-demo/map.png. With the recorded drive of KITTI in RALI_DATA_DIR (default ../shared/data)
# that is mapped, too, as rali-demo/kitti/map.png.
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
rali=${RALI:-$root/build/release/bin/rali}
data=${RALI_DATA_DIR:-$root/../shared/data}
out=${1:-rali-demo}

"$rali" demo -o "$out"

drive=$data/kitti_0005/scans16
if [[ -d $drive ]]; then
  scans=$(mktemp -d)
  trap 'rm -rf "$scans"' EXIT
  python3 "$root/tools/convert_compact_scans.py" "$drive" "$scans/kitti" --period 0.10356
  # The sweeps are not undistorted and carry no point times: the azimuth gives them.
  "$rali" map "$scans/kitti" -o "$out/kitti" --overwrite --lidar-model hdl64e \
    --set vehicles.kitti.lidar.point_time=azimuth
  "$rali" picture "$out/kitti" --title "KITTI 2011_09_26_0005, 16 rings, no IMU"
fi

#!/bin/bash
# conformance.sh [BUILD]: installs the readers of others as far as we may and the network is there, and
# runs the tests that give them what RaLI writes. Needs a built BUILD (default build/release).
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
build=${1:-$root/build/release}
"$root/tools/install_packages.sh" cloudcompare xvfb xauth python3-rosbag python3-sensor-msgs nodejs npm ||
  echo "the packages were not installed: what needs them is skipped" >&2
npm_folder=$build/conformance/npm
mkdir -p "$npm_folder"
cp "$root"/tests/conformance/package{,-lock}.json "$npm_folder/"
(cd "$npm_folder" && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error) ||
  echo "the npm registry was not reached: session.mcap is not read" >&2
exec ctest --test-dir "$build" -L conformance --output-on-failure --no-tests=error

#!/bin/bash
# run_fuzz.sh BIN_DIR SECONDS: runs each fuzz target over its corpus; a crash is kept in
# build/fuzz/crashes and ends with 1.
set -euo pipefail

bin=$1
seconds=$2
crashes=$bin/../crashes
mkdir -p "$crashes"
failed=()
for target in "$bin"/fuzz_*; do
  name=$(basename "$target")
  seeds=tests/corpus/${name#fuzz_}
  work=$bin/../corpus/$name  # new inputs stay out of the repository
  mkdir -p "$work"
  dirs=("$work")
  [[ -d $seeds ]] && dirs+=("$seeds")
  echo "== $name: $seconds s"
  "$target" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 \
    -artifact_prefix="$crashes/$name-" "${dirs[@]}" 2>"$crashes/$name.log" || failed+=("$name")
  grep -E '^stat::number_of_executed_units|^SUMMARY|^ERROR' "$crashes/$name.log" || true
done
if [[ ${#failed[@]} -gt 0 ]]; then
  echo "failed: ${failed[*]}; inputs and logs in $crashes" >&2
  exit 1
fi

#!/bin/bash
# install_packages.sh NAME...: installs the Debian packages that are missing. Without the right to
# do so it names them and goes on: the libraries may have been built by hand.
set -euo pipefail

missing=()
for package in "$@"; do
  status=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true)
  [[ $status == "install ok installed" ]] && continue
  # Node's own package holds npm and refuses to lie beside Debian's: what runs is enough.
  [[ $package == npm || $package == nodejs ]] && command -v "${package%js}" >/dev/null && continue
  missing+=("$package")
done
[[ ${#missing[@]} -eq 0 ]] && exit 0

run=()
if [[ $(id -u) -ne 0 ]]; then
  if command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
    run=(sudo -n)
  else
    echo "missing packages: ${missing[*]}. Install them with: apt-get install ${missing[*]}" >&2
    exit 0
  fi
fi
export DEBIAN_FRONTEND=noninteractive
"${run[@]}" apt-get update -q
"${run[@]}" apt-get install -y -q --no-install-recommends "${missing[@]}"

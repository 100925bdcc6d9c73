# SPDX-License-Identifier: BSD-3-Clause
# For the scripts of this folder, which source it in the repository's root: what every program here can.

print_version() { sed -nE 's/^project\(slamd VERSION ([0-9.]+).*/\1/p' CMakeLists.txt; }

# wrong_use WORDS: as every program, 2 on a command line that is not understood
wrong_use() {
  local name=${0##*/}
  echo "$name: $1; see tools/$name --help" >&2
  exit 2
}

# need_number OPTION [VALUE]
need_number() { [[ ${2:-} =~ ^[0-9]+$ ]] || wrong_use "$1 needs a number"; }

# need_folder OPTION [VALUE]
need_folder() { [ -n "${2:-}" ] || wrong_use "$1 needs a folder"; }

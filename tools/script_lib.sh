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

# For ctest -j: four slots a core, of which each test takes what tests/CMakeLists.txt gives it.
test_slots() { echo $((4 * $(nproc))); }

# run_tests PRESET [ctest options]: tests of real time (threads, live daemons, virtual machines, browsers) depend on what else
# the machine does. Where only such have failed, at most five, and no sanitizer has found anything, they are run once more,
# one at a time, and named in build/PRESET/second_tries.txt. What this machine cannot test is named in one line, by reason.
run_tests() {
  local preset=$1 results=build/$1/Testing/Temporary tries=build/$1/second_tries.txt junit=$PWD/build/$1/tests.xml status=0
  shift
  rm -f "$tries" "$junit"
  ctest --preset "$preset" -j "$(test_slots)" --output-junit "$junit" "$@" || status=$?
  [ ! -e "$junit" ] || "${BASH_SOURCE[0]%/*}/test_report" skipped "$junit"
  [ "$status" -ne 0 ] || return 0
  if grep -qE 'ERROR: (Address|Leak)Sanitizer|WARNING: ThreadSanitizer|runtime error:' "$results/LastTest.log"; then
    return 1
  fi
  sed 's/^[0-9]*://' "$results/LastTestsFailed.log" >"$tries"
  [ "$(wc -l <"$tries")" -le 5 ] || return 1
  if grep -vxFf <(ctest --preset "$preset" -N -L 'threads|integration|faults|vm|web|spy|packages' |
    sed -nE 's/^ +Test +#[0-9]+: //p') "$tries"; then
    return 1
  fi
  ctest --preset "$preset" --rerun-failed || return 1
  echo "Failed among the others and passed alone:" && cat "$tries"
}

# need_folder OPTION [VALUE]
need_folder() { [ -n "${2:-}" ] || wrong_use "$1 needs a folder"; }

# all_met FILE: false where a row of the table says that its target was missed
all_met() { ! grep -qF '| **missed** |' "$1"; }

# write_table NAME [FILE...]: puts the table on stdin between <!-- BEGIN NAME --> and <!-- END NAME --> of the one file
# that has them, by default README.md or a file in docs/ or one of its folders
write_table() {
  local name=$1 files=("${@:2}") begin end homes=()
  begin="<!-- BEGIN $name -->" end="<!-- END $name -->"
  [ ${#files[@]} -gt 0 ] || files=(README.md docs/*.md docs/*/*.md)
  mapfile -t homes < <(awk -v b="$begin" -v e="$end" '
    FNR == 1 {open = 0}
    $0 == b {open = 1}
    $0 == e && open {print FILENAME; open = 0}' "${files[@]}")
  if [ ${#homes[@]} -ne 1 ]; then
    echo "${0##*/}: $begin and $end are ${#homes[@]} times in ${files[*]}, not once; nothing written" >&2
    return 1
  fi
  local new
  new=$(mktemp "${homes[0]}.XXXXXX")
  awk -v b="$begin" -v e="$end" -v table=/dev/stdin '
    $0 == e {while ((getline line <table) > 0) print line; skip = 0}
    !skip {print}
    $0 == b {skip = 1}' "${homes[0]}" >"$new"
  chmod --reference="${homes[0]}" "$new"
  mv "$new" "${homes[0]}"
  echo "${0##*/}: wrote the table $name into ${homes[0]}" >&2
}

# The rows of the table of accuracy that README quotes, without their targets.
headline() { # headline <table
  awk -F ' [|] ' '
    BEGIN {print "| case | figure | value |"; print "|---|---|---|"}
    /^[|] intel [|] final poses, translation / || /times real time/ || /^[|] corridor-loop, seeds 1-10 [|] .*, mean / ||
      /^[|] wean.* [|] (right within|wrong)/ {print $1 " | " $2 " | " $3 " |"}'
}

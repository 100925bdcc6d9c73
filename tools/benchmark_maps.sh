# SPDX-License-Identifier: BSD-3-Clause
# For tools/benchmark, which sources it: maps merged by slamctl. Homes in two drives of different days, each through a part of
# the rooms, furniture moved between them; maps of different homes; the halves of a log; three maps in any order; drives that are refined. $bin, $data,
# $short and $work are its own.
# shellcheck shell=bash disable=SC2154,SC2015 # set by tools/benchmark; "failed" is printed whichever step failed

maps_value() { sed -nE "s/.*\"$1\": ([0-9.]+).*/\1/p" "$2"; } # maps_value KEY FILE

# The drive of a day: part of it mapped as $work/maps/NAME, with its truth.
maps_drive() { # maps_drive NAME HOME DAY FROM TO [WITH]: WITH: what differs from the first day
  local name=$1 out=$work/maps-$1
  "$bin/slam-sim" --no-depth --scene homes --seed $(($2 + 8 * $3)) --with "${6:-furniture-moved=$3}" \
    --log "$out.whole" --truth "$out.true" >/dev/null
  "$bin/slam-benchmark" cut "$out.whole" "$out.lcm" --from "$4" --to "$5" --later $((10000 * $3))
  awk -v later=$((10000 * $3)) '{printf "%.6f", $1 + later; for (i = 2; i <= NF; ++i) printf " %s", $i; print ""}' \
    "$out.true" >"$out.tum"
  "$bin/slam-replay" --config config/sim.toml --set lidar.driver="'lcm'" --set base.driver="'lcm'" --set imu.driver="'lcm'" \
    --log "$out.lcm" --save-map "$work/maps/$name" >/dev/null 2>&1
  rm -f "$out.whole" "$out.lcm" "$out.true"
}
maps_merge() { # maps_merge A B C [--moved]: what slamctl prints goes to $work/merge.txt
  "$bin/slamctl" --maps "$work/maps" --config "${maps_config:-config/sim.toml}" merge "$1" "$2" --as "$3" "${@:4}" \
    >"$work/merge.txt" 2>&1
}
maps_error() { # maps_error MAP TRUTH [KEY]: of its keyframes after alignment [m]
  "$bin/slam-benchmark" keyframes "$work/maps/$1" "$work/$1.tum"
  "$bin/slam-eval" ate "$work/$1.tum" "$2" --json >"$work/ate.json"
  maps_value "${3:-rmse_m}" "$work/ate.json"
}

maps_homes() {
  local homes=8 home right=0 wrong=0 ratios=() one
  [ -z "$short" ] || homes=2
  for home in $(seq "$homes"); do
    maps_drive "west-$home" "$home" 0 0 0.65
    maps_drive "east-$home" "$home" 1 0.35 1
    maps_merge "west-$home" "east-$home" "home-$home" || { echo "home $home: $(cat "$work/merge.txt")" >&2; continue; }
    cat "$work/maps-west-$home.tum" "$work/maps-east-$home.tum" >"$work/both.tum"
    one=$(printf '%s\n' "$(maps_error "west-$home" "$work/maps-west-$home.tum")" \
      "$(maps_error "east-$home" "$work/maps-east-$home.tum")" | awk '{s += $1} END {print s / NR}')
    ratios+=("$(maps_error "home-$home" "$work/both.tum" | awk -v one="$one" '{print $1, one, $1 / one}')")
    echo "home $home: ${ratios[-1]}; $(tr '\n' ';' <"$work/merge.txt")" >&2
    awk '{exit $1 > 0.1}' <<<"${ratios[-1]}" && right=$((right + 1)) || wrong=$((wrong + 1))
  done
  row "homes in two drives, furniture moved" "merged and right without --moved, of $homes" "$right" ">=" "$homes"
  row "homes in two drives, furniture moved" "merged and wrong" "$wrong" "<=" 0
  row "homes in two drives, furniture moved" "ATE by that of one drive, mean" \
    "$(printf '%s\n' "${ratios[@]}" | awk '{s += $1; o += $2} END {printf "%.2f", s / o}')" "<=" 1.2
}

# The same drives where nothing was moved, and on another floor with the same walls and other furniture.
maps_lookalikes() { # after maps_homes
  local homes=8 home right=0 floors=0
  [ -z "$short" ] || homes=2
  for home in $(seq "$homes"); do
    maps_drive "still-$home" "$home" 1 0.35 1 furniture-moved=0
    maps_drive "upper-$home" "$home" 1 0.35 1 floor=2
    maps_merge "west-$home" "still-$home" "day-$home" && {
      cat "$work/maps-west-$home.tum" "$work/maps-still-$home.tum" >"$work/both.tum"
      awk '{exit $1 > 0.1}' <<<"$(maps_error "day-$home" "$work/both.tum")" && right=$((right + 1))
    } || true
    echo "home $home, nothing moved: $(tr '\n' ';' <"$work/merge.txt")" >&2
    maps_merge "west-$home" "upper-$home" "floors-$home" && floors=$((floors + 1)) || true
    echo "home $home, two floors: $(tr '\n' ';' <"$work/merge.txt")" >&2
  done
  row "homes in two drives, nothing moved" "merged and right without --moved, of $homes" "$right" ">=" "$homes"
  row "two floors with the same walls, $homes pairs" "merged without --moved" "$floors" "<=" 0
}

maps_others() { # after maps_homes
  local homes=8 here there merged=0
  [ -z "$short" ] || homes=2
  for here in $(seq "$homes"); do
    for there in $(seq "$homes"); do
      [ "$here" -ne "$there" ] || continue
      maps_merge "west-$here" "east-$there" "other-$here-$there" --moved && merged=$((merged + 1)) || true
      echo "$here in $there: $(head -1 "$work/merge.txt")" >&2
    done
  done
  row "different homes, $((homes * (homes - 1))) pairs" "merged with --moved" "$merged" "<=" 0
}

maps_orders() {
  local a b c worst=0 gap
  maps_drive first 3 0 0 0.5
  maps_drive second 3 1 0.25 0.75
  maps_drive third 3 2 0.45 1
  for order in "first second third" "second first third" "second third first" "third second first"; do
    read -r a b c <<<"$order"
    maps_merge "$a" "$b" "$a-$b" --moved && maps_merge "$a-$b" "$c" "$a-$b-$c" --moved || { echo "$order: $(cat "$work/merge.txt")" >&2; worst=; break; }
    if [ "$order" = "first second third" ]; then
      "$bin/slam-benchmark" keyframes "$work/maps/$a-$b-$c" "$work/in-order.tum"
      continue
    fi
    gap=$(maps_error "$a-$b-$c" "$work/in-order.tum" max_m)
    worst=$(printf '%s\n' "$worst" "$gap" | sort -g | tail -1)
  done
  row "three drives of a home, in any order" "largest difference of a keyframe" "$worst" "<=" 0.02 m
}

maps_intel() {
  missing "$data/intel/intel.clf.gz" "intel, two halves" && return
  local half
  intel_log
  "$bin/slam-replay" --config config/carmen.toml --log "$work/intel.lcm" --trajectory "$work/whole.tum" >/dev/null
  for half in "former 0 0.5" "latter 0.5 1"; do
    read -r name from to <<<"$half"
    "$bin/slam-benchmark" cut "$work/intel.lcm" "$work/half.lcm" --from "$from" --to "$to"
    "$bin/slam-replay" --config config/carmen.toml --log "$work/half.lcm" --save-map "$work/maps/$name" >/dev/null
  done
  maps_config=config/carmen.toml maps_merge former latter intel || cat "$work/merge.txt" >&2
  row "intel, two halves" "off the whole log's trajectory, RMSE" "$(maps_error intel "$work/whole.tum" || true)" "<=" 0.1 m
}

# Logs mapped with and without --refine; what is measured against a truth is their final poses.
maps_replay() { # maps_replay LOG [OPTION...]: trajectory in $work/refined.tum
  local log=$1
  shift
  "$bin/slam-replay" --log "$log" --trajectory "$work/refined.tum" --refine "$@" >/dev/null 2>&1
}
maps_simulated() { # maps_simulated SCENE SEED OPTION...: ATE of one drive [m]
  "$bin/slam-sim" --no-depth --scene "$1" --seed "$2" "${@:3}" --log "$work/refine.lcm" --truth "$work/refine.true" >/dev/null
  maps_replay "$work/refine.lcm" --config config/sim.toml --set lidar.driver="'lcm'" --set base.driver="'lcm'" --set imu.driver="'lcm'"
  "$bin/slam-eval" ate "$work/refined.tum" "$work/refine.true" --json >"$work/ate.json"
  maps_value rmse_m "$work/ate.json"
}
maps_refined() {
  local seeds=10 seed errors=()
  [ -z "$short" ] || seeds=2
  if ! missing "$data/intel/intel.relations" "intel, refined"; then
    intel_log
    maps_replay "$work/intel.lcm" --config config/carmen.toml
    row "intel, refined" "final poses, translation" "$(relations "$work/refined.tum" translation_m)" "<=" 0.0140 m
  fi
  for seed in $(seq "$seeds"); do errors+=("$(maps_simulated corridor-loop "$seed")"); done
  row "corridor-loop, refined, seeds 1-$seeds" "ATE, mean" \
    "$(printf '%s\n' "${errors[@]}" | awk '{s += $1} END {printf "%.4f", s / NR}')" "<=" 0.015 m
  [ -z "$short" ] || return 0
  row "streets, two hours, refined" ATE \
    "$(maps_simulated streets 1 --with blocks=24 --with beams=180 --with turn-rate=5 --seconds 7200)" "<=" 0.4 m
}

# Which of five floors of a home, one above the other: the same walls, other furniture. slamd goes on in the map of the
# first one; each floor is driven again, with other noise.
maps_floors() {
  local floors=5 places=20 floor right=0 wrong=0 out=$work/floors r w
  local sensors=(--config config/sim.toml --set lidar.driver="'lcm'" --set base.driver="'lcm'" --set imu.driver="'lcm'")
  [ -z "$short" ] || places=4
  mkdir -p "$out"
  for floor in $(seq "$floors"); do
    "$bin/slam-sim" --no-depth --scene homes --seed 1 --with "floor=$floor" --log "$work/floor.lcm" >/dev/null
    "$bin/slam-replay" "${sensors[@]}" --log "$work/floor.lcm" --save-map "$out/floor-$floor" >/dev/null 2>&1
  done
  for floor in $(seq "$floors"); do
    "$bin/slam-sim" --no-depth --scene homes --seed 9 --with "floor=$floor" --log "$work/floor.lcm" >/dev/null
    "$bin/slam-benchmark" floors "${sensors[@]}" --floor "floor-$floor" --begin-in floor-1 --places "$places" --seconds 20 \
      "$work/floor.lcm" "$out" >"$work/floor.txt"
    echo "floor $floor: $(tail -1 "$work/floor.txt")" >&2
    read -r r w <<<"$(sed -nE 's/.*: ([0-9]+) right, ([0-9]+) wrong.*/\1 \2/p' "$work/floor.txt")"
    right=$((right + r)) wrong=$((wrong + w))
  done
  row "which of 5 floors, other furniture" "right within 20 s, of $((floors * places))" "$right" ">=" "$((floors * places * 95 / 100))"
  row "which of 5 floors, other furniture" wrong "$wrong" "<=" 0
}

# lift_maps FOLDER FLOORS: maps of so many floors of one home, whose landings look alike
lift_maps() {
  local floor
  for floor in $(seq "$2"); do
    "$bin/slam-sim" --no-depth --scene homes --seed 1 --with "floor=$floor" --with lift=0 --log "$work/lift.lcm" >/dev/null
    "$bin/slam-replay" "${lift_sensors[@]}" --log "$work/lift.lcm" --save-map "$1/floor-$floor" >/dev/null 2>&1
  done
}

# lift_drive LOG SEED FROM TO: a drive in that home that takes a lift. Prints when it leaves it [s]
lift_drive() {
  "$bin/slam-sim" --no-depth --scene homes --seed $((1 + 8 * $2)) --with "floor=$3" --with "lift=$4" \
    --log "$1" --waypoints "$work/lift.tum" >/dev/null
  awk 'NR == 3 {print $1 - 1700000000}' "$work/lift.tum"
}
lift_sensors=(--config config/sim.toml --set "lidar.driver='lcm'" --set "base.driver='lcm'" --set "imu.driver='lcm'")

# Drives with a lift between these floors, whose landings look alike, and without one. slamd goes on in the map of the floor
# where the drive begins.
maps_lifts() {
  local floors=5 drives=20 seed from to departs out=$work/lifts right=0 wrong=0 seconds=()
  [ -z "$short" ] || drives=4
  mkdir -p "$out"
  lift_maps "$out" "$floors"
  for seed in $(seq "$drives"); do
    from=$((1 + seed % floors)) to=$((1 + (seed + 1 + seed / floors) % floors)) # every fifth comes back to where it was
    departs=$(lift_drive "$work/lift.lcm" "$seed" "$from" "$to")
    "$bin/slam-benchmark" lift "${lift_sensors[@]}" --begin-in "floor-$from" --to "floor-$to" --departs "$departs" \
      "$work/lift.lcm" "$out" | tee "$work/lift.txt" >&2
    grep -q "known_s=inf" "$work/lift.txt" || {
      right=$((right + 1))
      seconds+=("$(sed -nE 's/.*known_s=([0-9.]+).*/\1/p' "$work/lift.txt")")
    }
    awk -F'[ =]' '{for (i = 1; i < NF; i += 2) if ($i == "wrong_and_sure_s") exit $(i + 1) == 0}' "$work/lift.txt" &&
      wrong=$((wrong + 1)) || true
  done
  row "a lift between 5 floors with one landing" "right floor, of $drives" "$right" ">=" "$((drives * 95 / 100))"
  row "a lift between 5 floors with one landing" "wrong and sure" "$wrong" "<=" 0
  row "a lift between 5 floors with one landing" "known after the departure, mean" \
    "$(printf '%s\n' "${seconds[@]}" | awk '{s += $1} END {printf "%.1f", s / NR}')" "<=" 15 s
}

# Drives without a lift, in maps of several floors: robots that stand among people, and what else the trust situations have.
maps_lift_alarms() { # after maps_lifts
  local seeds=5 scene with seed alarms=0 drives=0 out=$work/lifts
  [ -z "$short" ] || seeds=1
  while IFS='|' read -r scene with; do
    [ -d "$out/$scene" ] || {
      "$bin/slam-sim" --no-depth --scene "$scene" --seed 1 --log "$work/lift.lcm" >/dev/null
      "$bin/slam-replay" "${lift_sensors[@]}" --log "$work/lift.lcm" --save-map "$out/$scene" >/dev/null 2>&1
    }
    for seed in $(seq 9 8 $((8 * seeds + 1))); do # of homes: the same one
      # shellcheck disable=SC2086 # words of --with
      "$bin/slam-sim" --no-depth --scene "$scene" --seed "$seed" ${with:+$(printf -- '--with %s ' $with)} --log "$work/lift.lcm" >/dev/null
      "$bin/slam-benchmark" lift "${lift_sensors[@]}" --begin-in "$scene" --floors "$scene floor-1" "$work/lift.lcm" "$out" >"$work/lift.txt"
      echo "$scene $with, seed $seed: $(cat "$work/lift.txt")" >&2
      alarms=$((alarms + $(sed -nE 's/.*doubts=([0-9]+).*/\1/p' "$work/lift.txt"))) drives=$((drives + 1))
    done
  done <<'END'
people|
open-door|
home|walkers=4
home|follower=swaying
home|cart=towed
home|casing=165,195,0.25
home|field-of-view=58 range-max=4
hall|walkers=4
hall|range-max=8 no-return=max
homes|walkers=4
homes|lift=0 walkers=2
END
  row "$drives drives without a lift, people and others about" "taken for one" "$alarms" "<=" 0
}

maps() {
  mkdir -p "$work/maps"
  echo "| case | figure | value | target | |"
  echo "|---|---|---|---|---|"
  maps_homes
  maps_lookalikes
  maps_others
  maps_orders
  maps_intel
  maps_refined
  maps_floors
  maps_lifts
  maps_lift_alarms
}

# SPDX-License-Identifier: BSD-3-Clause
# For tools/benchmark, which sources it: what is each rule of the front end worth? Drives are made here; slam-benchmark ablate
# replays them without one rule after another. $bin, $data, $short, $work and simulate are its own; $ablate_rules is an option.
# shellcheck shell=bash disable=SC2154 # set by tools/benchmark
ablate_sim_settings="lidar.driver='lcm' base.driver='lcm' imu.driver='lcm'"

ablate_case() { # ablate_case NAME MEASURE CONFIG LOG TRUTH FAULT SETTINGS
  printf '%s | %s | config/%s.toml | %s | %s | %s | %s\n' "$@"
}
ablate_disturbed() { # ablate_disturbed LOG NAME OPTION...: a disturbed copy, NAME.lcm in $work
  "$bin/slam-convert" disturb "${@:3}" "$1" "$work/$2.lcm" >/dev/null
}

ablate_recorded() {
  local seed runs=3 relations=$data/intel/intel.relations
  [ -z "$short" ] || runs=1
  if [ -e "$data/intel/intel.clf.gz" ]; then
    intel_log
    ablate_case intel relations carmen "$work/intel.lcm" "$relations" - ""
    ablate_case "intel without odometry" relations carmen "$work/intel.lcm" "$relations" - "base.driver='none'"
    for seed in $(seq "$runs"); do
      ablate_disturbed "$work/intel.lcm" "jumps-$seed" --jumps 10 --jump-translation 0.5 --jump-rotation 0.7854 --seed "$seed"
      ablate_case "intel jumps $seed" relations carmen "$work/jumps-$seed.lcm" "$relations" - ""
      ablate_disturbed "$work/intel.lcm" "noise-$seed" --noise 0.4 --seed "$seed"
      ablate_case "intel noise $seed" relations carmen "$work/noise-$seed.lcm" "$relations" - ""
    done
  fi
  if [ -e "$data/mbot/maebot_convex.lcm.gz" ]; then
    "$bin/slam-convert" mbot "$data/mbot/maebot_convex.lcm.gz" "$work/m.lcm" --truth "$work/course.tum" >/dev/null
    ablate_case maebot course maebot "$work/m.lcm" "$work/course.tum" - ""
  fi
  if [ -e "$data/unsw_ugv/scans.csv.gz" ]; then
    "$bin/slam-convert" csv --scans "$data/unsw_ugv/scans.csv.gz" --speed "$data/unsw_ugv/speed.csv.gz" \
      --imu "$data/unsw_ugv/imu.csv.gz" "$work/u.lcm" >/dev/null
    ablate_case unsw overlay unsw_ugv "$work/u.lcm" - - ""
  fi
  if [ -e "$data/mines/exp1.dat.gz" ]; then
    "$bin/slam-convert" mines "$data/mines/exp1.dat.gz" "$work/mines.lcm" >/dev/null
    ablate_case mines none mines "$work/mines.lcm" - - ""
  fi
  if [ -z "$short" ] && [ -e "$data/wean/robotdata2.log.gz" ]; then
    "$bin/slam-convert" wean "$data/wean/robotdata2.log.gz" "$work/w.lcm" >/dev/null
    "$bin/slam-convert" wean-map "$data/wean/wean.dat.gz" "$work/wean"
    ablate_case wean cold-starts wean "$work/w.lcm" "$work/wean.yaml" - ""
  fi
}

# The same drives as the rows of accuracy.
ablate_floors() {
  local seed runs=3 log
  [ -z "$short" ] || runs=1
  for seed in $(seq "$runs"); do
    simulate corridor-loop "$seed"
    simulate office-floor "$seed" 240
    log=out/benchmark/corridor-loop-$seed
    ablate_case "corridor-loop $seed" truth sim "$log.lcm" "$log.tum" - "$ablate_sim_settings"
    ablate_disturbed "$log.lcm" "long-$seed" --distance-scale 0.2
    ablate_case "corridor-loop $seed, wheels 20 % too long" truth sim "$work/long-$seed.lcm" "$log.tum" - "$ablate_sim_settings"
    ablate_disturbed "$log.lcm" "leaps-$seed" --jumps 10 --jump-translation 0.5 --jump-rotation 0.7854 --seed "$seed"
    ablate_case "corridor-loop $seed, jumps" truth sim "$work/leaps-$seed.lcm" "$log.tum" - "$ablate_sim_settings"
    log=out/benchmark/office-floor-$seed-240s
    ablate_case "office-floor $seed, 6 m" truth sim "$log.lcm" "$log.tum" - \
      "$ablate_sim_settings imu.driver='none' lidar.range_max=6"
  done
}

# What the field does, and nobody has recorded with truth: KIND of slam-sim | scene | seconds | measure | settings
ablate_situations() {
  cat <<END
kidnapped=60|home|120|known|
kidnapped=60,covered|homes|150|known|
kidnapped=60,covered|hall|150|known|
walkers=4|hall|120|truth|
walkers=4|corridor-60|150|truth|
follower=swaying|home|120|truth|
wheels-away=40,52|home|100|truth|
wheels-away=40,52|corridor-60|150|truth|
gyro-offset=0.1|home|60|truth|
beams=20|home|100|truth|
second-lidar=5|home|100|truth|
range-noise=0.3|home|100|truth|
beams=60|corridor-30|150|truth|
range-max=8|corridor-60|150|truth|
start=moving|home|60|course|
turn-rate=2|home|120|truth|base.driver='none' imu.driver='none'
turn-rate=1|office-floor|240|truth|base.driver='none' imu.driver='none'
END
}
ablate_simulated() {
  local seed runs=2 kind scene seconds measure settings fault log
  [ -z "$short" ] || runs=1
  mkdir -p out/benchmark
  for seed in $(seq "$runs"); do
    while IFS='|' read -r kind scene seconds measure settings; do
      log=out/benchmark/$scene-$kind-$seed-${seconds}s
      [ "$log.lcm" -nt "$bin/slam-sim" ] || "$bin/slam-sim" --no-depth --scene "$scene" --seed "$seed" --seconds "$seconds" \
        --with "$kind" --log "$log.lcm" --truth "$log.tum" >/dev/null
      ablate_case "$scene $seed, $kind${settings:+, no wheels}" "$measure" sim "$log.lcm" "$log.tum" - \
        "$ablate_sim_settings $settings"
    done < <(ablate_situations)
    simulate home "$seed" 60
    log=out/benchmark/home-$seed-60s
    for fault in far-ahead set-back imu-set-back out-of-order copies stuck late wheel-jitter; do
      ablate_case "home $seed, $fault" truth sim "$log.lcm" "$log.tum" "$fault" "$ablate_sim_settings"
    done
  done
}

ablate() {
  local rule
  local -a rules=()
  { ablate_recorded; ablate_floors; ablate_simulated; } >"$work/cases"
  for rule in $ablate_rules; do rules+=(--rule "$rule"); done
  "$bin/slam-benchmark" ablate "${rules[@]}" "$work/cases"
}

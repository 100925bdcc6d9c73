# SPDX-License-Identifier: BSD-3-Clause
# For tools/benchmark, which sources it: what is each rule of the front end worth? Drives are made here; slam-benchmark ablate
# replays them without one rule after another. $bin, $data, $short, $work and simulate are its own; $ablate_rules and $trust_seeds
# are options.
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

# What the field does, and nobody has recorded with truth: RULES | KIND ... of slam-sim | scene | seconds | measure | fault |
# settings. RULES: first words of the names of those that it is a drive for; - none.
ablate_situations() {
  cat <<END
22b 26|kidnapped=60|home|120|known|-|
24b,|kidnapped=60,covered|homes|150|known|-|
24d|kidnapped=60,covered|hall|150|known|-|
10a 10c|walkers=4|hall|120|truth|-|
10a 22|walkers=4|corridor-60|150|truth|-|
-|follower=swaying|home|120|truth|-|
14b 26a|wheels-away=40,52|home|100|truth|-|
8 10 10b 20a|wheels-away=40,52|corridor-60|150|truth|-|
14 14a|gyro-offset=0.1|home|60|truth|-|
9 21a|beams=20|home|100|truth|-|
28c|second-lidar=5|home|100|truth|-|
6b|range-noise=0.3|home|100|truth|-|
9 20a|beams=60|corridor-30|150|truth|-|
-|field-of-view=58 range-max=4|home|100|truth|-|
20b|range-max=8|corridor-60|150|truth|-|
-|start=moving|home|60|course|-|
19a 20b 27a|turn-rate=2|home|120|truth|-|base.driver='none' imu.driver='none'
18 27 27a|turn-rate=1|office-floor|240|truth|-|base.driver='none' imu.driver='none'
1||home|60|truth|far-ahead|
1a||home|60|truth|scans-ahead|
1a||hall|120|truth|scans-ahead|
1a||home|60|truth|wheels-ahead|
2,||home|60|truth|set-back|
2,||home|60|truth|imu-set-back|
2||home|60|truth|out-of-order|
5||home|60|truth|copies|
4||home|60|truth|stuck|
-||home|60|truth|late|
16a 16b||home|60|truth|wheel-jitter|
3a||home|100|truth|-|lidar.time_offset=0.19
3a||hall|120|truth|-|lidar.time_offset=0.19
3a||home|100|truth|-|lidar.time_offset=-0.12
6a 6f|casing=150,210,0.35|hall|120|truth|-|
6a|cart=towed|home|100|truth|-|
6c|range-max=8 claimed-range-max=30 no-return=10|hall|120|truth|-|
6d|turn-rate=5 beam-times=none|home|100|truth|-|
6e|lift=2|homes||lift|-|
14c|wheels-dead=40,70|hall|120|truth|-|
14c 32|wheels-dead=40,70|corridor-60|150|truth|-|
33|gyro-unit=deg|home|100|truth|-|
33|gyro-axis=down|home|100|truth|-|
33|gyro-offset=1|home|100|truth|-|
30 30a|lidar-turned=4|home|100|truth|-|
30 30a|lidar-turned=4|hall|120|truth|-|
30 30a|lidar-ahead=0.05|home|100|truth|-|
30a|lidar-turned=0.5|hall|120|truth|-|
31|range-bias=0.03|hall|120|truth|-|
31|bearing-scale=0.004|hall|120|truth|-|
END
}

# ablate_lift SEED FLOOR: a drive that takes a lift to that floor of a home, in the maps of three floors with one landing
ablate_lift() {
  local seed=$1 to=$2 from=1 departs maps=$work/lift-maps log=$work/lift-$1.lcm
  [ -d "$maps" ] || lift_maps "$maps" 3
  departs=$(lift_drive "$log" "$seed" "$from" "$to")
  ablate_case "homes $seed, lift" lift sim "$log" "$maps floor-$from floor-$to $departs" - "$ablate_sim_settings"
}
ablate_situation() { # ablate_situation SEED KINDS SCENE SECONDS MEASURE FAULT SETTINGS
  local seed=$1 kinds=$2 scene=$3 seconds=$4 measure=$5 fault=$6 settings=$7 kind log words with=()
  [ "$measure" != lift ] || { ablate_lift "$seed" "${kinds#lift=}"; return; }
  for kind in $kinds; do with+=(--with "$kind"); done
  log=out/benchmark/$scene-${kinds:+${kinds// /-}-}$seed-${seconds}s
  [ "$log.lcm" -nt "$bin/slam-sim" ] || "$bin/slam-sim" --no-depth --scene "$scene" --seed "$seed" --seconds "$seconds" \
    "${with[@]}" --log "$log.lcm" --truth "$log.tum" >/dev/null
  words="$kinds ${fault#-} ${settings//base.driver=\'none\' imu.driver=\'none\'/no wheels}"
  words=$(xargs <<<"${words//\'/}")
  ablate_case "$scene $seed${words:+, $words}" "$measure" sim "$log.lcm" "$log.tum" "$fault" "$ablate_sim_settings $settings"
}
ablate_simulated() {
  local seed runs=2 rules kinds scene seconds measure fault settings
  [ -z "$short" ] || runs=1
  mkdir -p out/benchmark
  for seed in $(seq "$runs"); do
    while IFS='|' read -r rules kinds scene seconds measure fault settings; do
      ablate_situation "$seed" "$kinds" "$scene" "$seconds" "$measure" "$fault" "$settings"
    done < <(ablate_situations)
  done
}

# Each rule on the drives that it is there for, in the mean over their seeds.
rules() {
  local seed own rule kinds scene seconds measure fault settings shown=0
  mkdir -p out/benchmark
  while IFS='|' read -r own kinds scene seconds measure fault settings; do
    local -a rules=()
    for rule in $own; do
      [ "$rule" = - ] || [[ -n $ablate_rules && " $ablate_rules " != *" $rule "* ]] || rules+=(--rule "$rule")
    done
    [ ${#rules[@]} -gt 0 ] || continue
    for seed in $(seq "$trust_seeds"); do
      ablate_situation "$seed" "$kinds" "$scene" "$seconds" "$measure" "$fault" "$settings"
    done >"$work/cases"
    "$bin/slam-benchmark" ablate --means "${rules[@]}" "$work/cases" >"$work/means"
    tail -n "+$((shown + 1))" "$work/means"
    shown=2
  done < <(ablate_situations)
}

ablate() {
  local rule
  local -a rules=()
  { ablate_recorded; ablate_floors; ablate_simulated; } >"$work/cases"
  for rule in $ablate_rules; do rules+=(--rule "$rule"); done
  "$bin/slam-benchmark" ablate "${rules[@]}" "$work/cases"
}

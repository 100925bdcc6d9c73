# SPDX-License-Identifier: BSD-3-Clause
# For tools/benchmark, which sources it: is a robot that is sure right? Every situation is simulated with truth, replayed, and
# judged by slam-eval trust. $bin, $short and $work are its own; $trust_seeds, $trust_only are options.
# shellcheck shell=bash disable=SC2154,SC2015 # set by tools/benchmark; "failed" is printed whichever step failed
cases=${SLAMD_CASES:-../shared/cases}
trust_cpu=300 # [s] of one replay at most
trust_settings=(--set lidar.driver="'lcm'" --set base.driver="'lcm'" --set imu.driver="'lcm'" --set depth.driver="'none'")

# The situations: number in the list of kinds | what | scene | --with of slam-sim | --set of slam-replay. A number of 0 is an
# ordinary drive, K a robot that is carried away at 60 s.
trust_situations() {
  local laps=20 street_seconds=7200
  [ -z "$short" ] || laps=4 street_seconds=600
  cat <<END
0|home|home||
0|eight homes|homes||
0|hall|hall||
0|corridor, 60 m|corridor-60||
0|windows and mirrors|home|glass=6 mirrors=2|
0|no-returns as nan|hall|no-return=nan|
1|casing, 30 deg at 0.25 m|home|casing=165,195,0.25|
1|casing, 60 deg at 0.35 m|hall|casing=150,210,0.35|
1|four posts of 18 deg at 0.2 m|home|posts=4,18,0.2|
1|floor line at 1.5 m|home|floor-line=1.5|
1|cart, towed|home|cart=towed|
2|pushed, rigid legs|home|follower=rigid|
2|pushed, swaying legs|home|follower=swaying|
2|pushed, swaying legs|hall|follower=swaying|
2|four who walk along|home|walkers=4|
2|four who walk along|hall|walkers=4|
3|driven off before the first standstill|home|start=moving|
3|gyro offset of 0.1 rad/s|home|gyro-offset=0.1|
3|wheels away for 12 s|home|wheels-away=40,52|
3|wheels' counters stand for 30 s|hall|wheels-dead=40,70|
3|wheels' counters stand for 30 s|corridor-60|wheels-dead=40,70|
4|localise, furniture moved|homes|furniture-moved=1|mode='localise'
4|view of 58 deg to 4 m|home|field-of-view=58 range-max=4|
4|1080 beams in 30 m of corridor|corridor-30|beams=1080|
5|no beam times at 5 Hz|home|turn-rate=5 beam-times=none|
6|no-returns at the reach of 8 m|hall|range-max=8 no-return=max|
6|no-returns at the reach of 8 m|corridor-60|range-max=8 no-return=max|
6|no-returns as 10 m of 30|hall|range-max=8 claimed-range-max=30 no-return=10|
6|no-returns at the rim of 8 m|hall|range-max=8 claimed-range-max=80 no-return=8.183,8.187,8.191|
9|24 x 24 streets, $street_seconds s|streets|blocks=24 beams=180 turn-rate=5|
10|carried away covered in a hall, 2 Hz|hall|turn-rate=2 laps=2 kidnapped=60,covered|
11|540 beams over 180 deg to 5.6 m|corridor-30|beams=540 field-of-view=180 range-max=5.6|
11|361 beams over 180 deg to 5.6 m|corridor-30|beams=361 field-of-view=180 range-max=5.6|
12|noise of 2 % of the range|home|range-noise-per-metre=0.02|
12|noise of 2.5 % of the range|homes|range-noise-per-metre=0.025|
13|gyro in deg/s|home|gyro-unit=deg|
13|gyro upside down|home|gyro-axis=down|
13|gyro clipped at 0.5 rad/s|home|gyro-clip=0.5|
13|gyro offset of 1 rad/s|home|gyro-offset=1|
13|gyro in steps of 1 deg/s|home|gyro-step=1|
14|20 beams|home|beams=20|
14|60 beams|corridor-60|beams=60|
14|view of 58 deg to 4 m, noise of 1 %|home|field-of-view=58 range-max=4 range-noise-per-metre=0.01|
14|3.5 m at 5 Hz|home|range-max=3.5 turn-rate=5|
14|range noise of 0.05 m|home|range-noise=0.05|
14|range noise of 0.1 m|home|range-noise=0.1|
14|range noise of 0.3 m|home|range-noise=0.3|
14|two lidars, one turned by 5 deg|home|second-lidar=5|
15|$laps laps|home|laps=$laps|
15|$laps laps, three people|home|laps=$laps walkers=3|
K|carried away, lidar open|home|kidnapped=60|
K|carried away, lidar covered|home|kidnapped=60,covered|
K|carried away, lidar open|hall|kidnapped=60|
K|carried away, lidar covered|homes|kidnapped=60,covered|
END
}

trust_value() { sed -nE "s/.*\"$1\": ([0-9.]+|null).*/\\1/p" "$2"; } # trust_value KEY FILE

trust_sim() { # trust_sim SCENE SEED OUT [option of slam-sim ...]: OUT.lcm and OUT.tum
  local scene=$1 seed=$2 out=$3
  shift 3
  "$bin/slam-sim" --no-depth --scene "$scene" --seed "$seed" "$@" --log "$out.lcm" --truth "$out.tum" >/dev/null
}
trust_replay() { # trust_replay CONFIG LOG OUT [option of slam-replay ...]: OUT.csv .causal .odometry .stats
  local config=$1 log=$2 out=$3
  shift 3
  (ulimit -t "$trust_cpu" && "$bin/slam-replay" --config "$config" "${trust_settings[@]}" "$@" --log "$log" \
    --estimates "$out.csv" --causal "$out.causal" --odometry "$out.odometry" --stats "$out.stats") >/dev/null 2>"$out.words"
}

# One line of figures of a replay: RMSE, sure and wrong, needlessly lost, noticed, RMSE of the odometry, CPU time, memory.
trust_judge() { # trust_judge OUT TRUTH ALIGN [option of slam-eval trust ...]; ALIGN: --no-align or nothing
  local out=$1 truth=$2 align=$3
  shift 3
  "$bin/slam-eval" trust "$out.csv" "$truth" --json ${align:+"$align"} "$@" >"$out.trust"
  "$bin/slam-eval" ate "$out.causal" "$truth" --json ${align:+"$align"} >"$out.ate"
  "$bin/slam-eval" ate "$out.odometry" "$truth" --json ${align:+"$align"} >"$out.drift"
  tr -d '\n' <"$out.stats" >"$out.one"
  echo "$(trust_value rmse_m "$out.ate") $(trust_value sure_and_wrong "$out.trust")" \
    "$(trust_value needlessly_lost "$out.trust") $(trust_value noticed_s "$out.trust")" \
    "$(trust_value rmse_m "$out.drift") $(trust_value cpu_s "$out.one") $(trust_value peak_rss_mb "$out.one")"
}

# trust_row NUMBER WHAT SCENE: a row of the figures on stdin, a line a run
trust_row() {
  awk -v number="$1" -v what="$2" -v scene="$3" '
    $1 == "failed" {++failed; next}
    {++n; rmse += $1; wrong += $2; if ($2 > worst) worst = $2; lost += $3; drift += $5
     if ($6 > cpu) cpu = $6; if ($7 > memory) memory = $7
     if ($4 != "null") {noticed += $4; ++seen; soon += $4 <= 2}}
    END {
      kind = number == "0" ? "" : number == "K" ? "kidnapped" : number
      if (!n) {printf "| %s | %s | %s | failed |  |  |  |  |  |  |  |\n", kind, what, scene; exit}
      when = ""
      if (number == "K" || number == "10") when = (seen ? sprintf("%.1f", noticed / seen) : "never") sprintf(", %d of %d", soon, n)
      printf "| %s | %s | %s%s | %.4f | %.4f | %.2f %% | %.2f %% | %.2f %% | %s | %.1f | %.0f |\n", kind, what, scene,
        failed ? sprintf(", %d of %d not finished", failed, n + failed) : "", rmse / n, drift / n,
        100 * wrong / n, 100 * worst, 100 * lost / n, when, cpu, memory
    }'
}

trust_run() { # trust_run SEED SCENE KINDS SETTING: one line of figures
  local seed=$1 scene=$2 kinds=$3 setting=$4 kind align=--no-align
  local -a sim=() replay=() judge=()
  for kind in $kinds; do
    sim+=(--with "$kind")
    case $kind in
      kidnapped=*) judge=(--kidnapped $((60 + 3))) ;; # where it is put down
      start=moving) align='' ;;
    esac
  done
  [ "$scene" != streets ] || sim+=(--seconds "$([ -n "$short" ] && echo 600 || echo 7200)")
  rm -f "$work"/trust/run.*
  trust_sim "$scene" "$seed" "$work/trust/run" "${sim[@]}" || { echo failed; return; }
  if [ -n "$setting" ]; then # first as things stood: that drive's map is the one to be found in
    trust_sim "$scene" "$seed" "$work/trust/before"
    trust_replay config/sim.toml "$work/trust/before.lcm" "$work/trust/before" --save-map "$work/trust/maps/before" ||
      { echo failed; return; }
    replay=(--load-map "$work/trust/maps/before" --set "$setting")
  fi
  trust_replay config/sim.toml "$work/trust/run.lcm" "$work/trust/run" "${replay[@]}" || { echo failed; return; }
  trust_judge "$work/trust/run" "$work/trust/run.tum" "$align" "${judge[@]}" || echo failed
}

# Small recorded inputs, whose configuration is all default.
trust_recorded() { # trust_recorded NUMBER NAME WHAT
  missing "$cases/$2.lcm.gz" "$2" && return
  { trust_replay config/slamd.toml "$cases/$2.lcm.gz" "$work/trust/run" &&
    trust_judge "$work/trust/run" "$cases/$2.truth.tum" '' || echo failed; } | trust_row "$1" "$3" "$2"
}

trust_all_recorded() {
  trust_recorded 1 c_self "casing over 30 deg"
  trust_recorded 3 c_odo2 "driven off before the first standstill"
  trust_recorded 3 c_bias2 "gyro offset of 0.1 rad/s"
  trust_recorded 5 c_spin "no beam times at 5 Hz, spinning"
}

# Look-alikes after a gap: the same log mapped with the wheels believed over it is the reference.
trust_aces() {
  local log=$cases/aces_raw_720s.clf.gz out=$work/trust/aces
  missing "$log" "8, look-alikes after a gap" && return
  "$bin/slam-convert" carmen "$log" "$out.lcm" >/dev/null
  { trust_replay config/carmen.toml "$out.lcm" "$out.reference" --set imu.driver="'none'" \
      --set localisation.lost_position_sigma=10 &&
    trust_replay config/carmen.toml "$out.lcm" "$out" --set imu.driver="'none'" &&
    trust_judge "$out" "$out.reference.causal" '' || echo failed; } |
    trust_row 8 "look-alikes after a gap of 27 s" "aces, against its reference"
}

# Homes in each other's maps: a robot there is to stay lost.
trust_houses() {
  local homes=8 here map believed=0 others=0 own=0 share
  [ -z "$short" ] || homes=3
  mkdir -p "$work/trust/houses"
  for here in $(seq "$homes"); do
    trust_sim homes "$here" "$work/trust/houses/$here"
    trust_replay config/sim.toml "$work/trust/houses/$here.lcm" "$work/trust/run" --save-map "$work/trust/houses/map-$here"
    trust_sim homes $((here + 8)) "$work/trust/houses/$here" # other errors, of which the map knows nothing
  done
  for here in $(seq "$homes"); do
    for map in $(seq "$homes"); do
      trust_replay config/sim.toml "$work/trust/houses/$here.lcm" "$work/trust/run" \
        --load-map "$work/trust/houses/map-$map" --set mode="'localise'" || { echo "failed" >&2; continue; }
      share=$(awk -F, 'NR == 1 {for (i = 1; i <= NF; ++i) if ($i == "state") s = i; next}
        {++n; if ($s == "localised") ++l} END {print (l > n / 100 ? 1 : 0)}' "$work/trust/run.csv")
      if [ "$here" -ne "$map" ]; then
        others=$((others + 1)) believed=$((believed + share))
      elif [ "$share" -eq 1 ] && trust_judge "$work/trust/run" "$work/trust/houses/$here.tum" --no-align |
        awk '{exit $2 > 0.05}'; then
        own=$((own + 1))
      fi
    done
  done
  row "7, homes in the maps of others, mode localise" "believed, of $others" "$believed" "<=" 0
  row "7, homes in their own maps, mode localise" "found and right, of $homes" "$own" ">=" "$homes"
}

# NEES of runs of a minute: the mean over the runs of each one's mean over its scans. Those of one run hang together, so it
# counts as one sample of three degrees of freedom (95 %, Wilson and Hilferty).
trust_nees() {
  local runs=100 scene seed
  [ -z "$short" ] || runs=10
  echo
  echo "| NEES, 3 is right | runs of 60 s | mean | 95 % bounds | |"
  echo "|---|---|---|---|---|"
  for scene in corridor-30 hall meeting-room; do
    for seed in $(seq "$runs"); do
      trust_sim "$scene" "$seed" "$work/trust/run" --seconds 60
      trust_replay config/sim.toml "$work/trust/run.lcm" "$work/trust/run"
      "$bin/slam-eval" trust "$work/trust/run.csv" "$work/trust/run.tum" --json --no-align >"$work/trust/run.trust"
      trust_value nees "$work/trust/run.trust"
    done | awk -v scene="$scene" '
      function quantile(k, z) {h = 2 / (9 * k); return k * (1 - h + z * sqrt(h)) ^ 3}
      {sum += $1; ++n}
      END {low = quantile(3 * n, -1.96) / n; high = quantile(3 * n, 1.96) / n; mean = sum / n
        printf "| %s | %d | %.2f | %.2f to %.2f | %s |\n", scene, n, mean, low, high,
          (mean >= low && mean <= high ? "met" : "**missed**")}'
  done
}

trust() {
  local number what scene kinds setting seed
  mkdir -p "$work/trust/maps"
  {
    echo "| # | situation | where | RMSE [m] | odometry's [m] | sure and wrong | worst seed | needlessly lost |" \
      "noticed [s], of runs within 2 s | CPU, most [s] | memory, most [MB] |"
    echo "|---|---|---|---|---|---|---|---|---|---|---|"
    while IFS='|' read -r number what scene kinds setting; do
      ! trust_asked "$number" ||
        for seed in $(seq "$trust_seeds"); do trust_run "$seed" "$scene" "$kinds" "$setting"; done |
        trust_row "$number" "$what" "$scene"
    done < <(trust_situations)
    ! trust_asked recorded || trust_all_recorded
    ! trust_asked 8 || trust_aces
  } | tee "$work/trust/table"
  ! trust_asked nees || trust_nees
  {
    ! trust_asked 7 || trust_houses
    trust_totals <"$work/trust/table"
  } >"$work/trust/cases"
  [ -s "$work/trust/cases" ] || return 0
  echo
  echo "| case | figure | value | target | |"
  echo "|---|---|---|---|---|"
  cat "$work/trust/cases"
}
trust_asked() { [ -z "$trust_only" ] || [[ " $trust_only " == *" $1 "* ]]; } # trust_asked NUMBER|recorded|nees

# trust_totals <TABLE: over the situations of a table as trust_row writes it, ordinary drives left out
trust_totals() {
  local of wrong worst_wrong lost worst_lost kidnapped soon
  of="all situations, $(seeds "$trust_seeds")"
  IFS='|' read -r wrong worst_wrong lost worst_lost kidnapped soon < <(awk -F' *[|] *' '
    NR < 3 || $2 == "" || $5 == "failed" || $2 ~ /skipped/ {next}
    {++n; w += $7; if ($7 + 0 > ww) ww = $7 + 0; l += $9; if ($9 + 0 > wl) wl = $9 + 0}
    $2 == "kidnapped" {split($10, k, /, | of /); soon += k[2]; runs += k[3]}
    END {if (n) printf "%.2f|%.2f|%.2f|%.2f|%d|%s\n", w / n, ww, l / n, wl, runs,
      runs ? sprintf("%.0f", 100 * soon / runs) : ""}')
  [ -n "$wrong" ] || return 0
  row "$of" "sure and wrong, mean" "$wrong" "<=" 0.3 %
  row "$of" "sure and wrong, worst situation" "$worst_wrong" "<=" 2 %
  row "$of" "needlessly lost, mean" "$lost" "<=" 0.3 %
  row "$of" "needlessly lost, worst situation" "$worst_lost" "<=" 2 %
  [ "$kidnapped" -eq 0 ] || row "kidnapped, $kidnapped runs" "lost, or right again, within 2 s" "$soon" ">=" 95 %
}

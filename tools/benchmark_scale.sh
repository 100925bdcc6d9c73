# SPDX-License-Identifier: BSD-3-Clause
# For tools/benchmark, which sources it: what does a scan cost when the map is large? Hours of driving through equal
# streets, and what a stored map of them takes to be loaded and searched. $bin, $short and $work are its own.
# shellcheck shell=bash disable=SC2154 # set by tools/benchmark

scale_figure() { sed -nE "s/.*\"$1\": ([0-9.]+).*/\1/p" "$2"; } # scale_figure KEY STATS.json

scale_drive() { # scale_drive SECONDS OUT [OPTION...]: the streets' first SECONDS; OUT.json has the figures, OUT.tum poses
  local seconds=$1 out=$2
  shift 2
  "$bin/slam-sim" --scene streets --with blocks=24 --with beams=180 --with turn-rate=5 --seconds "$seconds" --no-depth \
    --log "$work/streets.lcm" --truth "$work/streets.tum" >/dev/null
  "$bin/slam-replay" --config config/sim.toml --log "$work/streets.lcm" --stats "$out.json" --trajectory "$out.tum" "$@" >/dev/null
}

scale() {
  local minutes durations='10 60 120 240' first='' cpu scans each error off
  [ -z "$short" ] || durations='10 30'
  echo "| streets driven through | keyframes | CPU per scan | times that of 10 minutes | peak memory | RMSE | RMSE without loop closure |"
  echo "|---|---|---|---|---|---|---|"
  for minutes in $durations; do
    scale_drive $((60 * minutes)) "$work/with" || { echo "| $minutes min | failed | | | | | |"; continue; }
    error=$("$bin/slam-eval" ate --no-align "$work/with.tum" "$work/streets.tum" | sed -nE 's/^ATE RMSE \[m\] +//p')
    "$bin/slam-replay" --config config/sim.toml --set loop_closure.enabled=false --log "$work/streets.lcm" \
      --trajectory "$work/without.tum" >/dev/null
    off=$("$bin/slam-eval" ate --no-align "$work/without.tum" "$work/streets.tum" | sed -nE 's/^ATE RMSE \[m\] +//p')
    cpu=$(scale_figure cpu_s "$work/with.json") scans=$(scale_figure scans "$work/with.json")
    each=$(awk -v c="$cpu" -v n="$scans" 'BEGIN {printf "%.0f", 1e6 * c / n}')
    first=${first:-$each}
    awk -v m="$minutes" -v k="$(scale_figure keyframes "$work/with.json")" -v e="$each" -v f="$first" \
      -v p="$(scale_figure peak_rss_mb "$work/with.json")" -v r="$error" -v o="$off" \
      'BEGIN {printf "| %d min | %d | %d us | %.2f | %.0f MB | %.2f m | %.2f m |\n", m, k, e, e / f, p, r, o}'
  done
  scale_stored
}

# The map of the first hour is searched from scratch by the drive's first 20 s.
scale_stored() {
  local minutes=60 begin end
  [ -z "$short" ] || minutes=10
  scale_drive $((60 * minutes)) "$work/stored" --save-map "$work/maps/streets" || { echo "| stored map | failed | | | | | |"; return; }
  scale_drive 20 "$work/none"
  "$bin/slam-replay" --config config/sim.toml --log "$work/streets.lcm" --stats "$work/found.json" \
    --load-map "$work/maps/streets" >/dev/null
  begin=$(scale_figure cpu_s "$work/none.json") end=$(scale_figure cpu_s "$work/found.json")
  echo
  awk -v k="$(scale_figure keyframes "$work/stored.json")" -v s="$(awk -v a="$begin" -v b="$end" 'BEGIN {print b - a}')" \
    -v n="$(scale_figure relocalisation_searches "$work/found.json")" \
    'BEGIN {printf "A stored map of %d keyframes: %.2f s of CPU time to load it, and %d searches in it.\n", k, s, n}'
}

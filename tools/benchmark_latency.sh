# SPDX-License-Identifier: BSD-3-Clause
# For tools/benchmark, which sources it: how long from a scan to its pose? slamd runs live with emulated devices, quiet and
# beside programs that keep every core busy. $bin, $short and $work are its own.
# shellcheck shell=bash disable=SC2154 # set by tools/benchmark

latency_drive() { # latency_drive SECONDS OUT: what slam-eval live reports of a drive through the meeting room
  local sim daemon devices=$work/devices library=$bin/../lib/openni2
  rm -rf "$devices" && mkdir -p "$devices"
  # A device is never late because the computer is busy.
  local ahead=(chrt -f 85)
  "${ahead[@]}" true 2>/dev/null || ahead=()
  "${ahead[@]}" "$bin/slam-sim" --scene meeting-room --seconds "$1" --devices "$devices" --truth "$work/truth.tum" >/dev/null &
  sim=$!
  for _ in $(seq 50); do [ -e "$devices/board" ] && break; sleep 0.1; done
  SLAM_SIM_DEVICES="$devices" LD_LIBRARY_PATH="$library${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" \
    "$bin/slamd" --config config/sim.toml --set "lidar.port='$devices/lidar'" --set "base.port='$devices/board'" \
    --set "output.record='$work/record.lcm'" --set "lcm.url='udpm://239.255.76.67:7$((700 + RANDOM % 200))?ttl=0'" \
    2>"$work/slamd.txt" &
  daemon=$!
  wait "$sim" || true
  kill -TERM "$daemon" && wait "$daemon" || { cat "$work/slamd.txt" >&2; return 1; }
  "$bin/slam-eval" live --record "$work/record.lcm" --truth "$work/truth.tum" >"$2"
}

latency() {
  local seconds=60 load
  [ -z "$short" ] || seconds=20
  for load in quiet "stress-ng on all cores"; do
    local stress=''
    if [ "$load" != quiet ]; then
      command -v stress-ng >/dev/null || { echo "skipped: $load (apt install stress-ng)"; continue; }
      stress-ng --cpu 0 --timeout $((seconds + 30)) >/dev/null 2>&1 &
      stress=$!
    fi
    latency_drive "$seconds" "$work/live.txt"
    [ -z "$stress" ] || { kill "$stress" && wait "$stress"; } 2>/dev/null || true
    echo "| $load | p50 | p99 | worst |"
    echo "|---|---|---|---|"
    grep -E '^\| (scan complete|work on one scan|[a-z]+: tick begins late)' "$work/live.txt"
    sed -nE 's/^\| SLAM \(published live\) \| ([0-9.]+) \| ([0-9.]+) .*/| pose, off the truth: RMSE and worst [m] | \1 | | \2 |/p' "$work/live.txt"
    echo
  done
}

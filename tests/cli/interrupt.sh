#!/usr/bin/env bash
# Ctrl-C ends a long run within a second with exit code 130 and whole files.
set -euo pipefail
palpate=$1 scenes=$2 out=$3
rm -rf "$out"
"$palpate" run "$scenes/cube.toml" --set simulation.duration=2000.0 --out "$out" --quiet &
pid=$!
sleep 2
begin=$(date +%s%N)
kill -INT "$pid"
status=0
wait "$pid" || status=$?
elapsed=$((($(date +%s%N) - begin) / 1000000))
[ "$status" -eq 130 ] || { echo "exit status $status, expected 130"; exit 1; }
limit=1000
[ "${PALPATE_SANITIZED:-0}" = 1 ] && limit=10000
[ "$elapsed" -le "$limit" ] || { echo "took $elapsed ms to stop"; exit 1; }
for file in trace.csv trace.h5 summary.json; do
  [ -s "$out/$file" ] || { echo "$file is missing"; exit 1; }
done
grep -q '"status": "interrupted"' "$out/summary.json"
[ "$(find "$out" -name '*.tmp*' | wc -l)" -eq 0 ]

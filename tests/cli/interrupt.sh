#!/usr/bin/env bash
# Ctrl-C ends a long run with exit code 130 and whole files. The TIMEOUT of CTest ends a run that goes on.
set -euo pipefail
palpate=$1 scenes=$2 out=$3
rm -rf "$out"
"$palpate" run "$scenes/cube.toml" --set simulation.duration=2000.0 --out "$out" --quiet &
pid=$!
until [ -d "$out" ]; do sleep 0.05; done  # signals are handled from here on
sleep 1
kill -INT "$pid"
status=0
wait "$pid" || status=$?
[ "$status" -eq 130 ] || { echo "exit status $status, expected 130"; exit 1; }
for file in trace.csv trace.h5 summary.json; do
  [ -s "$out/$file" ] || { echo "$file is missing"; exit 1; }
done
grep -q '"status": "interrupted"' "$out/summary.json"
[ "$(find "$out" -name '*.tmp*' | wc -l)" -eq 0 ]

# During a refined run: the run itself and the refinements that are finished stay.
"$palpate" run "$scenes/cube.toml" --refine --set simulation.duration=5.0 --out "$out" --quiet &
pid=$!
until grep -q '"status": "ok"' "$out/summary.json"; do sleep 0.05; done
kill -INT "$pid"
status=0
wait "$pid" || status=$?
[ "$status" -eq 130 ] || { echo "exit status $status, expected 130"; exit 1; }
grep -q '"reason": "not finished"' "$out/summary.json"

# A command that has nothing ready in time says so; else its certificate is there.
"$palpate" certify "$scenes/mesh-example/scene.toml" --ordinary --out "$out/certified" --quiet 2>"$out/said" &
pid=$!
until [ -d "$out/certified" ]; do sleep 0.05; done
sleep 0.5
kill -INT "$pid"
status=0
wait "$pid" || status=$?
[ "$status" -eq 130 ] || { echo "exit status $status, expected 130"; exit 1; }
[ -e "$out/certified/certificate.json" ] || grep -q "not ready within 0.7 s are not written" "$out/said"

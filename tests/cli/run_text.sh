#!/usr/bin/env bash
# run_text.sh PROGRAM FIXTURES SCRATCH: what `palpate run` prints, and in which of its forms.
set -euo pipefail
palpate=$1
scenes=$2/scenes
needle=$2/init/needle.toml
out=$3
fail() { echo "$*" >&2; exit 1; }
has() { grep -Eq -- "$1" "$out/said" || fail "no line matches '$1':"$'\n'"$(cat "$out/said")"; }
of_summary() { python3 -c 'import json, sys; print(eval("d" + sys.argv[2], {"d": json.load(open(sys.argv[1]))}))' "$1/summary.json" "$2"; }
rm -rf "$out"
mkdir -p "$out"

# The skin is cut half a second after the needle starts.
short=(--set simulation.duration=0.6)
"$palpate" run "$needle" "${short[@]}" -o "$out/text" >"$out/said"
head -n 1 "$out/said" | grep -q '^ok: 600 ticks' || fail "$(head -n 1 "$out/said")"
has '^  peak force +[0-9.]+ N at [0-9.]+ mm$'
has '^  depth +3 mm$'  # 0.6 s at 5 mm/s
has '^  peak pressure +[0-9.]+ mmHg$'
has '^  events +0 s  contact, skin$'
has '^ +0\.[0-9]+ s  puncture, skin$'
has '^  worst tick +[0-9.]+ ms of its 1 ms \([0-9]+ %\)$'
has '^  trust +error by spacing not estimated; step not estimated; reduced-order model [0-9.]+ %; solver '
tail -n 1 "$out/said" | grep -q "^  next  *open .*report.html, or measure the error: palpate run .* --refine$" || fail "no next step"
force=$(sed -n 's/^  peak force *\([0-9.]*\) N.*/\1/p' "$out/said")
python3 -c 'import sys; sys.exit(abs(float(sys.argv[1]) - float(sys.argv[2])) > 1e-3 * float(sys.argv[2]))' \
  "$force" "$(of_summary "$out/text" '["peak_force_n"]')" || fail "the peak force is not that of summary.json"  # four digits
[ "$(of_summary "$out/text" '["trust"][2]["of"]')" = "reduced-order model" ] || fail "no trust in summary.json"
[ "$(of_summary "$out/text" '["late_ticks"]')" = None ] || fail "late ticks without a clock"

# One line, with warnings or without; more lines; and JSON alone.
"$palpate" run "$needle" "${short[@]}" -q -o "$out/quiet" >"$out/said" 2>"$out/error"
[ "$(wc -l <"$out/said")" -eq 1 ] && [ ! -s "$out/error" ] || fail "-q prints $(cat "$out/said" "$out/error")"
has '^ok: '
"$palpate" run "$needle" "${short[@]}" -v -o "$out/verbose" >"$out/said"
has '^  substeps a tick: 3 '
has '^  solver: '
"$palpate" run "$needle" "${short[@]}" --json -o "$out/json" >"$out/said" 2>"$out/error"
cmp "$out/said" "$out/json/summary.json" || fail "--json is not summary.json"

# Results that depend on the spacing are told: cells that nearly close, and what a refined run shows.
cat >"$out/gel.toml" <<'GEL'
[simulation]
duration = 0.8
step = 5e-3
solver_tolerance = 1e-4
[tissue]
source = "lattice"
fixed = ["x-min", "x-max", "y-min", "y-max", "z-max"]
[tissue.lattice]
nodes = [7, 7, 7]
spacing = 0.005
material = "gel"
[[material]]
name = "gel"
youngs_modulus = 10e3
density = 1000.0
retardation_time = 1e-3
cutting_force = 0.09
friction = 0.0
[needle]
[drive]
speed = 0.01
depth = 0.007
GEL
warnings() { of_summary "$1" '["warnings"]'; }
"$palpate" run "$out/gel.toml" --refine -q -o "$out/gel" >/dev/null
warnings "$out/gel" | grep -q 'not converged: with spacing of 2.5 mm .*the puncture of gel is at 6\.[0-9]* mm, not at 5\.' ||
  fail "a puncture that moves by a third is not told: $(warnings "$out/gel")"
"$palpate" run "$out/gel.toml" --refine -q -o "$out/stiff" --set material.0.youngs_modulus=1e6 >/dev/null
! warnings "$out/stiff" | grep -q 'not converged' || fail "a shallow dent is told: $(warnings "$out/stiff")"
! warnings "$out/gel" | grep -q 'of its volume' || fail "cells far from closing are told"
"$palpate" run "$out/gel.toml" -q -o "$out/closing" --set material.0.cutting_force=0.4 --set material.0.poissons_ratio=0.49 \
  --set drive.depth=0.015 --set simulation.duration=1.6 >/dev/null
warnings "$out/closing" | grep -q 'a corner of a cell is left with .* of its volume' ||
  fail "cells that nearly close are not told: $(of_summary "$out/closing" '["smallest_jacobian"]')"

# A terminal obeys no name of a folder.
"$palpate" run "$needle" "${short[@]}" -v -o "$out/$(printf 'red\033[31m')" >"$out/said"
! grep -q "$(printf '\033')" "$out/said" || fail "the name of a folder reaches the terminal as it is"
has 'red\\x1b\[31m/report.html'

# An error is no result, and neither is that of an earlier run.
status=0
"$palpate" run "$needle" --json --set simulation.step=-1.0 -o "$out/json" >"$out/said" 2>/dev/null || status=$?
[ "$status" -eq 2 ] && [ ! -s "$out/said" ] || fail "exit $status, and $(cat "$out/said")"

# The exit code of a run with the wall clock is that of its late ticks, whatever the machine does.
status=0
"$palpate" run "$scenes/falcon-soft.toml" --real-time --packets --set simulation.duration=0.2 -o "$out/paced" >"$out/said" || status=$?
has '^real time: [0-9]+ of 200 ticks .*; 1 kHz is (not )?held$'
[ -s "$out/paced/packets.csv" ] || fail "no packets"
late=$(of_summary "$out/paced" '["late_ticks"]')
[ "$status" -eq "$((late > 0))" ] || fail "exit $status with $late late ticks"
# No processor steps a thousand nodes in a microsecond: 1 MHz.
status=0
"$palpate" run "$scenes/cube.toml" --real-time --set simulation.step=1e-6 --set simulation.duration=1e-4 -o "$out/late" >"$out/said" || status=$?
[ "$status" -eq 1 ] || fail "a late run exits $status"
has '^late: '
has '1000 kHz is not held$'

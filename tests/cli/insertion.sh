#!/usr/bin/env bash
# Insertions into a phantom: import of several files with a preset, and their comparison with a trace.
set -euo pipefail
palpate=$1 source=$2 out=$3
rm -rf "$out"
mkdir -p "$out"
fail() { echo "$1"; exit 1; }

# Insertions with forces scaled by $1 and a dent of $3 mm: advance from 5 mm above the tissue to 20 mm, hold, withdrawal.
insertion() {
  awk -v factor="$1" -v kind="$2" -v dent="$3" 'BEGIN {
    print kind == "rig" ? "time,fz,px,py,pz" : "time_s,tool.depth_m,tool.force_n,tool.layer"
    for (n = 0; n <= 3050; ++n) {
      t = n / 100; path = t < 12.5 ? 2 * t : t < 18 ? 25 : 25 - 2 * (t - 18); d = path - 5
      if (t < 12.5) f = d <= 0 ? 0 : d < dent ? 5 * (d / dent) ^ 1.4 : d < dent + 0.4 ? 5 - 7.5 * (d - dent) : 2 + 0.15 * (d - 12.4)
      else if (t < 18) f = 3.14 * (1 - 0.03 * dent * (1 - exp(-(t - 12.5) / (0.1 * dent))))
      else { low = dent + 3; f = d < 0 ? 0 : d < low ? -1.5 * d / low : -1.5 + (d - low) * 3.39 / (20 - low) }
      if (kind == "rig") printf "%d,%.6f,0,0,%.6f\n", t * 1e6, factor * f + 0.25, path
      else printf "%.6f,%.8f,%.6f,%s\n", t, d * 1e-3, factor * f, (d > 0 ? "skin" : "")
    }
  }'
}
for n in 1 2 3 4; do insertion "0.9$((2 * n))" rig "1$n" >"$out/skin_2_0_2_${n}_x.csv"; done
insertion 0.95 trace 12.5 >"$out/trace.csv"

"$palpate" import "$out"/skin_*.csv --preset needle-insertion-app --out "$out/recordings" >"$out/import.log"
[ "$(ls "$out/recordings")" = "$(for n in 1 2 3 4; do echo "skin_2_0_2_${n}_x.h5"; done)" ] || fail "not four files"
[ "$(grep -c '^measured phantom: no patient$' "$out/import.log")" -eq 4 ] || fail "the kind is not told"
grep -q '^depth as the distance of "px", "py", "pz" in mm from the first sample$' "$out/import.log" || fail "no path"

# The built-in preset is the file of the same name.
"$palpate" import "$out/skin_2_0_2_1_x.csv" --preset "$source/fixtures/presets/needle-insertion-app.json" --out "$out/by-file" --quiet
"$palpate" import "$out/skin_2_0_2_1_x.csv" --preset needle-insertion-app --out "$out/built-in" --quiet
cmp "$out/by-file/recording.csv" "$out/built-in/recording.csv" || fail "the built-in preset differs from its file"
head -1 "$out/built-in/recording.csv" | grep -qx 'time_s,depth_m,force_n,kind' || fail "columns of recording.csv"

status=0
"$palpate" import "$out/skin_2_0_2_1_x.csv" "$out/recordings/skin_2_0_2_1_x.h5" --out "$out/twice" 2>"$out/stderr" || status=$?
[ "$status" -eq 2 ] || fail "two files of one name: exit status $status"
grep -q 'the same name as' "$out/stderr" || fail "two files of one name: unclear message"
[ ! -e "$out/twice" ] || fail "two files of one name: something was written"

"$palpate" compare "$out/recordings" --trace "$out/trace.csv" --out "$out/agrees" >"$out/compare.log" || { cat "$out/compare.log"; fail "differs"; }
grep -q '^Agrees: The simulated insertion was judged against 4 recordings of a measured phantom' "$out/compare.log" || fail "verdict"
grep -q '"quantity": "insertion"' "$out/agrees/comparison.json" || fail "the quantity is not chosen from the recordings"
grep -q 'two standard deviations over 4 recordings of the group' "$out/agrees/comparison.json" || fail "tolerances"
grep -qE '[0-9] measured recording' "$out/agrees/report.html" && fail "a phantom is called measured"

insertion 1.3 trace 12.5 >"$out/strong.csv"
status=0
"$palpate" compare "$out/recordings" --trace "$out/strong.csv" --out "$out/differs" >"$out/compare.log" || status=$?
[ "$status" -eq 1 ] || fail "exit status $status where the forces differ"
grep -q 'puncture force: 6.' "$out/compare.log" || fail "the puncture force is not named"

status=0
"$palpate" transducer "$out/recordings/skin_2_0_2_1_x.h5" --stdio --fast >/dev/null 2>"$out/stderr" || status=$?
[ "$status" -eq 2 ] || fail "a force is sent as a pressure"
grep -q 'has no pressure' "$out/stderr" || fail "unclear message about the pressure"

# A scene's own insertions give its parameters back, from other priors and with two needles, and predict others.
material=material.phantom-muscle
sed -e 's/^nodes = .*/nodes = [5, 5]/; s/^spacing = .*/spacing = 0.01/; s/^frames = .*/frames = 0/' \
  "$source/fixtures/scenes/phantom-muscle.toml" >"$out/coarse.toml"
needle=1
for values in "3.3 170 280e3" "3.4 175 290e3" "3.5 180 300e3" "3.6 185 310e3" "3.38 174 288e3" "3.52 181 302e3"; do
  read -r puncture friction modulus <<<"$values"
  "$palpate" run "$out/coarse.toml" --set "$material.puncture_force=$puncture" --set "$material.friction=$friction" \
    --set "$material.youngs_modulus=$modulus" --out "$out/run" --quiet 2>/dev/null || fail "the twin does not run"
  "$palpate" import "$out/run/trace.csv" --column tool.depth_m=depth_m --column tool.force_n=force_N \
    --subject "$needle" --out "$out/import" --quiet
  mv "$out/import/recording.h5" "$out/twin-$puncture.h5"
  needle=$((3 - needle))
done
"$palpate" calibrate --condition "$out/coarse.toml" "$out"/twin-3.?.h5 --predict "$out/coarse.toml" name=longer drive.hold=5.4 "$out"/twin-3.??.h5 \
  --parameter "$material.puncture_force" --parameter "$material.friction" --parameter "$material.youngs_modulus" \
  --prior "$material.puncture_force=2.5:0.4" --prior "$material.friction=120:0.5" --out "$out/twin" >"$out/twin.log" 2>&1 ||
  { cat "$out/twin.log"; fail "the twin is not found again"; }
contains() {  # the 95 % interval of a key contains its true mean
  sed -nE "s/^ *$material.$1 .*95 %: ([0-9.e+]+) to ([0-9.e+]+).*/\1 \2/p" "$out/twin.log" |
    awk -v truth="$2" '{ found = 1; exit !(truth >= $1 && truth <= $2) } END { if (!found) exit 1 }'
}
contains puncture_force 3.45 || fail "puncture force: $(cat "$out/twin.log")"
contains friction 177.5 || fail "friction: $(cat "$out/twin.log")"
contains youngs_modulus 295e3 || fail "modulus: $(cat "$out/twin.log")"
[ -s "$out/twin/coarse-fitted.toml" ] && [ -s "$out/twin/longer-fitted.toml" ] || fail "no fitted scenes"
"$palpate" inspect "$out/twin/coarse-fitted.toml" >/dev/null || fail "what was fitted is no scene"

status=0
"$palpate" calibrate --condition "$out/coarse.toml" "$out"/twin-3.?.h5 --predict "$out/coarse.toml" name=again "$out/twin-3.4.h5" \
  --out "$out/seen" 2>"$out/stderr" || status=$?
[ "$status" -eq 2 ] && grep -q 'twin-3.4.h5: is fitted and predicted' "$out/stderr" || fail "what was fitted is predicted: $(cat "$out/stderr")"
[ ! -e "$out/seen" ] || fail "what was fitted is predicted: something was written"
status=0
"$palpate" calibrate --condition "$out/coarse.toml" "$out"/twin-3.?.h5 --condition "$out/coarse.toml" name=again "$out/twin-3.4.h5" \
  --out "$out/seen" 2>"$out/stderr" || status=$?
[ "$status" -eq 2 ] && grep -q 'twin-3.4.h5: is in coarse too; every recording once' "$out/stderr" || fail "fitted twice: $(cat "$out/stderr")"
status=0
"$palpate" calibrate --condition "$out/coarse.toml" drive.speed=0.001 drive.speed=0.002 "$out"/twin-3.?.h5 \
  --out "$out/seen" 2>"$out/stderr" || status=$?
[ "$status" -eq 2 ] && grep -q 'coarse.toml: drive.speed is given twice' "$out/stderr" || fail "a key twice: $(cat "$out/stderr")"

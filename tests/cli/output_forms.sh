#!/usr/bin/env bash
# output_forms.sh PROGRAM FIXTURES SCRATCH: -o, -q, -v and --json mean the same for all commands; colour on a terminal.
set -euo pipefail
palpate=$1
scenes=$2/scenes
out=$3
fail() { echo "$*" >&2; exit 1; }
rm -rf "$out"
mkdir -p "$out"
one_line() { [ "$(wc -l <"$out/said")" -eq 1 ] || fail "$1 -q prints:"$'\n'"$(cat "$out/said")"; }

case=oscillator/order/leapfrog
"$palpate" validate "$case" --cache "$out/cache" -q -o "$out/quiet" >"$out/said"
one_line validate
grep -q '^1 passed, 0 failed' "$out/said" || fail "$(cat "$out/said")"
"$palpate" validate "$case" --cache "$out/cache" --no-skip -v -o "$out/verbose" >"$out/said"
grep -Eq '^ +[a-z_]+.* = .*; allowed ' "$out/said" || fail "-v has no quantity that passes"
"$palpate" validate "$case" --cache "$out/cache" --json -o "$out/json" >"$out/said" 2>/dev/null
cmp "$out/said" "$out/json/results.json" || fail "validate --json is not results.json"
status=0
"$palpate" validate --list --json -o "$out/list" >"$out/said" 2>"$out/error" || status=$?
[ "$status" -eq 2 ] && grep -q 'results.json is not written with these options' "$out/error" || fail "--list --json: $(cat "$out/error")"

"$palpate" approve "$out/quiet" --baseline "$out/new/folder/b.json" --reason first -q >"$out/said"
one_line approve
"$palpate" gate "$out/json" --baseline "$out/new/folder/b.json" -q -o "$out/gate" >"$out/said"
one_line gate
"$palpate" gate "$out/json" --baseline "$out/new/folder/b.json" --json -o "$out/gate" >"$out/said" 2>/dev/null
cmp "$out/said" "$out/gate/gate.json" || fail "gate --json is not gate.json"
# Texts of results are printed without their control characters.
mkdir "$out/coloured"
sed 's/"command": "palpate/"command": "\\u001b[31mpalpate/' "$out/json/results.json" >"$out/coloured/results.json"
cp -r "$out/json/traces" "$out/coloured/"
status=0
"$palpate" gate "$out/coloured" --baseline "$out/new/folder/b.json" -o "$out/gate" >"$out/said" 2>&1 || status=$?
[ "$status" -eq 1 ] && grep -q "results of" "$out/said" || fail "gate of another command: $status, $(cat "$out/said")"
if grep -q $'\033' "$out/said"; then fail "a control character of the results was printed"; fi
"$palpate" export "$scenes/network-example/scene.toml" -q -o "$out/export" >"$out/said"
one_line export

# Colour: on a terminal, and neither with NO_COLOR nor in a pipe.
on_a_terminal() {
  python3 -c 'import pty, sys; sys.exit(pty.spawn(sys.argv[1:]) >> 8)' "$palpate" run "$scenes/oscillator.toml" -q -o "$out/colour" >"$out/said"
}
escape=$'\033['
TERM=xterm NO_COLOR='' on_a_terminal
grep -qF "${escape}32mok" "$out/said" || fail "no colour on a terminal"
TERM=xterm NO_COLOR=1 on_a_terminal
grep -qF "$escape" "$out/said" && fail "colour with NO_COLOR"
TERM=xterm "$palpate" run "$scenes/oscillator.toml" -q -o "$out/colour" >"$out/said"
if grep -qF "$escape" "$out/said"; then fail "colour in a pipe"; fi

# An input is not replaced by an output of the same name; a copy elsewhere is written.
mkdir "$out/own"
printf 'time_s,pressure_Pa\n0,1\n0.1,2\n0.2,3\n' >"$out/own/recording.csv"
cp "$scenes"/network-example/* "$out/own/"
for file in "$out"/own/*; do cp "$file" "$file.kept"; done
kept() {
  status=0
  "$palpate" "$@" >"$out/said" 2>"$out/error" || status=$?
  [ "$status" -eq 2 ] && grep -q 'is an input of this command, which would replace it' "$out/error" ||
    fail "$*: $status, $(cat "$out/said" "$out/error")"
}
kept import "$out/own/recording.csv" --out "$out/own"
kept export "$out/own/scene.toml" --out "$out/own"
mv "$out/own/scene.toml" "$out/own/summary.json"
kept run "$out/own/summary.json" --out "$out/own"
mv "$out/own/summary.json" "$out/own/scene.toml"
ln "$out/own/recording.csv" "$out/own/other.csv"
kept import "$out/own/other.csv" --out "$out/own"
rm "$out/own/other.csv"
mv "$out/own/nodes.csv" "$out/own/trace.xdmf"
sed -i 's/nodes.csv/trace.xdmf/' "$out/own/scene.toml"
kept run "$out/own/scene.toml" --out "$out/own"
mv "$out/own/trace.xdmf" "$out/own/nodes.csv"
mv "$out/own/scene.toml.kept" "$out/scene.toml.kept"  # it names another file now
for file in "$out"/own/*.kept; do cmp "$file" "${file%.kept}" || fail "${file%.kept} was replaced"; done
"$palpate" import "$out/own/recording.csv" --out "$out/elsewhere" -q >"$out/said"
cp "$out/own/recording.csv" "$out/own/second.csv"
"$palpate" import "$out/own/recording.csv" "$out/own/second.csv" --out "$out/both" -q >"$out/said"
"$palpate" import "$out/own/recording.csv" "$out/own/second.csv" --out "$out/both" -q >"$out/said"
echo "of somebody else" >"$out/both/second.h5"
status=0
"$palpate" import "$out/own/recording.csv" "$out/own/second.csv" --out "$out/both" -q 2>"$out/error" || status=$?
[ "$status" -eq 2 ] && grep -q 'second.h5: exists and was not written by palpate' "$out/error" || fail "import: $(cat "$out/error")"

# A limit on file sizes and a folder for temporary files that does not exist are named, and nothing is left.
status=0
(ulimit -f 8; "$palpate" run "$scenes/falcon-soft.toml" --set simulation.duration=2 -q -o "$out/limited") >"$out/said" 2>"$out/error" || status=$?
[ "$status" -eq 2 ] && grep -q 'File too large' "$out/error" || fail "ulimit -f: $status, $(cat "$out/error")"
[ -z "$(find "$out/limited" -type f)" ] || fail "left: $(ls "$out/limited")"
status=0
TMPDIR=/nonexistent "$palpate" validate oscillator/order --subject exec:true -q -o "$out/none" >"$out/said" 2>"$out/error" || status=$?
[ "$status" -eq 2 ] && grep -q 'TMPDIR = "/nonexistent": is no folder' "$out/error" || fail "TMPDIR: $status, $(cat "$out/error")"

# A folder in the place of a file is found before the run.
mkdir -p "$out/taken/report.html"
status=0
"$palpate" run "$scenes/oscillator.toml" -q -o "$out/taken" >"$out/said" 2>"$out/error" || status=$?
[ "$status" -eq 2 ] && grep -q 'report.html: a folder, where this command writes a file' "$out/error" ||
  fail "a folder report.html: $status, $(cat "$out/error")"
[ "$(ls "$out/taken")" = report.html ] || fail "left: $(ls "$out/taken")"

# Results without a case show nothing.
mkdir -p "$out/empty"
echo '{"schema": 1, "title": "t", "command": "c", "provenance": {}, "cases": []}' >"$out/empty/results.json"
status=0
"$palpate" report "$out/empty" >"$out/said" 2>"$out/error" || status=$?
[ "$status" -eq 2 ] && grep -q 'results.json: has no case' "$out/error" || fail "no case: $status, $(cat "$out/error")"

# What a file says is not repeated without end.
printf '[simulation]\n%s = 1\n' "$(head -c 100000 /dev/zero | tr '\0' k)" >"$out/long.toml"
status=0
"$palpate" run "$out/long.toml" -q -o "$out/none" >"$out/said" 2>"$out/error" || status=$?
[ "$status" -eq 2 ] && [ "$(wc -c <"$out/error")" -lt 20000 ] || fail "a long key: $status, $(wc -c <"$out/error") bytes"

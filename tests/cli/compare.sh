#!/usr/bin/env bash
# Comparisons at their limits: the same bytes twice, gigabytes that are
# no recording and no trace, a folder that cannot be written.
set -euo pipefail
palpate=$1 recordings=$2 compared=$3 out=$4
rm -rf "$out"
mkdir -p "$out"
fail() { echo "$1"; exit 1; }
# 4 GB of addresses; the address sanitizer needs terabytes for itself.
within_memory() { [ -n "${PALPATE_SANITIZED:-}" ] || ulimit -v 4000000; }

# Two runs differ in their date alone, and in the seal that covers it.
for n in 1 2; do
  "$palpate" compare "$recordings"/bmi-18-*.h5 --trace "$compared/trace.csv" --out "$out/run" --quiet && fail "agrees"
  grep -vE '"(date|seal)"' "$out/run/comparison.json" >"$out/$n.json"
  grep -v '<dt>date</dt>' "$out/run/report.html" >"$out/$n.html"
done
cmp "$out/1.json" "$out/2.json" || fail "two runs, two comparison.json"
cmp "$out/1.html" "$out/2.html" || fail "two runs, two report.html"
grep -qE '(src|href)="https?:' "$out/run/report.html" && fail "the page makes requests"
[ "$(ls "$out/run" | wc -l)" -eq 2 ] || fail "something else was left behind"

# Gigabytes end in one clear error, within seconds of processor time and in little memory, as recording and as trace.
head -c 65536 /dev/urandom >"$out/garbage"
truncate -s 2G "$out/garbage"
refuses() {
  local status=0
  (within_memory; ulimit -t 10; "$palpate" compare "$1" --trace "$2" --out "$out/written") 2>"$out/stderr" || status=$?
  [ "$status" -eq 2 ] || { cat "$out/stderr"; fail "$1 $2: exit status $status, expected 2"; }
  grep -q "^palpate: .*garbage.*" "$out/stderr" || { cat "$out/stderr"; fail "$1 $2: unclear message"; }
  [ ! -e "$out/written" ] || fail "$1 $2: something was written"
}
refuses "$out/garbage" "$compared/trace.csv"
refuses "$compared/same.csv" "$out/garbage"
rm -f "$out/garbage"

# A folder that is a file: refused before anything is simulated.
: >"$out/file"
status=0
"$palpate" compare "$compared/same.csv" --trace "$compared/trace.csv" --out "$out/file" 2>"$out/stderr" || status=$?
[ "$status" -eq 2 ] || fail "exit status $status where the folder is a file"
grep -q 'file: not a folder that can be written' "$out/stderr" || fail "unclear message about the folder"

# The command on the page means the same to a shell, whatever a file is called.
cp "$compared/same.csv" "$out/it's & \$(the) same.csv"
"$palpate" compare "$out/it's & \$(the) same.csv" --trace "$compared/trace.csv" --out "$out/quoted" --quiet || fail "differs"
command=$(sed -n 's/^ "command": "\(.*\)",$/\1/p' "$out/quoted/comparison.json" | sed 's/\\\\/\\/g')
eval "set -- $command"
[ "$3" = "$out/it's & \$(the) same.csv" ] || fail "the command on the page names $3"

# An export of a recording beside the recording itself is one insertion.
"$palpate" import "$recordings/bmi-18-continuous-01.h5" --out "$out/exported" --quiet >"$out/said"
status=0
"$palpate" compare "$recordings/bmi-18-continuous-01.h5" "$out/exported/recording.csv" --trace "$compared/trace.csv" \
  --out "$out/twice" 2>"$out/stderr" || status=$?
[ "$status" -eq 2 ] || fail "an export beside its recording: exit status $status, expected 2"
grep -q "recording.csv: the same samples as .*bmi-18-continuous-01.h5; every recording once" "$out/stderr" ||
  fail "unclear: $(cat "$out/stderr")"

# The page of a run is not replaced.
mkdir "$out/ran"
cp "$compared/trace.csv" "$out/ran/trace.csv"
echo '{}' >"$out/ran/summary.json"
status=0
"$palpate" compare "$compared/same.csv" --trace "$out/ran/trace.csv" --out "$out/ran" 2>"$out/stderr" || status=$?
[ "$status" -eq 2 ] || fail "--out in the folder of the run: exit status $status, expected 2"
grep -q "holds the results that are read, whose report.html would be replaced" "$out/stderr" || fail "unclear: $(cat "$out/stderr")"

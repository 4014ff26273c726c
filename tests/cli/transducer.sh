#!/usr/bin/env bash
# The pressure link from outside: pipes and a pseudo-terminal at their pace, faults by seed, round trips,
# gigabytes that are no recording.
set -euo pipefail
palpate=$1 recordings=$2 out=$3
rm -rf "$out"
mkdir -p "$out"
fail() { echo "$1"; exit 1; }
# 4 GB of addresses; the address sanitizer needs terabytes for itself.
within_memory() { [ -n "${PALPATE_SANITIZED:-}" ] || ulimit -v 4000000; }
frames() { sed -n 's/^frames: \([0-9]*\) good.*/\1/p' "$1"; }

# Round trip: what was sent is what is imported.
"$palpate" transducer "$recordings/bmi-25-continuous-01.h5" --stdio --fast --quiet >"$out/clean.bin"
cmp "$out/clean.bin" "$recordings/link-clean.bin" || fail "other bytes than stored"

# The same seed gives the same faults, another seed others; what is left and what is missing is all.
send() {
  "$palpate" transducer "$recordings/link-clean.bin" --stdio --fast --drop 0.003 --double 0.003 \
    --corrupt 0.003 --burst 0.0003 --seed "$1" 2>"$out/stderr"
}
send 1 >"$out/a.bin"
grep -q '^1938 frames, 15504 bytes; dropped [1-9]' "$out/stderr" || fail "no counts on standard error"
send 1 >"$out/b.bin"
send 2 >"$out/c.bin"
cmp -s "$out/a.bin" "$out/b.bin" || fail "one seed, two streams"
cmp -s "$out/a.bin" "$out/c.bin" && fail "two seeds, one stream"
"$palpate" import "$out/a.bin" --out "$out/a" >"$out/a.txt"
good=$(frames "$out/a.txt")
missing=$(sed -n 's/.* bad, \([0-9]*\) missing.*/\1/p' "$out/a.txt")
# Frames lost before the first or after the last good one leave no trace.
all=$((good + missing))
[ "$all" -le 1938 ] && [ "$all" -ge 1920 ] || fail "$good good and $missing missing of 1938"
[ "$missing" -gt 50 ] || fail "faults were asked for, and $missing frames are missing"

# Two seconds of a line of 960 bytes a second, through a pipe: no more than it carries. A busy machine only takes longer.
printf 'time_s,pressure_mmHg\n0,100\n1,200\n2,150\n' >"$out/slow.csv"
begin=$(date +%s%N)
"$palpate" transducer "$out/slow.csv" --stdio >"$out/slow.bin" 2>"$out/slow.txt"
elapsed=$((($(date +%s%N) - begin) / 1000000))
[ "$elapsed" -ge 2000 ] || fail "2 s of line took $elapsed ms"
[ "$(stat -c %s "$out/slow.bin")" -eq $((241 * 8)) ] || fail "not 241 frames"
grep -q 'sampled at 1 Hz, sent at 120 Hz: interpolated' "$out/slow.txt" || fail "resampling is not told"

# A pseudo-terminal: its path comes first, a client reads all, and the program ends with the recording.
"$palpate" transducer "$out/slow.csv" --pty >"$out/path" 2>/dev/null &
pid=$!
until [ -s "$out/path" ]; do
  kill -0 "$pid" || fail "no terminal"
  sleep 0.05
done
path=$(head -n 1 "$out/path")
[ -c "$path" ] || fail "the first line is no terminal: $path"
head -c $((241 * 8)) "$path" >"$out/pty.bin"
wait "$pid" || fail "the transducer did not end well"
cmp "$out/pty.bin" "$out/slow.bin" || fail "pipe and terminal differ"

# A reader that leaves ends a transducer that repeats for ever; so does a signal.
"$palpate" transducer "$out/slow.csv" --stdio --repeat --quiet | head -c 800 >/dev/null ||
  fail "no end without a reader"
status=0
timeout -s INT 1 "$palpate" transducer "$out/slow.csv" --stdio --repeat --quiet >/dev/null || status=$?
[ "$status" -eq 124 ] || fail "exit status $status after an interrupt"

# A place without room is an error, not a recording that was sent; one that repeats ends there.
for repeat in '' --repeat; do
  status=0
  "$palpate" transducer "$out/slow.csv" --stdio --fast $repeat >/dev/full 2>"$out/stderr" || status=$?
  [ "$status" -eq 2 ] || fail "exit status $status where nothing could be written"
  grep -q '^palpate: standard output: cannot be written;' "$out/stderr" || fail "no word of what was not written"
done

# Two gigabytes of nothing, and of rows, end in one clear error, in ten seconds of a processor's time, whatever else
# runs, and in little memory. Sanitizers take ten times as long.
patience=10
[ -n "${PALPATE_SANITIZED:-}" ] && patience=100
head -c 65536 /dev/urandom >"$out/garbage"
truncate -s 2G "$out/garbage"
{ printf 'time_s,pressure_Pa\n'; (yes '1,2' || true) | head -c 41000000; } >"$out/rows.csv"
truncate -s 2G "$out/rows.csv"
refuses() {
  local status=0
  (within_memory; ulimit -t "$patience"; "$palpate" import "$1" --out "$out/written") 2>"$out/stderr" || status=$?
  [ "$status" -eq 2 ] || { cat "$out/stderr"; fail "$1: exit status $status, expected 2"; }
  grep -q "^palpate: .*$2.*;" "$out/stderr" || { cat "$out/stderr"; fail "$1: unclear message"; }
  [ ! -e "$out/written" ] || fail "$1: something was written"
}
refuses "$out/garbage" garbage
refuses "$out/rows.csv" 'more than 10000000 samples'
rm -f "$out/garbage" "$out/rows.csv"

#!/usr/bin/env bash
# The emulated Falcon from outside: pipes byte for byte, a pseudo-terminal at 1 kHz, faults, its log.
set -euo pipefail
palpate=$1 client=$2 out=$3
rm -rf "$out"
mkdir -p "$out"
fail() { echo "$1"; exit 1; }

# Pipes: hail, one image byte, a request; nothing but wire bytes on standard output.
printf '\x0aC\x0dAx<AAAAAAAAAAAAAA>' | "$palpate" falcon --stdio --set grip.homed=true --quiet --out "$out/stdio" >"$out/bytes"
printf '\x0aD,\x0dAx<AAAAAAAAAAAAAA<AAAAAAAAAAAA\xb1A>' >"$out/expected"
cmp "$out/bytes" "$out/expected" || fail "other bytes than expected"
[ "$(grep -c ',request,run$' "$out/stdio/log.csv")" -eq 1 ] || fail "no row of the request in log.csv"

serve() {  # folder, options...: $path and $pid of a service that waits
  local folder=$1
  shift
  mkdir -p "$folder"
  "$palpate" falcon --pty --out "$folder" "$@" >"$folder/stdout" 2>"$folder/stderr" &
  pid=$!
  until [ -s "$folder/stdout" ]; do
    kill -0 "$pid" || fail "no terminal"
    sleep 0.1
  done
  path=$(head -n 1 "$folder/stdout")
  [ -c "$path" ] || fail "the first line is no terminal: $path"
}
stop() {  # signal
  local status=0
  kill "-$1" "$pid"
  wait "$pid" || status=$?
  [ "$status" -eq 130 ] || fail "exit status $status after SIG$1, expected 130"
}

# Two clients one after the other: every request is answered, and is a row of the log.
serve "$out/pty" --set grip.homed=true
for requests in 2000 500; do
  replies=$("$client" "$path" "$requests" 5)
  [ "$replies" -eq "$requests" ] || fail "$replies replies to $requests requests"
done
stop TERM
rows=$(grep -c '^[0-9.]*,10,-10,4096,0,1,0,0,0,0,7,request,run$' "$out/pty/log.csv")
[ "$rows" -eq 2500 ] || fail "$rows rows of 2500 requests"
grep -q '^run: 2500 requests, 2500 replies' "$out/pty/stderr" || fail "counters are missing"
[ "$(wc -l <"$out/pty/stdout")" -eq 1 ] || fail "more than the path on standard output"
[ "$(find "$out" -name '*.tmp*' | wc -l)" -eq 0 ] || fail "a temporary file is left"

# 5 % of bytes lost towards the device: 16 bytes survive with chance 0.95^16 = 0.44 (44 of 100, five
# standard deviations are 25), and every packet that arrives whole is answered and a row of the log.
# The client may have stopped waiting for a reply that a busy machine delays.
printf 'seed = 2\n[[fault]]\nkind = "drop"\ndirection = "to-device"\nprobability = 0.05\n' >"$out/drop.toml"
serve "$out/drop" --script "$out/drop.toml"
replies=$("$client" "$path" 100 0.1)
stop INT
rows=$(grep -c ',request,run$' "$out/drop/log.csv")
[ "$rows" -ge 19 ] && [ "$rows" -le 69 ] || fail "$rows replies of 100 with 5 % of bytes lost"
grep -q "^run: .*, $rows replies" "$out/drop/stderr" || fail "the log and the counters disagree"
[ "$replies" -le "$rows" ] || fail "$replies replies seen, $rows sent"

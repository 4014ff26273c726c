#!/usr/bin/env bash
# Two builds side by side: libraries are loaded, pairs are timed and judged, results and history are written, bad input is
# refused. The verdicts depend on the load of the machine, so either is accepted here.
set -euo pipefail
palpate=$1 library=$2 scenes=$3 out=$4
rm -rf "$out"
mkdir -p "$out"
fail() { echo "$1"; exit 1; }
refused() { # message command...
  local message=$1 status=0
  shift
  "$@" >"$out/said" 2>&1 || status=$?
  [ "$status" -eq 2 ] || fail "$*: exit status $status, expected 2: $(cat "$out/said")"
  grep -q "$message" "$out/said" || fail "$*: $(cat "$out/said")"
}
judged() { # folder command...: all checks hold, or one does not; no case ended in an error
  local folder=$1 status=0
  shift
  "$@" --out "$folder" >"$out/said" 2>&1 || status=$?
  [ "$status" -le 1 ] || fail "$*: exit status $status: $(cat "$out/said")"
  grep -q '"status": "error"' "$folder/results.json" && fail "$*: $(cat "$out/said")"
  grep -q "\"$3\"" "$folder/results.json" || fail "$3 is not in the results"
}
cp "$library" "$out/copy.so"

# Both orders of loading; as many pairs as asked for; the same motion to the last bit.
for option in --seed=2 --head-first; do
  "$palpate" steps "$scenes/s26.toml" --library "$out/copy.so" --beside "$library" --pairs 3 "$option" >"$out/pairs"
  [ "$(head -n 1 "$out/pairs")" = same ] || fail "not the same motion"
  [ "$(wc -l <"$out/pairs")" -eq 5 ] || fail "not three pairs"
done
# One tick in twenty more is another motion.
"$palpate" steps "$scenes/s26.toml" --library "$out/copy.so" --beside "$library" --pairs 1 --planted >"$out/pairs"
[ "$(head -n 1 "$out/pairs")" = different ] || fail "a planted tick moved nothing"

echo "no library" >"$out/text.so"
refused 'text.so: cannot be loaded' "$palpate" steps "$scenes/s26.toml" --library "$out/text.so"
mkfifo "$out/fifo.so"
refused 'fifo.so: .*is not a regular file' "$palpate" steps "$scenes/s26.toml" --library "$out/fifo.so"
refused 'no-such-revision: no revision' "$palpate" bench --against no-such-revision --cache "$out/cache" --out "$out/none"
[ ! -e "$out/none" ] || fail "something was written"
# The first commit of the project is older than the library.
if first=$(git -C "$scenes" rev-list --max-parents=0 HEAD 2>/dev/null | tail -n 1) && [ -n "$first" ]; then
  refused "$first: has no step library" "$palpate" bench --against "$first" --cache "$out/cache" --out "$out/none"
fi
judged "$out/self" "$palpate" bench bench/self-test/s26 --self-test 1
judged "$out/paired" "$palpate" bench bench/paired/s26 --against "$out/copy.so" --history "$out/history.jsonl"
[ "$(wc -l <"$out/history.jsonl")" -eq 1 ] || fail "no line of history"
grep -q 'bench/history' "$out/paired/results.json" || fail "history was not judged"
printf 'no line of history\n' >>"$out/history.jsonl"
refused 'history.jsonl:2: ' "$palpate" bench bench/frontier/oscillator --history "$out/history.jsonl" --out "$out/none"
[ ! -e "$out/none" ] || fail "something was written"

#!/usr/bin/env bash
# Cases run in three shards and merged give the bytes of one run; a missing shard, a shard of another run and a case with
# other bytes are refused.
set -euo pipefail
palpate=$1 out=$3 comparable=$4
rm -rf "$out"
mkdir -p "$out"
fail() { echo "$1"; exit 1; }
refused() {  # status, expected message, options of merge...
  local expected=$1 message=$2 status=0
  shift 2
  "$palpate" merge "$@" --out "$out/refused" >"$out/said" 2>&1 || status=$?
  [ "$status" -eq "$expected" ] || fail "exit code $status, not $expected: $(cat "$out/said")"
  grep -q "$message" "$out/said" || fail "not \"$message\" but: $(cat "$out/said")"
  [ ! -e "$out/refused" ] || fail "something was written after: $message"
}
cases=(oscillator/order oscillator/figure-6 oscillator/figure-7)
validate() { "$palpate" validate "${cases[@]}" --quick --no-skip --cache "$out/cache" --quiet "$@"; }
validate --out "$out/whole"
validate --shard 1/3 --out "$out/1"
TEST_SHARD_INDEX=1 TEST_TOTAL_SHARDS=3 validate --out "$out/2"
GTEST_SHARD_INDEX=2 GTEST_TOTAL_SHARDS=3 validate --out "$out/3"
status=0
TEST_SHARD_INDEX=1 validate --out "$out/half" 2>"$out/stderr" || status=$?
[ "$status" -eq 2 ] && grep -q "only one of them is set" "$out/stderr" || { cat "$out/stderr"; exit 1; }
"$palpate" merge "$out/3" "$out/1" "$out/2" "$out/1" --out "$out/merged"
"$comparable" "$out/whole/results.json" >"$out/whole.json"
"$comparable" "$out/merged/results.json" >"$out/merged.json"
cmp "$out/whole.json" "$out/merged.json"
for file in "$out"/whole/traces/*.h5; do cmp "$file" "$out/merged/traces/${file##*/}"; done

SLURM_ARRAY_TASK_ID=2 SLURM_ARRAY_TASK_MIN=1 SLURM_ARRAY_TASK_MAX=3 SLURM_ARRAY_TASK_COUNT=3 validate --out "$out/slurm"
"$comparable" "$out/2/results.json" >"$out/2.json"
"$comparable" "$out/slurm/results.json" | cmp - "$out/2.json"
validate --shard 40/40 --out "$out/empty"  # more shards than cases

refused 2 "shard 2 of 3 is missing: " "$out/1" "$out/3"
refused 2 "is no shard" "$out/1" "$out/whole"
refused 2 "shards of one run" "$out/1" "$out/empty"
cp -r "$out/1" "$out/other"
sed -i '0,/"claim": "/s//"claim": "Other /' "$out/other/results.json"
refused 1 "determinism failure: case oscillator/" "$out/1" "$out/2" "$out/3" "$out/other"
for wrong in 0/3 4/3 x/3 2 2/; do
  status=0
  validate --shard "$wrong" --out "$out/wrong" 2>"$out/said" || status=$?
  [ "$status" -eq 2 ] || fail "--shard $wrong: exit code $status"
  grep -q "^palpate: --shard $wrong: not a shard; i/N" "$out/said" || fail "$(cat "$out/said")"
done

#!/usr/bin/env bash
# What passed is not run again while nothing changes; --no-skip runs it, to the same verdicts and numbers. Nothing that
# another build, other data or another hand left behind is believed.
set -euo pipefail
palpate=$1 out=$3 comparable=$4 code_hash=$5
rm -rf "$out"
mkdir -p "$out"
fail() { echo "$1"; exit 1; }
validate() {  # program, options...: what it prints is in $out.said and $out.errors
  local program=$1
  shift
  "$program" validate --quick --cache "$out/cache" "$@" >"$out.said" 2>"$out.errors" || fail "$(cat "$out.said" "$out.errors")"
}
kept() { grep -q "not run again" "$out.said"; }
figures="oscillator/figure-6 oscillator/order/rk4"
for n in 1 2; do validate "$palpate" $figures --out "$out/$n"; done
grep -q "2 cases, .* not run again" "$out.said" || fail "run again"
validate "$palpate" $figures --no-skip --out "$out/3"
kept && fail "--no-skip did not run"
"$comparable" "$out/1/results.json" >"$out/1.json"
"$comparable" "$out/2/results.json" >"$out/2.json"
cmp "$out/1.json" "$out/2.json"
"$comparable" "$out/3/results.json" | sed 's/ --no-skip//' | cmp - "$out/1.json"
# Nor is its result kept for a run without it: it also computes what scenes do not need, which changes numbers.
"$palpate" validate network/sleep --quick --cache "$out/unskipped" --no-skip --out "$out/3" >"$out.said"
"$palpate" validate network/sleep --quick --cache "$out/unskipped" --out "$out/3" >"$out.said"
kept && fail "what --no-skip found was kept"
# Other options are another question.
"$palpate" validate oscillator/figure-6 --cache "$out/cache" --out "$out/4" >"$out.said"
kept && fail "the short form answered for the whole one"
PALPATE_INSTRUCTIONS=baseline validate "$palpate" oscillator/figure-6 --out "$out/4"
kept && fail "sums of other kernels round elsewhere"

# What was kept and is damaged or edited is run again, with one line; an edit changes no verdict.
damaged() {  # command that changes the file of numbers or of figures in $1
  validate "$palpate" $figures --out "$out/5"
  kept || fail "not kept"
  for file in "$out"/cache/cases/*/oscillator-figure-6."$1"; do "${@:2}" "$file"; done
  validate "$palpate" oscillator/figure-6 --out "$out/5"
  kept && fail "believed after: $*"
  [ "$(grep -c 'oscillator-figure-6.json: is damaged or was edited; the case is run again' "$out.errors")" -eq 1 ] ||
    fail "no line about: $*"
  "$comparable" "$out/5/results.json" >"$out/5.json"
  ! grep -q POISONED "$out/5.json" || fail "an edit arrived"
}
damaged json truncate -s 100
damaged json sed -i 's/"claim": "/"claim": "POISONED /'
damaged h5 truncate -s 1000

# Data that changes in place, with its size and time as before, is seen.
mkdir -p "$out/data/any_network"
echo "a,b,50.0" >"$out/data/any_network/springs.csv"
touch -d 2026-01-01 "$out/data/any_network/springs.csv"
for n in 1 2; do validate "$palpate" oscillator/figure-6 --data "$out/data" --out "$out/6"; done
kept || fail "not kept with data"
echo "a,b,51.0" >"$out/data/any_network/springs.csv"
touch -d 2026-01-01 "$out/data/any_network/springs.csv"
validate "$palpate" oscillator/figure-6 --data "$out/data" --out "$out/6"
kept && fail "other data, but the old result"

# Another build reads neither the results nor the references of this one. --no-skip reads no reference and writes all.
references() { find "$out/cache" -maxdepth 1 -name '*.h5' | wc -l; }
network="network/order/euler network/cube"
validate "$palpate" $network --out "$out/7"
some=$(references)
[ "$some" -gt 0 ] || fail "no reference was kept"
hash=$(grep -o '"[0-9a-f]\{64\}"' "$code_hash" | tr -d '"')
other=$(echo "$hash" | tr 0-9a-f 1-9a-f0)
LC_ALL=C sed "s/$hash/$other/" "$palpate" >"$out/palpate"
cmp -s "$palpate" "$out/palpate" && fail "the code hash is not in the program"
chmod +x "$out/palpate"
validate "$out/palpate" $network --out "$out/7"
kept && fail "another build, but the old results"
[ "$(references)" -eq $((2 * some)) ] || fail "$(references) references of two builds, $some of one"
for file in "$out"/cache/*.h5; do truncate -s 1000 "$file"; done
validate "$palpate" $network --no-skip --out "$out/7"
[ ! -s "$out.errors" ] || fail "--no-skip read: $(cat "$out.errors")"
rm -rf "$out/cache/cases"
validate "$palpate" $network --out "$out/7"
[ ! -s "$out.errors" ] || fail "--no-skip did not write: $(cat "$out.errors")"
for file in "$out"/cache/*.h5; do truncate -s 1000 "$file"; done
rm -rf "$out/cache/cases"
validate "$palpate" $network --out "$out/7"
[ "$(grep -c 'is damaged, was edited, or is the solution of another key; computed again' "$out.errors")" -ge "$some" ] ||
  fail "damaged references in silence: $(cat "$out.errors")"

# A cache that others may write to is refused before anything is written.
chmod g+w "$out/cache"
status=0
"$palpate" validate oscillator/figure-6 --quick --cache "$out/cache" --out "$out/8" 2>"$out.errors" || status=$?
[ "$status" -eq 2 ] || fail "exit status $status for a cache that others may write to"
grep -q 'cache: is no folder of this user that no other may write to' "$out.errors" || fail "$(cat "$out.errors")"
[ ! -e "$out/8" ] || fail "something was written"

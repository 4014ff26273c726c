#!/usr/bin/env bash
# What passed is not run again while nothing changes; --no-skip runs it, to the same verdicts and numbers.
set -euo pipefail
palpate=$1 out=$3 comparable=$4
rm -rf "$out"
for n in 1 2; do
  "$palpate" validate oscillator/figure-6 oscillator/order/rk4 --quick --cache "$out/cache" --out "$out/$n" >"$out.said"
done
grep -q "2 cases, .* not run again" "$out.said"
"$palpate" validate oscillator/figure-6 oscillator/order/rk4 --quick --no-skip --cache "$out/cache" --out "$out/3" >"$out.said"
! grep -q "not run again" "$out.said"
"$comparable" "$out/1/results.json" >"$out/1.json"
"$comparable" "$out/2/results.json" >"$out/2.json"
cmp "$out/1.json" "$out/2.json"
"$comparable" "$out/3/results.json" | sed 's/ --no-skip//' | cmp - "$out/1.json"
# Other options are another question, and so is what was kept and is damaged.
"$palpate" validate oscillator/figure-6 --cache "$out/cache" --out "$out/4" >"$out.said"
! grep -q "not run again" "$out.said"
PALPATE_INSTRUCTIONS=baseline "$palpate" validate oscillator/figure-6 --quick --cache "$out/cache" --out "$out/6" >"$out.said"
! grep -q "not run again" "$out.said"  # sums of other kernels round elsewhere
for file in "$out"/cache/cases/*/*.json; do truncate -s 100 "$file"; done
"$palpate" validate oscillator/figure-6 --quick --cache "$out/cache" --out "$out/5" >"$out.said"
! grep -q "not run again" "$out.said"

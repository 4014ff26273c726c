#!/usr/bin/env bash
# Two runs give the same results.json but for times and provenance, and the same figures.
set -euo pipefail
palpate=$1 out=$3 comparable=$4
rm -rf "$out"
cases=(oscillator network/skew errata)
[ -n "${PALPATE_SANITIZED:-}" ] && cases=(errata)  # ten times slower there, and bytes are the same
for n in 1 2; do
  "$palpate" validate "${cases[@]}" --quick --jobs "$n" --cache "$out/cache-$n" --out "$out/$n" --quiet
  "$comparable" "$out/$n/results.json" >"$out/$n.json"
done
cmp "$out/1.json" "$out/2.json"

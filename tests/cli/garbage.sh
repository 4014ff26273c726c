#!/usr/bin/env bash
# Two gigabytes of garbage as a scene or as a network end in one clear error within seconds of processor time.
set -euo pipefail
palpate=$1 scenes=$2 out=$3
rm -rf "$out"
mkdir -p "$out"
head -c 65536 /dev/urandom >"$out/garbage"
truncate -s 2G "$out/garbage"
printf 'x_m,y_m,z_m,mass_kg,fixed\n' >"$out/nodes.csv"
head -c 65536 /dev/urandom >>"$out/nodes.csv"
truncate -s 2G "$out/nodes.csv"
printf '[tissue]\nsource = "network"\n[tissue.network]\nnodes = "nodes.csv"\nsprings = "springs.csv"\n' >"$out/network.toml"
printf 'a,b,stiffness_n_per_m,viscosity_ns_per_m,rest_length_m\n' >"$out/springs.csv"

refuses() {
  local status=0
  (ulimit -t 5; "$palpate" run "$1" --out "$out/written") 2>"$out/stderr" || status=$?
  [ "$status" -eq 2 ] || { echo "$1: exit status $status, expected 2"; cat "$out/stderr"; exit 1; }
  grep -q "^palpate: .*$2.*;" "$out/stderr" || { echo "$1: unclear message"; cat "$out/stderr"; exit 1; }
  [ ! -e "$out/written" ] || { echo "$1: something was written"; exit 1; }
}
refuses "$out/garbage" garbage
refuses "$out/network.toml" nodes.csv
refuses "$out" "$(basename "$out")"
refuses /dev/null null
rm -f "$out/garbage" "$out/nodes.csv"

# The value of an unset variable is not an option that was left out.
for words in "run s.toml --subject" "run" "validate --expected" "verify e.zip --key" "run s.toml --script" "bench --cache" "calibrate --condition s.toml"; do
  status=0
  # shellcheck disable=SC2086
  "$palpate" $words "" 2>"$out/stderr" || status=$?
  [ "$status" -eq 2 ] && grep -q "the value is empty; give one, or leave" "$out/stderr" ||
    { echo "$words '': exit status $status"; cat "$out/stderr"; exit 1; }
done

# A closed standard output fails, and its number goes to no file of results.
status=0
"$palpate" validate oscillator/figure-6 --quick --no-skip --json --out "$out/closed" >&- 2>"$out/stderr" || status=$?
[ "$status" -eq 3 ] && grep -q "standard output cannot be written" "$out/stderr" && ! grep -q '"cases"' "$out/stderr" ||
  { echo "closed standard output: exit status $status"; cat "$out/stderr"; exit 1; }

#!/usr/bin/env bash
# `palpate certify` from outside: verdict and exit code agree whatever the machine grants, files are whole, Ctrl-C.
set -euo pipefail
palpate=$1 scenes=$2 out=$3 read_json=$4
rm -rf "$out"
fail() { echo "$1"; exit 1; }
short=(--set simulation.duration=0.1 --quiet)

check() {  # folder, exit status: three whole files that agree with the status
  local folder=$1 status=$2 expected
  for file in certificate.json report.html histogram.csv; do
    [ -s "$folder/$file" ] || fail "$folder/$file is missing"
  done
  [ "$(find "$folder" -name '*.tmp*' | wc -l)" -eq 0 ] || fail "a temporary file is left in $folder"
  case $("$read_json" "$folder/certificate.json" verdict) in
    certified) expected=0 ;;
    "not certified") expected=1 ;;
    "environment not qualified") expected=3 ;;
    *) fail "unknown verdict in $folder" ;;
  esac
  [ "$("$read_json" "$folder/certificate.json" interrupted)" = true ] && expected=130
  [ "$status" -eq "$expected" ] || fail "exit status $status, but the verdict wants $expected in $folder"
  [ -n "$("$read_json" "$folder/certificate.json" reason)" ] || fail "no reason in $folder"
  grep -q '</html>' "$folder/report.html" || fail "half a page in $folder"
  head -n 1 "$folder/histogram.csv" | grep -q '^bin_start_us,wakeup,compute,response,control' || fail "other columns"
}
counted() { awk -F, -v column="$2" 'NR > 1 { n += $column } END { print n + 0 }' "$1/histogram.csv"; }

# Whatever this machine is, with a device and without: the numbers of the files agree.
for scene in epidural falcon-soft oscillator; do
  status=0
  rate=()
  [ "$scene" = oscillator ] && rate=(--rate 1000 --set simulation.step=0.01)
  "$palpate" certify "$scenes/$scene.toml" --duration 0.2 "${short[@]}" "${rate[@]}" --out "$out/$scene" || status=$?
  check "$out/$scene" "$status"
  ticks=$("$read_json" "$out/$scene/certificate.json" ticks)
  if [ "$("$read_json" "$out/$scene/certificate.json" given_up)" = true ]; then
    # A machine far too slow: the loop ends once it is 2 s late, with the ticks that ran and a verdict that says no.
    [ "$ticks" -gt 0 ] && [ "$ticks" -lt 200 ] || fail "$ticks ticks of $scene, which gave up"
    [ "$status" -ne 0 ] || fail "$scene gave up and was certified"
  else
    [ "$ticks" -eq 200 ] || fail "$ticks ticks of $scene, not 200"
    [ "$("$read_json" "$out/$scene/certificate.json" restarts)" -eq 1 ] || fail "$scene did not begin again"
  fi
  [ "$(counted "$out/$scene" 4)" -eq "$ticks" ] || fail "the histogram of $scene has other ticks"
  [ "$("$read_json" "$out/$scene/certificate.json" response_us/p99.99)" = null ] || fail "p99.99 of 200 ticks"
done
"$read_json" "$out/falcon-soft/certificate.json" missed_tick/measured_mj | grep -q '^[0-9]' || fail "no energy measured"

# What ran is in the hash of the scene: the file, --set, defaults and the files that the scene names.
key() { "$read_json" "$out/$1/certificate.json" "$2"; }
mkdir -p "$out/net"
printf 'x_m,y_m,z_m,mass_kg,fixed\n0,0,0,0.001,0\n0,0,0.01,0.001,1\n' >"$out/net/nodes.csv"
printf 'a,b,stiffness_n_per_m,viscosity_ns_per_m,rest_length_m\n0,1,50,0.01,\n' >"$out/net/springs.csv"
printf '[simulation]\nduration = 0.01\n[tissue]\nsource = "network"\n[tissue.network]\n%s\n%s\n' \
  'nodes = "nodes.csv"' 'springs = "springs.csv"' >"$out/net/scene.toml"
certify_network() {  # folder, options...: of one tick
  "$palpate" certify "$out/net/scene.toml" --duration 0.001 --quiet --out "$out/$1" "${@:2}" || true
}
certify_network network
certify_network again
certify_network longer --set simulation.duration=0.02
certify_network default --set simulation.step=1e-3
sed -i 's/0,1,50,/0,1,51,/' "$out/net/springs.csv"
certify_network stiffer
[ "$(key network nodes)" = 2 ] || fail "$(key network nodes) nodes of 2"
[ "$(key network inputs/2/file)" = springs.csv ] || fail "springs.csv is no input"
[ "$(key again scene_hash)" = "$(key network scene_hash)" ] || fail "two runs, two hashes"
[ "$(key default scene_hash)" = "$(key network scene_hash)" ] || fail "a default that is given has another hash"
[ "$(key longer scene_hash)" != "$(key network scene_hash)" ] || fail "--set is not in the hash"
[ "$(key stiffer scene_hash)" != "$(key network scene_hash)" ] || fail "springs.csv is not in the hash"
[ "$(key network program_sha256)" = "$(sha256sum "$palpate" | cut -c -64)" ] || fail "another program"
[ "$(key network histogram_sha256)" = "$(sha256sum "$out/network/histogram.csv" | cut -c -64)" ] || fail "another histogram"
seal=$(key network seal)
[ "$seal" = "$(sed "s/\"seal\": \"$seal\"/\"seal\": \"$(printf '0%.0s' {1..64})\"/" "$out/network/certificate.json" |
  sha256sum | cut -c -64)" ] || fail "the seal does not fit"

# --verify: an unchanged certificate ends as it says, a changed one is refused.
verified() { "$palpate" certify --verify "$out/network/certificate.json" >"$out/said" 2>"$out/errors"; }
status=0
verified || status=$?
check "$out/network" "$status"
grep -q '^unchanged since it was written; ' "$out/said" || fail "$(cat "$out/said" "$out/errors")"
cp "$out/network/certificate.json" "$out/whole.json"
sed -i 's/"nodes": 2,/"nodes": 3,/' "$out/network/certificate.json"
status=0
verified || status=$?
[ "$status" -eq 2 ] || fail "exit status $status of a changed certificate"
grep -q 'certificate.json: was changed since it was written' "$out/errors" || fail "$(cat "$out/errors")"
mv "$out/whole.json" "$out/network/certificate.json"

# Too little evidence is never certified: one tick, and a needle that does not arrive.
check_refused() {  # folder, part of the reason where the environment qualifies
  [ "$(key "$1" verdict)" != certified ] || fail "$1 is certified"
  [ "$(key "$1" verdict)" != "not certified" ] || key "$1" reason | grep -q "$2" || fail "$1: $(key "$1" reason)"
}
[ "$(key network ticks)" -eq 1 ] || fail "more than a tick"
check_refused network 'Not enough evidence: 1 of the 2995 ticks\|missed'
"$palpate" certify "$scenes/epidural.toml" --duration 0.1 "${short[@]}" --set drive.from=-0.05 --out "$out/away" || true
check_refused away 'contact\|missed\|Provoked'
key away events_absent | grep -q '^\["contact","end of the advance' || fail "events: $(key away events_absent)"

# A machine that grants no rights: never certified, all figures there.
status=0
"$palpate" certify "$scenes/s26.toml" --duration 0.1 "${short[@]}" --ordinary --out "$out/ordinary" || status=$?
[ "$status" -eq 3 ] || fail "exit status $status without rights, expected 3"
check "$out/ordinary" 3
"$read_json" "$out/ordinary/certificate.json" reason | grep -q 'no SCHED_FIFO.*no locked memory' || fail "no reason"
"$read_json" "$out/ordinary/certificate.json" compute_budget/worst_us | grep -q '^[0-9]' || fail "no compute budget"

# Another title or number of nodes than the scene in it has, with the seal computed again.
forged() {  # expression of sed, message
  rm -rf "$out/forged"
  cp -r "$out/ordinary" "$out/forged"
  sed -i -E "$1" "$out/forged/certificate.json"
  cmp -s "$out/ordinary/certificate.json" "$out/forged/certificate.json" && fail "$1 changes nothing"
  sed -i -E 's/"seal": "[0-9a-f]{64}"/"seal": "'"$(printf '0%.0s' $(seq 64))"'"/' "$out/forged/certificate.json"
  seal=$(sha256sum "$out/forged/certificate.json" | cut -d' ' -f1)
  sed -i -E 's/"seal": "0{64}"/"seal": "'"$seal"'"/' "$out/forged/certificate.json"
  status=0
  "$palpate" certify --verify "$out/forged/certificate.json" 2>"$out/said" || status=$?
  [ "$status" -eq 2 ] || fail "exit status $status of a forged certificate ($1), expected 2"
  grep -q "$2" "$out/said" || fail "unclear: $(cat "$out/said")"
}
status=0
"$palpate" certify --verify "$out/ordinary/certificate.json" >"$out/said" || status=$?
[ "$status" -eq 3 ] && ! grep -q "not checked" "$out/said" || fail "an honest certificate: $status, $(cat "$out/said")"
forged 's/^  "nodes": [0-9]+/  "nodes": 1000000/' 'the scene that it holds has [0-9]* nodes, not 1000000'
forged 's/^  "springs": [0-9]+/  "springs": 7/' 'the scene that it holds has [0-9]* springs, not 7'
forged 's/^  "title": "/  "title": "Another /' 'the scene that it holds has another title'
forged 's/^( *"scheduling": ")[^"]*/\1SCHED_FIFO, priority 80/' 'its command has --ordinary'

# A scene that diverges is not certified anywhere.
status=0
"$palpate" certify "$scenes/cube.toml" --duration 1 --quiet --set 'simulation.integrator="euler-cromer"' --set simulation.step=0.05 \
  --set simulation.substeps=1 --set simulation.duration=10.0 --out "$out/diverged" || status=$?
[ "$status" -eq 1 ] || fail "exit status $status of a scene that diverges, expected 1"
check "$out/diverged" 1

# Ctrl-C: a whole certificate for what ran. The TIMEOUT of CTest ends a loop that goes on.
for seconds in 3 10 30; do  # a busy machine may not have begun the loop: then there is nothing to certify
  rm -rf "$out/interrupted"
  "$palpate" certify "$scenes/falcon-soft.toml" --duration 1000 "${short[@]}" --out "$out/interrupted" &
  pid=$!
  until [ -d "$out/interrupted" ]; do sleep 0.05; done  # signals are handled from here on
  sleep "$seconds"
  kill -INT "$pid" || true  # a loop 2 s late on a busy machine has ended by itself, with its verdict
  status=0
  wait "$pid" || status=$?
  [ ! -f "$out/interrupted/certificate.json" ] || break
  [ "$status" -eq 130 ] || fail "exit status $status after Ctrl-C before the loop, expected 130"
done
check "$out/interrupted" "$status"
case $("$read_json" "$out/interrupted/certificate.json" loads) in
  *'"given_up":true'*) ;;
  *) [ "$status" -eq 130 ] || fail "exit status $status after Ctrl-C, expected 130" ;;
esac

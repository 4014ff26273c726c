#!/usr/bin/env bash
# A scene is run, accepted, held against itself, and then against runs that must not pass.
set -euo pipefail
palpate=$1 scenes=$2 out=$3
rm -rf "$out"
mkdir -p "$out"
scene=$out/scene.toml
baseline=$out/baseline.json

expect() { # status command...
  local expected=$1 status=0
  shift
  "$@" >"$out/said" 2>&1 || status=$?
  [ "$status" -eq "$expected" ] && return
  echo "$* ended with $status, expected $expected"
  cat "$out/said"
  exit 1
}
run() { # folder options...
  local folder=$1
  shift
  "$palpate" run "$scene" --quiet --out "$out/$folder" --set simulation.duration=0.05 "$@"
}

cp "$scenes/cube.toml" "$scene"
run first
run again
expect 2 "$palpate" gate "$out/first" --baseline "$baseline" --out "$out/none"
[ ! -e "$out/none" ]
expect 2 "$palpate" approve "$out/first" --baseline "$baseline" --reason " "
[ ! -e "$baseline" ]
expect 0 "$palpate" approve "$out/first" --baseline "$baseline" --reason "first"
expect 0 "$palpate" gate "$out/again" --baseline "$baseline" --out "$out/gate"
for file in gate.json gate.xml report.html; do [ -s "$out/gate/$file" ]; done
grep -q "1 identical to the last bit" "$out/said"
expect 2 "$palpate" gate "$out/again" --baseline "$baseline" --out "$out/again"
grep -q "holds the results that are read" "$out/said"

# The scene is another one: what was accepted is stale.
sed -i 's/^title = "/title = "Another /' "$scene"
run stale
expect 1 "$palpate" gate "$out/stale" --baseline "$baseline" --out "$out/gate"
grep -q "scene: title" "$out/said"
grep -q '"verdict": "fail"' "$out/gate/gate.json"
grep -q "<failure" "$out/gate/gate.xml"
expect 0 "$palpate" approve "$out/stale" --baseline "$baseline" --reason "another title"
grep -q '"reason": "first"' "$baseline" && grep -q '"reason": "another title"' "$baseline"

# A comment is no other scene; a key is, and is named with both values.
sed -i 's/^title/# a comment\ntitle/' "$scene"
run commented
expect 0 "$palpate" gate "$out/commented" --baseline "$baseline" --out "$out/gate"
run changed --set simulation.substeps=9 --set load.0.end=0.01
expect 1 "$palpate" gate "$out/changed" --baseline "$baseline" --out "$out/gate"
grep -q '"item": "scene: load\[0\].end"' "$out/gate/gate.json"
grep -q '"moved": "is 0.01, was 0.1"' "$out/gate/gate.json"
grep -q "made by commit .*; baseline by the same" "$out/said"

# Runs of other instruction sets are rounding. Approvals at the same time all stay in the ledger, in a new folder.
PALPATE_INSTRUCTIONS=baseline run narrow
expect 0 "$palpate" gate "$out/narrow" --baseline "$baseline" --out "$out/gate"
approvals=()
for n in 1 2 3 4 5 6 7 8; do
  "$palpate" approve "$out/first" --baseline "$out/new/b.json" --reason "number $n" --no-variants --quiet 2>/dev/null &
  approvals+=($!)
done
for n in "${approvals[@]}"; do wait "$n"; done
[ "$(grep -c '"reason": "number' "$out/new/b.json")" -eq 8 ]
[ "$(ls "$out/new" | wc -l)" -eq 2 ]

# The scene is run again only as it was.
expect 2 "$palpate" approve "$out/first" --baseline "$out/new/b.json" --reason "again"
grep -q "gone or changed; .*--no-variants" "$out/said"

# A folder is of one command at a time.
mkdir "$out/busy"
expect 2 flock "$out/busy" "$palpate" run "$scene" --quiet --out "$out/busy"
grep -q "another palpate writes to it" "$out/said"
[ -z "$(ls "$out/busy")" ]

# A run that diverges is neither passed nor accepted.
status=0
run diverged --set 'simulation.integrator="euler-cromer"' --set simulation.step=0.05 --set simulation.substeps=1 \
  --set simulation.duration=10.0 2>/dev/null || status=$?
[ "$status" -eq 1 ]
expect 1 "$palpate" gate "$out/diverged" --baseline "$baseline" --out "$out/gate"
expect 2 "$palpate" approve "$out/diverged" --baseline "$baseline" --reason "no"
grep -q "diverged" "$out/said"

# Half a trace is no trace.
truncate -s 20000 "$out/again/trace.h5"
expect 2 "$palpate" gate "$out/again" --baseline "$baseline" --out "$out/gate"

# An empty selection, and a folder that holds nothing.
expect 2 "$palpate" gate "$out/stale" --baseline "$baseline" --case no/such --out "$out/gate"
mkdir "$out/empty"
expect 2 "$palpate" gate "$out/empty" --baseline "$baseline" --out "$out/gate"

# Variants of a run differ by rounding: one that diverged is none.
expect 2 "$palpate" approve "$out/stale" --baseline "$baseline" --reason "no" --spread "$out/diverged"
grep -q "diverged: case run is error" "$out/said"

# A baseline behind a link stays behind it, also when it is replaced.
ln -s baseline.json "$out/link.json"
expect 0 "$palpate" approve "$out/stale" --baseline "$out/link.json" --reason "linked" --no-variants
[ -L "$out/link.json" ] && grep -q '"reason": "linked"' "$baseline"
expect 0 "$palpate" gate "$out/stale" --baseline "$out/link.json" --out "$out/gate"

# A summary that was edited, and results that are in the way of the output.
sed -i 's/"final_j": /"final_j": 1/' "$out/stale/summary.json"
expect 2 "$palpate" gate "$out/stale" --baseline "$baseline" --out "$out/gate"
grep -q "summary.json: was changed since it was written" "$out/said"
expect 2 "$palpate" index "$out"

# Another number of threads gives the same bits, also where only one is used.
for name in cube s26; do
  cp "$scenes/$name.toml" "$scene"
  run one
  expect 0 "$palpate" approve "$out/one" --baseline "$out/$name.json" --reason "one" --no-variants
  run two --set simulation.threads=2
  expect 0 "$palpate" gate "$out/two" --baseline "$out/$name.json" --out "$out/gate"
done

# Files of others in the way.
mkdir "$out/site"
echo "<title>My page</title>" >"$out/site/index.html"
expect 2 "$palpate" index "$out/site"
grep -q "index.html: exists and is not a page of palpate index" "$out/said"
grep -q "My page" "$out/site/index.html"
expect 2 "$palpate" index "$out" --out "$out/index"
echo "{}" >"$out/none.json"
expect 2 "$palpate" approve "$out/diverged" --baseline "$out/none.json" --reason "no"
grep -q "none.json" "$out/said"

# Inputs of a run: a script that changed, rows further apart, and a script that is new.
cat >"$out/faults.toml" <<'END'
[[fault]]
kind = "drop"
probability = 0.001
END
falcon() { "$palpate" run "$scenes/falcon-soft.toml" --quiet --no-view --set simulation.duration=0.3 --out "$@"; }
falcon "$out/plain"
falcon "$out/faulty" --script "$out/faults.toml"
expect 0 "$palpate" approve "$out/faulty" --baseline "$out/faulty.json" --reason "with faults" --no-variants
expect 1 "$palpate" gate "$out/plain" --baseline "$out/faulty.json" --out "$out/gate"
grep -q "input: --script" "$out/said"
sed -i s/0.001/0.01/ "$out/faults.toml"
expect 2 "$palpate" approve "$out/faulty" --baseline "$out/faulty.json" --reason "again"
grep -q "its input .*faults.toml is gone or changed" "$out/said"
epidural() { "$palpate" run "$scenes/epidural.toml" --quiet --no-view --set simulation.duration=2.0 --out "$@"; }
epidural "$out/rows" --every 0.05
epidural "$out/more-rows" --every 0.01
expect 0 "$palpate" approve "$out/rows" --baseline "$out/rows.json" --reason "rows"
python3 - "$out/rows.json" <<'END'
import json, sys
quantities = json.load(open(sys.argv[1]))["cases"][0]["quantities"]
events = [q for q in quantities if q["name"].startswith("event: ")]
assert events and all(abs(q["uncertainty"] - 0.002) < 1e-9 for q in events), events
END
falcon "$out/whole" --no-skip --every 0.05
expect 0 "$palpate" approve "$out/whole" --baseline "$out/whole.json" --reason "nothing skipped"
expect 2 "$palpate" approve "$out/rows" --baseline "$out/rows.json" --reason "r" --spread "$out/more-rows"
grep -q "samples in a variant instead of" "$out/said"
expect 2 "$palpate" run "$scenes/oscillator.toml" --set $'title="""a\nb"""' --out "$out/lines"
grep -q "has a line break" "$out/said"

# The palpation map is compared, and belongs to its run.
expect 0 "$palpate" run "$scenes/palpation.toml" --set simulation.duration=0.02 --no-view --quiet --out "$out/map"
expect 0 "$palpate" approve "$out/map" --baseline "$out/map.json" --reason "a map" --no-variants
expect 0 "$palpate" gate "$out/map" --baseline "$out/map.json" --out "$out/map-gate"
sed -i '5s/,[0-9.]*$/,1/' "$out/map/palpation.csv"
expect 2 "$palpate" gate "$out/map" --baseline "$out/map.json" --out "$out/map-gate"
grep -q "is not of the same run as palpation.csv" "$out/said"
python3 - "$out/map" <<'END'
import hashlib, json, re, sys
folder = sys.argv[1]
text = open(folder + "/summary.json").read()
map_hash = hashlib.sha256(open(folder + "/palpation.csv", "rb").read()).hexdigest()
text = re.sub('"palpation_sha256": "[^"]*"', f'"palpation_sha256": "{map_hash}"', text)
unsealed = re.sub('"seal": "[^"]*"', '"seal": "' + 64 * "0" + '"', text)
seal = hashlib.sha256(unsealed.encode()).hexdigest()
open(folder + "/summary.json", "w").write(unsealed.replace(64 * "0", seal))
END
expect 1 "$palpate" gate "$out/map" --baseline "$out/map.json" --out "$out/map-gate"
grep -q "palpation-map" "$out/said"

# A summary that contradicts its trace is refused, also with its seal computed again.
contradicted() {  # expected message, pattern and its replacement in summary.json
  rm -rf "$out/forged"
  cp -r "$out/deeper" "$out/forged"
  python3 - "$out/forged" "$2" "$3" <<'END'
import hashlib, re, sys
file = sys.argv[1] + "/summary.json"
text = re.sub(sys.argv[2], sys.argv[3], open(file).read())
unsealed = re.sub('"seal": "[^"]*"', '"seal": "' + 64 * "0" + '"', text)
open(file, "w").write(unsealed.replace(64 * "0", hashlib.sha256(unsealed.encode()).hexdigest()))
END
  expect 2 "$palpate" gate "$out/forged" --baseline "$out/rows.json" --out "$out/map-gate"
  grep -q "$1" "$out/said" || { cat "$out/said"; exit 1; }
}
epidural "$out/deeper"
contradicted "deepest_m is not that of trace.h5" '"deepest_m": [^,]*,' '"deepest_m": 0.05,'
contradicted "steps are not ticks times substeps" '"steps": [^,]*,' '"steps": 7,'
contradicted "the time of its steps is not that of trace.h5" '"ticks": [^,]*,\n *"steps": [^,]*,' '"ticks": 7, "steps": 7,'
contradicted "nodes is not that of trace.h5" '"nodes": [^,]*,' '"nodes": 7,'
contradicted "events is not that of trace.h5" '"kind": "contact"' '"kind": "puncture"'
contradicted "energy.final_j is more than energy.max_j" '"max_j": [^\n]*' '"max_j": 1e-9'
contradicted "status is ok, but it has diverged_at_s" '"status": "ok",' '"status": "ok", "diverged_at_s": 0.1,'

# Other numbers of a summary are compared.
python3 - "$out/map" <<'END'
import hashlib, re, sys
file = sys.argv[1] + "/summary.json"
text = re.sub('"h_omega_max": ([^,]*),', lambda m: f'"h_omega_max": {1.5 * float(m[1])},', open(file).read())
unsealed = re.sub('"seal": "[^"]*"', '"seal": "' + 64 * "0" + '"', text)
open(file, "w").write(unsealed.replace(64 * "0", hashlib.sha256(unsealed.encode()).hexdigest()))
END
expect 1 "$palpate" gate "$out/map" --baseline "$out/map.json" --out "$out/map-gate"
grep -q "h_omega_max" "$out/said"

#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs the programs of examples/ on results of the program, and compares what they print with summary.json.
# usage: examples.sh PALPATE SOURCE SCRATCH PYTHON [OCTAVE]
set -euo pipefail
palpate=$1 source=$2 out=$3 python=$4 octave=${5:-}
fail() { echo "$*" >&2; exit 1; }
rm -rf "$out"
mkdir -p "$out"

"$palpate" run "$source/fixtures/scenes/epidural.toml" --set simulation.duration=2 --vtk --out "$out/run" --quiet
expected="peak force $("$python" -c '
import json, sys
print("%.6g N" % json.load(open(sys.argv[1]))["peak_force_n"])' "$out/run/summary.json")"

said=$("$python" "$source/examples/force_over_depth.py" "$out/run" "$out/force.png")
[[ $said == "$expected"* ]] || fail "python: $said, expected $expected"
[ -s "$out/force.png" ] || fail "no picture"

if [ -n "$octave" ]; then
  said=$(DISPLAY='' "$octave" --no-gui --quiet --eval "addpath('$source/examples'); force_over_depth('$out/run')" 2>/dev/null)
  [[ $said == "$expected"* ]] || fail "octave: $said, expected $expected"
else
  echo "octave: not run, it is not installed"
fi

"$palpate" validate oscillator/order/leapfrog --quick --data none --out "$out/judged" --quiet
"$python" "$source/examples/tightest_claims.py" "$out/judged/results.json" 3 | tail -n 1 | grep -qx '1 cases, 0 failed' ||
  fail "tightest_claims.py"

"$python" "$source/tests/cli/vtk_frames.py" "$out/run"

# results.json of a case with tables, figures and timings, and of one that fails.
"$palpate" validate oscillator/figure-6 oscillator/order/leapfrog --quick --data none --out "$out/judged" --quiet
"$palpate" bench bench/instructions/oscillator --out "$out/bench" --quiet || [ $? -eq 3 ] # skipped without valgrind
"$python" - "$source/docs/results.schema.json" "$out/judged/results.json" "$out/bench/results.json" <<'PYTHON'
import json, sys
import jsonschema

schema = json.load(open(sys.argv[1]))
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)
for file in sys.argv[2:]:
    results = json.load(open(file))
    problems = [f"{file}: {e.json_path}: {e.message}" for e in validator.iter_errors(results)]
    assert not problems, problems
    for key in schema["$defs"]["case"]["required"]:
        assert key in results["cases"][0], key
        broken = json.loads(json.dumps(results))
        del broken["cases"][0][key]
        assert list(validator.iter_errors(broken)), f"{file} without {key} is accepted"
PYTHON

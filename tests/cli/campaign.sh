#!/usr/bin/env bash
# A campaign in shards and on several machines has the bytes of one machine's; valid results are kept; what is missing,
# damaged or different is named.
set -euo pipefail
palpate=$1 scenes=$2 out=$3
rm -rf "$out"
mkdir -p "$out"
cd "$out"
fail() { echo "$1"; exit 1; }
refused() {  # status, expected message, command...
  local expected=$1 message=$2 status=0
  shift 2
  "$palpate" campaign "$@" >said 2>&1 || status=$?
  [ "$status" -eq "$expected" ] || fail "exit code $status, not $expected: $(cat said)"
  grep -q -- "$message" said || fail "not \"$message\" but: $(cat said)"
}
cp "$scenes/oscillator.toml" .
cat >campaign.toml <<'END'
title = "Oscillators"
scenes = ["oscillator.toml"]
method = "saltelli"
samples = 16
deadline_us = 1000.0
[[parameter]]
key = "tissue.oscillator.stiffness"
range = [1.0, 2.0]
[[parameter]]
key = "tissue.oscillator.viscosity"
range = [0.1, 0.2]
scale = "log"
[[claim]]
quantity = "x_m.peak"
upper = 1.5
bound_from = "the initial displacement"
[[claim]]
quantity = "x_m.final"
lower = 0.0
upper = 0.0
bound_from = "a bound that most jobs break"
END
"$palpate" campaign plan campaign.toml --out one
"$palpate" campaign plan campaign.toml --out two >said
cmp one/jobs.jsonl two/jobs.jsonl
jobs=$(wc -l <one/jobs.jsonl)  # fewer than 16 * (2 + 2): the first Sobol points coincide, and run once
[ "$jobs" -le 64 ] || fail "$jobs jobs"
[ "$(grep -o '"rows":[^]]*]' one/jobs.jsonl | tr -cd '0-9,\n' | tr ',' '\n' | sort -n | uniq | wc -l)" -eq 64 ] || fail "rows"
half=$(((jobs + 1) / 2))
"$palpate" campaign run one --jobs 2 --quiet
"$palpate" campaign merge one --out one.jsonl

# Two machines, one of which loses results.
"$palpate" campaign run two --shard 1/2 --quiet
refused 2 "--array=2 of 2 shards" merge two --shards 2 --out two.jsonl
[ ! -e two.jsonl ] || fail "an incomplete merge was written"
echo "another file" >other.txt
refused 2 "other.txt: exists and is not a merged campaign" merge one --out other.txt
"$palpate" campaign status two | grep -q "$half of $jobs jobs done: $half ok, 0 failed" || fail "status"
cp -r two three
SLURM_ARRAY_TASK_ID=1 SLURM_ARRAY_TASK_MIN=0 SLURM_ARRAY_TASK_MAX=1 SLURM_ARRAY_TASK_COUNT=2 \
  "$palpate" campaign run three --quiet
"$palpate" campaign merge three two --out a.jsonl
"$palpate" campaign merge two three --out b.jsonl
cmp one.jsonl a.jsonl
cmp one.jsonl b.jsonl
files=(three/results/*.result)
rm "${files[5]}"
truncate -s 100 "${files[9]}"
refused 2 "results are missing; --array=" merge three --out a.jsonl
"$palpate" campaign run three --quiet >said
grep -q "2 jobs ran, $((jobs - 2)) kept" said || fail "$(cat said)"
"$palpate" campaign merge three --out a.jsonl
cmp one.jsonl a.jsonl

# One job, two results: a determinism failure. The sealed file is written by another plan's run of a changed line.
id=$(basename "${files[0]}" .result)
cp -r three foreign
cat >reseal.py <<'END'
import sys
def fnv(data):
    value, prime = 0x6c62272e07bb014262b821756295c58d, (1 << 88) + 0x13b
    for byte in data:
        value = (value ^ byte) * prime % (1 << 128)
    return value
text = open(sys.argv[1], "rb").read()
line, seal = text[:-52], text[-52:]
assert seal == seal[:-33] + b"%032x\n" % fnv(line), "the seal of this file"
line = line.replace(sys.argv[2].encode(), sys.argv[3].encode())
open(sys.argv[1], "wb").write(line + seal[:-33] + b"%032x\n" % fnv(line))
END
python3 reseal.py "${files[0]}" '"nodes":1,' '"nodes":2,'
refused 1 "determinism failure: job $id" merge one three --out a.jsonl
refused 1 "determinism failure: job $id" merge three one --out a.jsonl

# A result of another scene, or with a word that no program writes, is not merged although its seal fits.
python3 reseal.py "foreign/results/$id.result" '"scene":"' '"scene":"other/'
refused 2 "scene is not that of its job" merge foreign --out b.jsonl
python3 reseal.py "foreign/results/$id.result" '"scene":"other/' '"scene":"'
python3 reseal.py "foreign/results/$id.result" '"status":"ok"' '"status":"foo"'
refused 2 'status = "foo"' merge foreign --out b.jsonl

# The report.
refused 1 "campaign/x_m.final" report one.jsonl --out report
python3 - report/results.json <<'END'
import json, sys
cases = {c["name"]: c for c in json.load(open(sys.argv[1]))["cases"]}
assert cases["campaign/x_m.peak"]["status"] == "pass", cases["campaign/x_m.peak"]
assert cases["campaign/x_m.final"]["status"] == "fail"
assert cases["campaign/timing"]["status"] == "skip"
assert "not judged: the node was not declared exclusive" in cases["campaign/timing"]["skipped"]
causes = cases["campaign/jobs"]["tables"][0]["rows"]
assert causes[0][0] == "x_m.final is outside its bounds", causes
rows = cases["campaign/sensitivity"]["tables"][0]["rows"]
assert any(r[0] == "x_m.final" and r[2] == "tissue.oscillator.stiffness" for r in rows), rows
END

# Results that contradict each other are refused although their seals fit.
cat >forge.py <<'END'
import hashlib, json, re, sys
lines = open("one.jsonl").read().splitlines()
jobs = [json.loads(line) for line in lines[1:]]
exec(sys.argv[1])
rest = [json.dumps(job) for job in jobs]
head = json.loads(lines[0])
head["jobs"] = len(jobs)
head["results_sha256"] = hashlib.sha256("".join(line + "\n" for line in rest).encode()).hexdigest()
head["seal"] = 64 * "0"
text = json.dumps(head, separators=(",", ":")) + "\n"
text = text.replace(64 * "0", hashlib.sha256(text.encode()).hexdigest())
open("forged.jsonl", "w").write(text + "".join(line + "\n" for line in rest))
END
forged() {  # message, change of the jobs
  python3 forge.py "$2"
  refused 2 "$1" report forged.jsonl --out forged
}
python3 forge.py pass
refused 1 "campaign/x_m.final" report forged.jsonl --out forged
forged ":5: x_m.peak = .*, less than the last value" "jobs[3]['quantities']['x_m.peak'] = 1e-9"
forged "nodes = -5" "jobs[3]['nodes'] = -5"
forged 'status = "foo"' "jobs[3]['status'] = 'foo'"
forged "not those of the design" "jobs[3]['parameters']['x'] = 1.0"
forged "which the design does not have" "jobs[3]['parameters'][next(iter(jobs[3]['parameters']))] = 1e9"
forged "domain.depth_m ends before it begins" "jobs[3]['domain'] = {'depth_m': [5, 1]}"
forged "domain.depth_m = 0 to 1, beyond tool.depth_m.peak" "jobs[3]['domain'] = {'depth_m': [0, 1]}"
forged "domain.speed_m_per_s = 0.001 to 10, not the one drive.speed" "jobs[3]['domain'] = {'speed_m_per_s': [0.001, 10]}"
forged "energy.final_j = .*, more than energy.max_j" "jobs[3]['quantities']['energy.final_j'] = 1e9"
forged 'status = "ok", but it names a cause: crashed' "jobs[3]['cause'] = 'crashed'"
forged 'status = "ok", but it has no quantities' "jobs[3]['quantities'] = {}"
forged "cells that turned inside out" "jobs[3]['quantities']['tissue.smallest_jacobian.final'] = -1.0"
forged "id .* twice" "jobs[3]['id'] = jobs[4]['id']"
forged "trace_sha256 of another job" "jobs[3]['trace_sha256'] = jobs[4]['trace_sha256']"
forged "have not every row of the design once" "del jobs[3]"
forged "have not every row of the design once" "jobs[3]['rows'] = jobs[4]['rows']"

# Other simulators and builds. A copy with another code hash is another build; a scene that a simulator cannot represent
# is a failure with its cause.
hash=$("$palpate" campaign job --code)
LC_ALL=C sed "s/$hash/$(tr 0-9a-f 1-9a-f0 <<<"$hash")/" "$palpate" >palpate-2
chmod +x palpate-2
echo exit >sim.sh
cat >product.toml <<END
title = "Product"
scenes = ["oscillator.toml"]
builds = ["$palpate", "palpate-2"]
[[subject]]
name = "model"
subject = "model"
[[subject]]
name = "other"
subject = "exec:sh 'sim.sh'"
END
"$palpate" campaign plan product.toml --out product >said
grep -q "^4 jobs" said || fail "$(cat said)"
"$palpate" campaign run product --quiet >said
grep -q "4 jobs ran, 0 kept, 2 failed, 0 lost" said || fail "$(cat said)"
"$palpate" campaign merge product --out product.jsonl >said
refused 1 "report" report product.jsonl --out product-report
grep -q '"error: --subject: an oscillator is not tissue; a network"' product-report/results.json || fail "no cause"
echo "# another simulator" >>sim.sh
refused 2 "sim.sh: was changed since the plan; plan again" run product
echo exit >sim.sh
printf '\n' >>palpate-2
refused 2 "palpate-2: was changed since the plan; plan again" run product

# A job that diverges has no value, whatever it reached before.
cat >diverging.toml <<END
title = "Diverging"
scenes = ["oscillator.toml"]
[[patient]]
name = "steps"
set = ["simulation.integrator='euler-cromer'", "simulation.substeps=1", "simulation.step=0.1", "simulation.duration=5"]
[[parameter]]
key = "tissue.oscillator.stiffness"
values = [1.0, 1e4]
[[claim]]
quantity = "x_m.peak"
upper = 1e300
bound_from = "a test"
END
"$palpate" campaign plan diverging.toml --out diverging >said
"$palpate" campaign run diverging --quiet >said
"$palpate" campaign merge diverging --out diverging.jsonl >said
refused 1 "report" report diverging.jsonl --out diverging-report
python3 - <<'END'
import json
cases = {c["name"]: c for c in json.load(open("diverging-report/results.json"))["cases"]}
assert cases["campaign/x_m.peak"]["status"] == "fail", cases["campaign/x_m.peak"]
assert {q["name"]: q["value"] for q in cases["campaign/x_m.peak"]["quantities"]}["jobs_without_value"] == 1
END

# An input that changed since the plan, and files that are no campaign.
cp -r two stale
sed -i 's/^mass.*/mass = 1.25/' oscillator.toml
refused 2 "changed since the plan; plan again" run stale --shard 2/2
printf '\n' >>stale/jobs.jsonl
refused 2 "jobs.jsonl: was changed since the plan" run stale
cp -r two edited
sed -i 's/"samples":16/"samples":17/' edited/campaign.json
refused 2 "campaign.json: was changed since it was written" run edited
refused 2 "campaign.json: was changed since it was written" merge edited --out edited.jsonl
sed '1s/"samples":16/"samples":17/' one.jsonl >edited.jsonl
refused 2 "edited.jsonl:1: was changed since it was written" report edited.jsonl --out edited-report
sed 's/samples = 16/sample = 16/' campaign.toml >wrong.toml
refused 2 "wrong.toml:4: unknown key sample; did you mean samples" plan wrong.toml --out wrong
sed 's/range = \[1.0, 2.0\]/range = [2.0, 1.0]/' campaign.toml >wrong.toml
refused 2 "wrong.toml:8: parameter\[0\].range must be \[lowest, highest\]" plan wrong.toml --out wrong
{
  printf 'title = "Too many"\nscenes = ["oscillator.toml"]\n'  # 65536^4 rows are none in 64 bits
  for key in mass stiffness viscosity displacement; do
    printf '[[parameter]]\nkey = "tissue.oscillator.%s"\nrange = [1.0, 2.0]\ncount = 65536\n' $key
  done
} >wrong.toml
refused 2 "wrong.toml: has more than 1000000 jobs" plan wrong.toml --out wrong
sed -i 's/oscillator.mass/oscillator.stiffness/' wrong.toml
refused 2 'parameter\[1\].key = "tissue.oscillator.stiffness" is also that of another parameter' plan wrong.toml --out wrong
sed -i '0,/oscillator.stiffness/s//oscillator[stiffness]/' wrong.toml
refused 2 'parameter\[1\].key = "tissue.oscillator.stiffness" is also that of another parameter' plan wrong.toml --out wrong
printf '[[patient]]\nname = "a"\nset = ["tissue.oscillator.viscosity=0.5"]\n' | cat campaign.toml - >wrong.toml
refused 2 'parameter\[1\].key = .* is also set by the patient "a"' plan wrong.toml --out wrong
printf '[[patient]]\nname = "a"\nset = []\n%.0s' 1 2 | cat campaign.toml - >wrong.toml
refused 2 'patient\[1\].name = "a" is that of another patient' plan wrong.toml --out wrong
printf '[[claim]]\nquantity = "x_m.peak"\nlower = 0\nbound_from = "a"\n' | cat campaign.toml - >wrong.toml
refused 2 'claim\[2\].quantity = "x_m.peak" has a claim already' plan wrong.toml --out wrong
refused 2 "JOB: more than 32 brackets within each other" job "$(printf '[%.0s' $(seq 100))"
sed 's/oscillator.stiffness/oscillator.stifness/' campaign.toml >wrong.toml
refused 2 "wrong.toml: job 1: .*stifness" plan wrong.toml --out wrong
cp oscillator.toml copy.toml
sed 's/\["oscillator.toml"\]/["oscillator.toml", "copy.toml"]/' campaign.toml >wrong.toml
refused 2 "wrong.toml: copy.toml has the inputs of job 1 of oscillator.toml" plan wrong.toml --out wrong
[ ! -e wrong ] || fail "a refused plan was written"
head -c 2000 one.jsonl >cut.jsonl
refused 2 "cut.jsonl" report cut.jsonl --out wrong
head -n 30 one.jsonl >cut.jsonl
refused 2 "cut.jsonl: has 29 of $jobs results" report cut.jsonl --out wrong
[ ! -e wrong ] || fail "a refused report was written"

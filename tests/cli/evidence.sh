#!/usr/bin/env bash
# An archive of evidence is verified from its own content; contexts beyond what was tested, changed bytes, other keys and
# changed inputs are refused or named.
set -euo pipefail
palpate=$1 scenes=$2 out=$3
rm -rf "$out"
mkdir -p "$out"
cd "$out"
fail() { echo "$1"; exit 1; }
refused() {  # status, expected message, command...
  local expected=$1 message=$2 status=0
  shift 2
  "$palpate" "$@" >said 2>&1 || status=$?
  [ "$status" -eq "$expected" ] || fail "exit code $status, not $expected: $(cat said)"
  grep -q -- "$message" said || fail "not \"$message\" but: $(cat said)"
}
if ! command -v openssl >/dev/null; then
  echo "skipped: openssl is not installed; it makes the keys of this test"
  exit 0
fi
openssl genpkey -algorithm ed25519 -out key.pem
openssl pkey -in key.pem -pubout -out pub.pem
openssl genpkey -algorithm ed25519 -out other.pem
openssl pkey -in other.pem -pubout -out other-pub.pem

"$palpate" validate oscillator/order oscillator/figure-6 --quick --cache cache --out judged --quiet
cp "$scenes/epidural.toml" .
cat >campaign.toml <<'END'
title = "Speeds"
scenes = ["epidural.toml"]
[[patient]]
name = "coarse"
set = ["tissue.layers.nodes=[3,3]", "tissue.layers.spacing=0.02", "simulation.duration=0.2", "simulation.step=4e-3"]
[[parameter]]
key = "drive.speed"
values = [0.005, 0.01]
END
"$palpate" campaign plan campaign.toml --out plan >said
"$palpate" campaign run plan --quiet >said
"$palpate" campaign merge plan --out speeds.jsonl >said
# A recording that is the trace itself: a rise to 60 kPa in 6 s and a loss of resistance.
python3 - <<'END'
with open("trace.csv", "w") as trace, open("same.csv", "w") as recording:
    trace.write("time_s,tool.depth_m,tool.force_n,syringe.pressure_pa,tool.layer,tool.event\n")
    recording.write("time_s,pressure_Pa\n")
    for tick in range(481):
        pressure = tick * 250 if tick < 240 else max(1000, 60000 - (tick - 240) * 5900)
        trace.write(f"{tick / 40},0.01,1,{pressure},flavum,\n")
        recording.write(f"{tick / 40},{pressure}\n")
END
"$palpate" compare same.csv --trace trace.csv --out compared --quiet >said
cat >context.toml <<'END'
title = "Epidural trainer"
question = "Is the force at the needle right?"
use = "training of continuous insertion"
influence = "medium"
consequence = "low"
anomalies = ["The view of old browsers is empty."]
[domain]
speed = [0.006, 0.009]
gauge = [16]
[[requirement]]
id = "R1"
text = "The integrators have their order."
cases = ["oscillator/order"]
[[requirement]]
id = "R2"
text = "Runs at all speeds end."
cases = ["campaign/jobs"]
[[requirement]]
id = "R3"
text = "The simulation agrees with recordings."
cases = ["comparison/measured"]
[[factor]]
name = "use error"
evidence = "two persons read every scene"
END
make() { "$palpate" evidence judged speeds.jsonl compared --context context.toml --out "$1" "${@:2}"; }
make evidence.zip --key key.pem
"$palpate" verify evidence.zip --key pub.pem >said
grep -q "^unchanged; signature of this key; verdicts recomputed: 3 of 3 requirements shown; planted faults found" said ||
  fail "$(cat said)"
refused 2 "the signature is not of other-pub.pem" verify evidence.zip --key other-pub.pem
refused 2 "pub.pem: is no Ed25519 private key" evidence judged speeds.jsonl compared --context context.toml --out no.zip --key pub.pem
refused 2 "key.pem: is no Ed25519 public key" verify evidence.zip --key key.pem

# Other programs read it, and its documents say what they must.
python3 - <<'END'
import base64, csv, hashlib, json, zipfile
zip = zipfile.ZipFile("evidence.zip")
assert zip.testzip() is None
files = {name: zip.read(name) for name in zip.namelist()}
statement = json.loads(base64.b64decode(json.loads(files["statement.intoto.json"])["payload"]))
assert statement["_type"] == "https://in-toto.io/Statement/v1"
named = {s["name"]: s["digest"]["sha256"] for s in statement["subject"]}
assert named == {n: hashlib.sha256(b).hexdigest() for n, b in files.items() if n != "statement.intoto.json"}
table = {i["item"]: i["status"] for i in json.loads(files["credibility.json"])}
assert table["1 code verification"] == "in part", table  # most of its cases did not run
assert table["software quality assurance"] == "in part", table
assert table["use error"] == "in part" and table["3 bench test validation"] == "not shown", table
assert table["4 in vivo validation"] == "shown", table
spdx, cyclone = json.loads(files["bom.spdx.json"]), json.loads(files["bom.cyclonedx.json"])
assert spdx["spdxVersion"] == "SPDX-2.3" and cyclone["bomFormat"] == "CycloneDX"
rows = list(csv.DictReader(files["claims.csv"].decode().splitlines()))
assert any(r["requirement"] == "R1" and r["quantity"].startswith("announced order") and r["bound_from"] for r in rows), rows[:2]
domain = json.loads(files["domain.json"])
assert domain["speed_m_per_s"] == {"tested": [0.005, 0.01], "use": [0.006, 0.009]}, domain
assert "old browsers" in json.loads(files["anomalies.json"])[0]["text"]
assert all(f["without"] == "pass" and f["with"] == "fail" for f in json.loads(files["qualification.json"])["faults"])
END

# A context beyond the tested domain, and other wrong contexts.
sed 's/0.009/0.02/' context.toml >wrong.toml
refused 2 "wrong.toml:8: domain.speed: speed_m_per_s from 0.006 to 0.02 is outside the domain; tested: 0.005 to 0.01" \
  evidence judged speeds.jsonl compared --context wrong.toml --out no.zip
refused 2 "context.toml:8: domain.speed: .*tested: none" evidence judged --context context.toml --out no.zip
sed 's/oscillator\/order/oscillator\/odrer/' context.toml >wrong.toml
refused 2 'requirement R1: no case of the results is named "oscillator/odrer"' evidence judged speeds.jsonl compared --context wrong.toml --out no.zip
sed 's/influence/infuence/' context.toml >wrong.toml
refused 2 "wrong.toml:4: unknown key infuence" evidence judged speeds.jsonl compared --context wrong.toml --out no.zip
sed 's/"use error"/"use eror"/' context.toml >wrong.toml
refused 2 'factor.name = "use eror"; one of ' evidence judged speeds.jsonl compared --context wrong.toml --out no.zip
[ ! -e no.zip ] || fail "refused evidence was written"

# Files that are no archives stay, and a pipe is no file.
printf 'PK\003\004 a document' >my.docx
refused 2 "my.docx: exists and is not an archive" evidence judged speeds.jsonl compared --context context.toml --out my.docx
mkfifo pipe
refused 2 "pipe: is not a regular file" evidence judged speeds.jsonl compared --context context.toml --out pipe
refused 2 "pipe: is not a regular file" campaign merge plan --out pipe
cp plan/campaign.json kept.json
refused 2 "campaign.json: exists and is not a merged campaign" campaign merge plan --out plan/campaign.json
cmp plan/campaign.json kept.json || fail "the plan was replaced"

# A group that cannot be compared beside one that agrees is told, and is no contradiction.
sed 's/,.*/,0/; 1s/.*/time_s,pressure_Pa/' same.csv >flat.csv
"$palpate" import same.csv --group a --out a --quiet >said
"$palpate" import flat.csv --group b --out b --quiet >said
refused 1 "1 recording cannot be compared" compare a/recording.h5 b/recording.h5 --trace trace.csv --out two_groups

# A group is shown by all its cases only, and a result that was edited is none.
sed 's/oscillator\/order/oscillator/' context.toml >part.toml
refused 1 "1 of 3 requirements shown" evidence judged speeds.jsonl two_groups --context part.toml --out part.zip
refused 1 "not judged: oscillator/figure-7" verify part.zip
printf '\n[[requirement]]\nid = "R1"\ntext = "t"\ncases = ["campaign/jobs"]\n' | cat context.toml - >twice.toml
refused 2 "requirement R1: its id is used twice" evidence judged speeds.jsonl compared --context twice.toml --out no.zip
sed 's/"status":"ok"/"status":"diverged"/' speeds.jsonl >edited.jsonl
refused 2 "edited.jsonl: was changed" evidence judged edited.jsonl compared --context context.toml --out no.zip
cp -r compared edited
sed -i 's/"holds": true/"holds": false/' edited/comparison.json
refused 2 "comparison.json: was changed" evidence judged speeds.jsonl edited --context context.toml --out no.zip

# A comparison whose numbers contradict each other, sealed again.
cat >contradict.py <<'END'
import hashlib, json, sys
path, edit = "edited/comparison.json", sys.argv[1]
c = json.load(open("compared/comparison.json"))
r, g = c["recordings"][0], c["groups"][0]
f = next(f for f in r["features"] if f["name"] == "peak")
exec(edit)
c["seal"] = "0" * 64
c["seal"] = hashlib.sha256((json.dumps(c) + "\n").encode()).hexdigest()
open(path, "w").write(json.dumps(c) + "\n")
END
contradicts() {  # expected message, statement of Python
  rm -rf edited
  cp -r compared edited
  python3 contradict.py "$2"
  refused 2 "$1" evidence judged speeds.jsonl edited --context context.toml --out no.zip
}
contradicts "peak has both values and is not judged" 'f["verdict"] = "not judged"'
contradicts "it lacks the feature peak" 'r["features"].remove(f)'
contradicts "the limits of peak are not those of its tolerance" 'f["upper"] = 1e9'
contradicts "the error of peak" 'f["simulated"] *= 2'
contradicts "the verdict on peak" 'f["simulated"] *= 2; f["error"] = f["simulated"] - f["recorded"]'
contradicts "the uncertainty of peak" 'f["expanded_uncertainty"] = -1.0'
contradicts "the grade of a rating" 'r["rating"]["grade"] = "good"'
contradicts "it agrees, and its curve is rated poor" 'r["rating"].update(overall=0.1, grade="poor")'
contradicts "the counts of group" 'g["differ"] = 1'
contradicts "the recordings of group" 'r["kind"] = "measured-phantom" if r["kind"] != "measured-phantom" else "measured"'
contradicts "its sentence, and the kinds" 'k = {x["kind"] for x in c["recordings"]}
c["sentence"] = c["sentence"].replace("What was reconstructed is no evidence", "") if "reconstructed" in k else c["sentence"] + " What was reconstructed is no evidence"'
contradicts "whether it holds" 'c["holds"] = not c["holds"]'
contradicts "its schema" 'c["schema"] = 9'

# Scenes, their files and other simulators are inputs too, of runs and of campaigns; nothing is signed without a key.
cp "$scenes"/network-example/*.csv .
cp "$scenes/network-example/scene.toml" network.toml
cp "$scenes/../subjects/python/adapter.py" .
"$palpate" run network.toml --subject "exec:python3 'adapter.py'" --out wired --quiet --no-view >said
"$palpate" run "$scenes/oscillator.toml" --out ran --quiet >said
"$palpate" run epidural.toml --set tissue.layers.nodes=[3,3] --set tissue.layers.spacing=0.02 --set simulation.step=4e-3 \
  --set simulation.duration=0.2 --out shallow --quiet --no-view >said
"$palpate" evidence judged speeds.jsonl compared shallow wired ran --context context.toml --out runs.zip --quiet >said
"$palpate" verify runs.zip >said || fail "$(cat said)"
grep -q "^unchanged; not signed" said || fail "an unsigned archive is not accepted: $(cat said)"
refused 2 "is not signed" verify runs.zip --key pub.pem
for file in nodes.csv network.toml adapter.py epidural.toml; do
  cp "$file" kept.file
  echo "# changed" >>"$file"
  refused 1 "out of date: .*/$file changed since the evidence was made" verify runs.zip
  refused 2 "/$file: gone or changed since .* was made; make it again" \
    evidence judged speeds.jsonl compared wired --context context.toml --out no.zip
  mv kept.file "$file"
done
"$palpate" verify runs.zip >said || fail "$(cat said)"

# Runs whose numbers were changed, or are of another run.
cp -r ran forged_run
sed -i 's/"final_j": /"final_j": 1/' forged_run/summary.json
refused 2 "summary.json: was changed" evidence judged forged_run --context context.toml --out no.zip
"$palpate" run "$scenes/oscillator.toml" --set simulation.duration=20 --out forged_run --quiet >said
cp ran/summary.json forged_run/summary.json
refused 2 "summary.json: is not of the same run as trace.h5" evidence judged forged_run --context context.toml --out no.zip
refused 2 "context.toml: exists and is not an archive" evidence judged --context context.toml --out context.toml

# Every changed byte is found: places spread over the whole archive, and all of its last 40.
python3 - "$palpate" <<'END'
import subprocess, sys
data = open("evidence.zip", "rb").read()
for at in [*range(0, len(data), len(data) // 40), *range(len(data) - 40, len(data), 3)]:
    with open("flipped.zip", "wb") as flipped:
        flipped.write(data[:at] + bytes([data[at] ^ (1 << at % 8)]) + data[at + 1:])
    code = subprocess.run([sys.argv[1], "verify", "flipped.zip"], capture_output=True).returncode
    assert code == 2, f"byte {at}: exit code {code}"
END

# Content that contradicts itself, with hashes computed again, as a forger without the key would do it.
cat >forge.py <<'END'
import base64, hashlib, json, re, struct, sys, zipfile
source, edit = zipfile.ZipFile("runs.zip"), sys.argv[1]
files = {n: source.read(n) for n in source.namelist()}
def sha256(data): return hashlib.sha256(data).hexdigest().encode()
def put(name, content):  # with its own seal and in the list of inputs
    seal = re.search(rb'"seal": "([0-9a-f]{64})"', content)[1]
    zeros = content.replace(seal, 64 * b"0")
    content = content.replace(seal, sha256(zeros))
    files["provenance.json"] = files["provenance.json"].replace(sha256(files[name]), sha256(content))
    files[name] = content
exec(edit)
envelope = json.loads(files.pop("statement.intoto.json"))
statement = json.loads(base64.b64decode(envelope["payload"]))
statement["subject"] = [{"name": n, "digest": {"sha256": hashlib.sha256(b).hexdigest()}} for n, b in sorted(files.items())]
envelope["payload"] = base64.b64encode(json.dumps(statement, separators=(",", ":")).encode()).decode()
files["statement.intoto.json"] = (json.dumps(envelope, indent=1) + "\n").encode()
with zipfile.ZipFile("forged.zip", "w", zipfile.ZIP_STORED) as forged:
    for name, content in sorted(files.items()):
        forged.writestr(zipfile.ZipInfo(name), content)
data = bytearray(open("forged.zip", "rb").read())
at = 0
while data[at:at + 4] == b"PK\3\4":  # flags and dates as palpate writes them
    size, length = struct.unpack_from("<I", data, at + 18)[0], struct.unpack_from("<H", data, at + 26)[0]
    data[at + 4:at + 14] = b"\x0a\0\0\x08\0\0\0\0\x21\0"
    at += 30 + length + size
while data[at:at + 4] == b"PK\1\2":
    length = struct.unpack_from("<H", data, at + 28)[0]
    data[at + 4:at + 16] = b"\x0a\0\x0a\0\0\x08\0\0\0\0\x21\0"
    data[at + 36:at + 42] = bytes(6)
    at += 46 + length
open("forged.zip", "wb").write(data)
END
forged() {  # expected message, statement of Python on `files`
  python3 forge.py "$2"
  refused 2 "$1" verify forged.zip
}
python3 forge.py "pass"
"$palpate" verify forged.zip >said || fail "an archive that was only packed again: $(cat said)"
forged "has no cases.json" 'files.pop("cases.json")'
forged "cases.json does not have the cases" 'files["cases.json"] = b"[]\n"'
forged "has the file zz.txt" 'files["zz.txt"] = b"x"'
forged "has no trace.h5" 'files.pop("results/4/trace.h5")'
forged "summary.json: deepest_m is not that of trace.h5" 'n = "results/4/summary.json"; put(n, files[n].replace(b"\"deepest_m\": ", b"\"deepest_m\": 9", 1))'
forged "provenance.json has no hash of context.toml" 'p = json.loads(files["provenance.json"]); p["inputs"] = []; files["provenance.json"] = json.dumps(p).encode()'
forged "another domain" 'files["results/4/run.json"] = json.dumps({**json.loads(files["results/4/run.json"]), "domain": {"depth_m": [0.0, 5.0]}}).encode()'
forged "claims.json does not follow from the results in it" 'files["claims.json"] = files["claims.json"].replace(b"\"status\": \"shown\"", b"\"status\": \"in part\"", 1)'
forged "another hash of" 'files["provenance.json"] = files["provenance.json"].replace(b"\"sha256\": \"", b"\"sha256\": \"00", 1)'
forged "bom.spdx.json has other packages than bom.cyclonedx.json" 'b = json.loads(files["bom.cyclonedx.json"]); b["components"] = b["components"][1:]; files["bom.cyclonedx.json"] = (json.dumps(b, indent=1, ensure_ascii=False) + "\n").encode()'
forged "bom.cyclonedx.json is not as palpate evidence writes it" 'files["bom.cyclonedx.json"] = files["bom.cyclonedx.json"].replace(b"\"version\": \"0", b"\"version\": \"9", 1)'
forged "bom.spdx.json has other packages" 'files["bom.spdx.json"] = files["bom.spdx.json"].replace(b"\"name\": \"lib", b"\"name\": \"lob", 1)'
forged "qualification.json does not have the faults" 'q = json.loads(files["qualification.json"]); q["faults"] = q["faults"][:1]; files["qualification.json"] = json.dumps(q).encode()'

# An input that changed is named.
echo >>context.toml
refused 1 "out of date: .*context.toml changed since the evidence was made" verify evidence.zip

# A signed certificate.
"$palpate" certify "$scenes/oscillator.toml" --ordinary --duration 0.5 --key key.pem --out certified --quiet >said || true
certificate=certified/certificate.json
"$palpate" certify --verify $certificate --key pub.pem >said || true
grep -q "signature of this key" said || fail "$(cat said)"
refused 2 "the signature is not of other-pub.pem" certify --verify $certificate --key other-pub.pem
printf ' ' >>certified/certificate.intoto.json
refused 2 "certificate.intoto.json: was changed" certify --verify $certificate
rm certified/certificate.intoto.json
refused 2 "certificate.intoto.json: no such file" certify --verify $certificate --key pub.pem

# Neither a key nor a context without a requirement makes an archive.
cp key.pem kept.pem
refused 2 "key.pem: exists and is not an archive" evidence judged speeds.jsonl compared --context context.toml --key key.pem --out key.pem
cmp key.pem kept.pem || fail "the key was replaced"
sed '/^\[\[requirement\]\]/,$d' context.toml >none.toml
refused 2 "none.toml: no \[\[requirement\]\]" evidence judged speeds.jsonl compared --context none.toml --out none.zip
refused 2 "excludes" certify --verify certified/certificate.json --deadline 10

# SPDX-License-Identifier: MIT
"""Runs scenes with an extreme value of one numeric key. Prints a table of exit codes by value.

Usage: extreme_keys.py PALPATE SOURCE SCRATCH; PALPATE_EXTREME_TRIALS [150] and PALPATE_EXTREME_SEED in the environment. A trial holds
if the program ends within its limits with 0, 1, 2 or 3, says every problem in lines that begin with "palpate: ", writes nothing
with 2, and writes no number that is not finite with 0. The keys are those of docs/scenes.md."""

import os
import random
import re
import resource
import shutil
import subprocess
import sys
from pathlib import Path

scenes = ("oscillator", "cube", "s26", "epidural", "epidural-bmi-30", "falcon-soft", "palpation", "sliding-probe", "ultrasound-probe",
          "network-example/scene", "mesh-example/scene", "mri-example/scene", "skin-example/scene", "phantom-muscle")
values = ("0", "-1", "1e308", "-1e308", "1e-308", "nan", "inf", "-inf", "9e18", "9223372036854775807", '""', "[]",
          "[" + "1.0," * 20000 + "1.0]", "1e-30", "1e30")
memory = 2 << 30   # [bytes] of address space: a scene of this size needs less
processor = 20     # [s]; the slowest of these scenes takes four without the extreme value
wall = 600         # [s] for a process that waits, on a machine that runs other tests too


def numeric_keys(manual):
    keys = []
    table = ""
    for line in manual.read_text().splitlines():
        heading = re.match(r"#+ .*?`(\[+)([a-z_.]+)\]+`", line)
        if heading:
            table = heading[2] + ("[0]" if heading[1] == "[[" else "") + "."
            if heading[2].startswith("material."):
                table = heading[2].replace("material.", "material[0].", 1) + "."
        row = re.match(r"\| `([a-z_]+)` \| ([^|]*number[^|]*) \|", line)
        if row and table:
            keys.append(table + row[1])
    return keys


def limit():
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CPU, (processor, processor + 1))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def trial(program, scene, key, value, out):
    shutil.rmtree(out, ignore_errors=True)
    words = [program, "run", scene, "--out", out, "--quiet", "--no-view"]
    if key != "simulation.duration":
        words += ["--set", "simulation.duration=0.002"]
    words += ["--set", f"{key}={value}"]
    try:
        done = subprocess.run([str(w) for w in words], preexec_fn=limit, capture_output=True, timeout=wall)
    except subprocess.TimeoutExpired:
        return "hangs", ["no end"]
    said = done.stderr.decode(errors="replace")
    faults = []
    if done.returncode not in (0, 1, 2, 3):
        faults.append(f"exit code {done.returncode}")
    if done.returncode != 0 and not said:
        faults.append("no message")
    if any(not line.startswith("palpate: ") or not line.replace("\u202f", " ").isprintable() or len(line) > 2000 for line in said.splitlines()):
        faults.append(f"said {said[:300]!r}")
    if done.returncode == 2 and out.exists():
        faults.append("wrote something with exit code 2")
    if done.returncode == 0 and re.search(rb"(nan|inf)[,\n]", (out / "trace.csv").read_bytes()):
        faults.append("a trace with nan or inf")
    return done.returncode, [f"{fault}; {said[:200]!r}" for fault in faults]


def main():
    program, source, scratch = Path(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3])
    count = int(os.environ.get("PALPATE_EXTREME_TRIALS", 150))
    seed = int(os.environ.get("PALPATE_EXTREME_SEED", random.SystemRandom().randrange(10**6)))
    keys = numeric_keys(source / "docs/scenes.md")
    if len(keys) < 80:
        raise SystemExit(f"{len(keys)} numeric keys in docs/scenes.md; its tables have another form")
    scratch.mkdir(parents=True, exist_ok=True)
    print(f"{count} trials, seed {seed}: {len(keys)} keys, {len(scenes)} scenes, {len(values)} values", flush=True)
    draw = random.Random(seed)
    table = {}
    broken = 0
    for _ in range(count):
        scene, key, value = draw.choice(scenes), draw.choice(keys), draw.choice(values)
        code, faults = trial(program, source / "fixtures/scenes" / f"{scene}.toml", key, value, scratch / "out")
        row = table.setdefault(value[:20], {})
        row[code] = row.get(code, 0) + 1
        for fault in faults:
            broken += 1
            print(f"{scene} --set {key}={value[:30]}: {fault}", flush=True)
    for value, row in table.items():
        print(f"{value:22}", ", ".join(f"{code}: {n}" for code, n in sorted(row.items(), key=str)))
    print(f"{broken} faults")
    return 1 if broken else 0


sys.exit(main())

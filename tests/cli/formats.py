#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compares docs/formats.md with what the program writes: every column of trace.csv and trace.h5 and every key of
summary.json and results.json is described, and every column that the page describes is written by some run.

Usage: formats.py PALPATE SOURCE SCRATCH SUBJECT"""

import csv
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

palpate, source, scratch, subject = (Path(word) for word in sys.argv[1:5])
scenes = source / "fixtures/scenes"
problems = []

shutil.rmtree(scratch, ignore_errors=True)
scratch.mkdir(parents=True)
coarse = ["tissue.lattice.nodes=[5, 5, 5]", 'load=[{nodes=[12], force=[0.0, 0.0, 0.005]}]', 'record=[{name="top", node=12}]']
# name: scene, options, overrides, exit codes. Together they write every column.
runs = {
    "needle": ("epidural.toml", [], ["simulation.duration=0.05"], (0,)),
    "probe": ("sliding-probe.toml", [], ["simulation.duration=0.05"], (0,)),
    "falcon": ("falcon-soft.toml", ["--real-time"], ["simulation.duration=0.1"], (0, 1)),
    "oscillator": ("oscillator.toml", [], [], (0,)),
    "refined": ("cube.toml", ["--refine"], ["simulation.duration=0.05", *coarse], (0,)),
    "diverged": ("cube.toml", [], ["simulation.integrator=\"euler-cromer\"", "simulation.step=0.05", "simulation.substeps=1",
                                   "simulation.duration=10.0"], (1,)),
    "other": ("s26-20.toml", ["--subject", subject], ["simulation.duration=0.01"], (0,)),
}


def run(words, exits):
    done = subprocess.run([palpate, *words], capture_output=True, text=True)
    if done.returncode not in exits:
        sys.exit(f"{words}: exit code {done.returncode}\n{done.stdout}{done.stderr}")


def keys_of(value, prefix=""):
    """Keys at any depth."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield key
            yield from keys_of(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from keys_of(inner)


page = (source / "docs/formats.md").read_text()


def words_of(*headings):
    """Code spans of sections of the page."""
    found = set()
    for heading in headings:
        begin = re.search(rf"^##+ {re.escape(heading)}$", page, re.MULTILINE)
        end = re.search(r"^## ", page[begin.end():], re.MULTILINE)
        text = page[begin.end():begin.end() + end.start()]
        found |= {word for span in re.findall(r"`([^`\n]+)`", text) for word in re.split(r"[^\w.]+", span)}
    return found


columns, summary_keys = set(), set()
for name, (scene, options, overrides, exits) in runs.items():
    words = [word for each in overrides for word in ("--set", each)]
    run(["run", scenes / scene, *options, *words, "--quiet", "--no-view", "--out", scratch / name], exits)
    with open(scratch / name / "trace.csv") as file:
        header = next(csv.reader(file))
    columns |= set(header)
    summary = json.loads((scratch / name / "summary.json").read_text())
    summary_keys |= set(keys_of(summary))

# Columns of records begin with a name of the scene.
fixed = ("tool.", "syringe.", "probe.", "tissue.", "device.")
written = {column if column.startswith(fixed) or "." not in column else "NAME." + column.rpartition(".")[2] for column in columns}
described = words_of("trace.csv", "summary.json")
listed = {word for word in words_of("trace.csv") if word.startswith(("NAME.", *fixed))}
listed |= {word for word in words_of("summary.json") if word.startswith("device.")}
for column in sorted(written - described):
    problems.append(f"docs/formats.md lacks the column {column} of trace.csv")
for column in sorted(listed - written):
    problems.append(f"docs/formats.md has the column {column}, which no run writes")
for key in sorted(summary_keys - described):
    problems.append(f"docs/formats.md lacks the key {key} of summary.json")

run(["validate", "oscillator/order/leapfrog", "oscillator/figure-6", "--quick", "--data", "none", "--quiet", "--out",
     scratch / "judged"], (0,))
results = json.loads((scratch / "judged/results.json").read_text())
results.pop("provenance")
schema = json.loads((source / "docs/results.schema.json").read_text())
for key in sorted(set(keys_of(results)) - words_of("Results") - set(keys_of(schema))):
    problems.append(f"docs/formats.md and results.schema.json lack the key {key} of results.json")
for key in sorted(set(schema["$defs"]["case"]["properties"]) - words_of("Results")):
    problems.append(f"docs/formats.md lacks the key {key} of a case of results.json")

if len(written) < 36 or len(summary_keys) < 60:
    problems.append(f"only {len(written)} columns and {len(summary_keys)} keys were written")
print(*problems, sep="\n")
print(f"{len(written)} columns, {len(summary_keys)} keys of summary.json")
sys.exit(1 if problems else 0)

# SPDX-License-Identifier: MIT
"""scripts/ligament-springs finds the law that curves were made with, and refuses what it cannot use.

usage: ligament_springs.py SCRIPT SCRATCH
"""

import importlib.machinery
import importlib.util
import subprocess
import sys
from pathlib import Path

import numpy as np

script, scratch = Path(sys.argv[1]), Path(sys.argv[2])
loader = importlib.machinery.SourceFileLoader("ligament_springs", str(script))
springs = importlib.util.module_from_spec(importlib.util.spec_from_loader("ligament_springs", loader))
sys.dont_write_bytecode = True
loader.exec_module(springs)

length, rate, largest, stiffness = 8.0, 5.0, 6.0, 3.0  # [mm], [1], [1], at rest [N/mm]
folder = scratch / "ligament"
folder.mkdir(parents=True, exist_ok=True)
for donor, wider, stronger in (("A", 0.8, 0.5), ("B", 1.2, 1.5)):
    extension = np.linspace(0.0, 5.0, 101)
    force = stiffness * length * springs.stress(1.0 + extension / length, rate, largest)
    rows = np.column_stack([wider * extension, stronger * force])
    rows = np.vstack([rows, [wider * 5.1, 0.0]])  # it breaks
    np.savetxt(folder / f"{donor}_C2-C3.csv", rows, delimiter=",")


def run(*words):
    return subprocess.run([sys.executable, str(script), *map(str, words)], capture_output=True, text=True)


found = run(folder, length, 20.0)
assert found.returncode == 0, found.stderr
values = {line[:27].strip(): float(line[27:].split()[0]) for line in found.stdout.splitlines()[1:]}
for name, made, tolerance in (("rate", rate, 0.02), ("largest", largest, 0.05), ("stiffness at rest, N/mm", stiffness, 0.02)):
    assert abs(values[name] / made - 1.0) < tolerance, (name, values[name], made)  # printed with three digits
assert values["law less mean, rms"] < 0.002, found.stdout

broken = scratch / "broken"
broken.mkdir(exist_ok=True)
(broken / "A_C2-C3.csv").write_text("extension,force\n")
for words, why in (
    ((folder, 0, 20.0), "LENGTH 0: must be a number above 0"),
    ((folder, length, "nan"), "MODULUS nan"),
    ((scratch / "absent", length, 20.0), "no such folder"),
    ((broken, length, 20.0), "A_C2-C3.csv: could not convert"),
):
    refused = run(*words)
    assert refused.returncode == 2 and why in refused.stderr, (words, refused)

# SPDX-License-Identifier: MIT
"""Short runs of every command that writes, and what a whole file is. For signals.py and full_disk.py."""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path


class Command:
    """One command line. OUT in a word is the folder that it writes to."""

    def __init__(self, name, words, same=(), exits=(0,), prepare=None, endless=False, stdin=None):
        self.name = name
        self.words = words
        self.same = same        # files that every run writes byte by byte alike
        self.exits = exits      # exit codes of a run that ends by itself
        self.prepare = prepare  # makes what the command changes in place
        self.endless = endless  # ends by a signal alone
        self.stdin = stdin

    def line(self, program, out):
        return [str(program)] + [str(w).replace("OUT", str(out)) for w in self.words]


class Setting:
    """Paths of one test run. Makes the inputs of gate, approve and report."""

    def __init__(self, program, source, scratch):
        self.program = Path(program)
        self.source = Path(source)
        self.scratch = Path(scratch)
        shutil.rmtree(self.scratch, ignore_errors=True)
        (self.scratch / "tmp").mkdir(parents=True)
        self.environment = dict(os.environ, TMPDIR=str(self.scratch / "tmp"), XDG_CACHE_HOME=str(self.scratch / "cache"))
        self.call(["validate", *cheap_cases, "--quick", "--data", "none", "--out", self.scratch / "judged"])
        self.call(["validate", *cheap_cases, "--quick", "--data", "none", "--shard", "1/1", "--out", self.scratch / "shard"])
        (self.scratch / "campaign.toml").write_text(campaign.format(self.source / "fixtures/scenes/oscillator.toml"))
        self.call(["campaign", "plan", self.scratch / "campaign.toml", "--out", self.scratch / "plan"])
        self.call(["campaign", "plan", self.scratch / "campaign.toml", "--out", self.scratch / "ran"])
        self.call(["campaign", "run", self.scratch / "ran"])
        self.call(["approve", self.scratch / "judged", "--baseline", self.scratch / "base/base.json", "--reason", "first"])

    def call(self, words, expected=(0,)):
        done = subprocess.run([str(self.program)] + [str(w) for w in words], env=self.environment, capture_output=True)
        if done.returncode not in expected:
            raise SystemExit(f"{words}: exit code {done.returncode}\n{done.stderr.decode(errors='replace')}")
        return done

    def copy_of_base(self, out):
        out.mkdir(parents=True, exist_ok=True)
        for file in (self.scratch / "base").iterdir():
            shutil.copy(file, out)

    def copy_of_judged(self, out):
        shutil.copytree(self.scratch / "judged", out, dirs_exist_ok=True)

    def copy_of_plan(self, out):
        shutil.copytree(self.scratch / "plan", out, dirs_exist_ok=True)

    def history_of_one(self, out):
        out.mkdir(parents=True, exist_ok=True)
        (out / "history.jsonl").touch()

    def commands(self):
        scenes = self.source / "fixtures/scenes"
        recordings = self.source / "fixtures/recordings"
        poses = self.scratch / "poses.csv"
        poses.write_text("x_m,y_m,z_m\n" + "0,0,0.125\n0.01,-0.02,0.11\n" * 2000)
        short = ["--scene", scenes / "epidural-bmi-30.toml", "--set", "tissue.layers.nodes=[3,3]",
                 "--set", "tissue.layers.spacing=0.02", "--set", "simulation.step=4e-3",
                 "--parameter", "syringe.thumb_force"]
        lattice = ["--set", "tissue.lattice.nodes=[5,5,5]", "--set", "load=[]", "--set", 'record=[{name="top", node=12}]']
        pythonic = f"exec:python3 {self.source}/fixtures/subjects/python/adapter.py"
        folder = ["--out", "OUT", "--quiet"]
        validate = ["validate", *cheap_cases, "--quick", "--data", "none", "--no-skip", "--cache", self.scratch / "cases"]
        return [
            Command("run-oscillator", ["run", scenes / "oscillator.toml", *folder], ("trace.csv",)),
            Command("run-cube", ["run", scenes / "cube.toml", "--set", "simulation.duration=0.2", *lattice, *folder], ("trace.csv",)),
            Command("run-refine", ["run", scenes / "cube.toml", "--refine", "--set", "simulation.duration=0.05", *lattice, *folder],
                    ("trace.csv",)),
            Command("run-palpation", ["run", scenes / "palpation.toml", "--set", "simulation.duration=0.01", *folder],
                    ("trace.csv", "palpation.csv")),
            Command("run-falcon", ["run", scenes / "falcon-soft.toml", "--packets", "--set", "simulation.duration=0.1", *folder],
                    ("trace.csv", "packets.csv")),
            Command("inspect", ["inspect", scenes / "epidural.toml", "--json"]),
            Command("export", ["export", scenes / "epidural.toml", *folder], ("nodes.csv", "springs.csv")),
            Command("validate", [*validate, *folder]),
            Command("validate-subject", ["validate", "subject/chain", "--quick", "--subject", pythonic, *folder]),
            Command("bench", ["bench", "--quick", "bench/instructions/oscillator", "--history", "OUT/history.jsonl", *folder],
                    prepare=self.history_of_one),
            Command("certify", ["certify", scenes / "oscillator.toml", "--ordinary", "--duration", "0.3", *folder], exits=(0, 1, 3)),
            Command("compare", ["compare", recordings / "bmi-18-continuous-01.h5", "--scene", scenes / "epidural.toml", *folder],
                    exits=(0, 1)),
            Command("calibrate", ["calibrate", recordings / "bmi-25-continuous-01.h5", recordings / "bmi-25-continuous-02.h5", *short,
                                  *folder], ("fitted.toml",), exits=(0, 1)),
            Command("import", ["import", recordings / "link-damaged.bin", *folder], ("recording.csv", "recording.h5")),
            Command("import-all", ["import", *sorted(recordings.glob("bmi-*.h5")), *folder]),
            Command("reconstruct", ["reconstruct", self.source / "fixtures/clinical/published_values.csv", *folder]),
            Command("gate", ["gate", self.scratch / "judged", "--baseline", self.scratch / "base/base.json", *folder], ("gate.xml",)),
            Command("approve", ["approve", self.scratch / "judged", "--baseline", "OUT/base.json", "--reason", "again", "--quiet"],
                    prepare=self.copy_of_base),
            Command("merge", ["merge", self.scratch / "shard", *folder]),
            Command("campaign-plan", ["campaign", "plan", self.scratch / "campaign.toml", *folder], ("jobs.jsonl",)),
            Command("campaign-run", ["campaign", "run", "OUT", "--quiet"], prepare=self.copy_of_plan),
            Command("campaign-merge", ["campaign", "merge", self.scratch / "ran", "--out", "OUT/merged.jsonl"], ("merged.jsonl",)),
            Command("report", ["report", "OUT", "--quiet"], prepare=self.copy_of_judged),
            Command("falcon-solve", ["falcon", "--solve", poses, *folder], ("solution.csv",)),
            Command("falcon-stdio", ["falcon", "--stdio", *folder], stdin=b"A" * 4000),
            Command("falcon-pty", ["falcon", "--pty", *folder], exits=(130,), endless=True),
            Command("transducer", ["transducer", recordings / "porcine-continuous-01.h5", "--stdio", "--fast", "--quiet"]),
            Command("transducer-pty", ["transducer", recordings / "porcine-continuous-01.h5", "--pty", "--repeat", "--quiet"],
                    exits=(130,), endless=True),
            Command("subject-new", ["subject", "new", "--language", "c", "OUT/new", "--quiet"], ("new/subject.c",),
                    prepare=lambda out: shutil.rmtree(out, ignore_errors=True)),
            Command("steps", ["steps", scenes / "oscillator.toml", "--ticks", "100000"]),
        ]


campaign = """title = "Oscillators"
scenes = ["{}"]
[[parameter]]
key = "tissue.oscillator.mass"
values = [1.0, 1.5]
"""
cheap_cases = ("oscillator/order/leapfrog", "oscillator/figure-6")
temporary = re.compile(r"\.tmp-\d+-\d+")


def files_in(folder):
    if not folder.exists():
        return []
    return sorted(str(f.relative_to(folder)) for f in folder.rglob("*") if f.is_file())


def fault_of(file):
    """What is wrong with a file that a command left, or None."""
    data = file.read_bytes()
    if temporary.search(file.name):
        return "a temporary file is left"
    if file.suffix == ".json":
        try:
            json.loads(data if data.startswith(b"{") else data.partition(b"\n")[2])  # a judged case follows its hash
        except ValueError as problem:
            return f"not JSON: {problem}"
    ends = {".h5": rb"\npalpate fnv1a-128 [0-9a-f]{32}\n", ".html": rb"</html>\s*", ".csv": rb"\n", ".xml": rb">\s*", ".toml": rb"\n",
            ".xdmf": rb"</Xdmf>\n", ".jsonl": rb"\n"}
    end = ends.get(file.suffix)
    if end and data and not re.search(end + rb"\Z", data):
        return f"is cut: {data[-40:]!r}"
    if file.suffix in (".h5", ".html", ".csv", ".xml", ".toml") and not data:
        return "is empty"
    return None


def faults_in(*folders):
    faults = []
    for folder in folders:
        for name in files_in(folder):
            why = fault_of(folder / name)
            if why:
                faults.append(f"{name} {why}")
    return faults

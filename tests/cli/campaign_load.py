# SPDX-License-Identifier: MIT
"""Time and memory of `palpate campaign merge` and `report` for many results.

usage: campaign_load.py PALPATE SCENE OUT [COUNT]

Plans COUNT [100000] jobs, runs one, and writes the results of the others as copies of it with their own id, parameter and
seal, so that a merge reads as many files and bytes as if all had run."""

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path


def sealed(line):
    """Appends the seal of the program: FNV-1a of 128 bits."""
    value = 0x6C62272E07BB014262B821756295C58D
    for byte in line:
        value = (value ^ byte) * 0x1000000000000000000013B & (1 << 128) - 1
    return line + b"\npalpate fnv1a-128 %032x\n" % value


def measured(words):
    begin = time.monotonic()
    process = subprocess.Popen([str(word) for word in words], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"{words}: status {status}")
    print(f"{words[2]}: {time.monotonic() - begin:.1f} s, {usage.ru_utime + usage.ru_stime:.1f} s of processor time, "
          f"{usage.ru_maxrss / 1e3:.0f} MB", flush=True)


def main():
    palpate, scene, out = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), Path(sys.argv[3])
    count = int(sys.argv[4]) if len(sys.argv) > 4 else 100000
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    (out / "campaign.toml").write_text(
        f'title = "Load"\nscenes = ["{scene}"]\n[[parameter]]\nkey = "tissue.lattice.stiffness"\nrange = [40.0, 60.0]\n'
        f'count = {count}\n[[patient]]\nname = "small"\nset = ["tissue.lattice.nodes=[5,5,8]", '
        '"load=[{nodes=[12], force=[0.0,0.0,0.005]}]", "record=[{name=\\"top\\", node=12}]", "simulation.duration=0.001"]\n')
    measured([palpate, "campaign", "plan", out / "campaign.toml", "--out", out / "plan"])
    subprocess.run([palpate, "campaign", "run", out / "plan", "--shard", f"1/{count}", "--quiet"], check=True)
    with open(out / "plan/jobs.jsonl", encoding="utf-8") as file:
        jobs = [json.loads(line) for line in file]
    results = out / "plan/results"
    first = (results / f"{jobs[0]['id']}.result").read_bytes()
    line = first[:first.index(b"\n") + 1]
    if sealed(line) != first:
        sys.exit("the program seals its results in another way")
    for job in jobs[1:]:
        result = json.loads(line)
        result.update(id=job["id"], rows=job["rows"], parameters=job["parameters"])
        copy = json.dumps(result, separators=(",", ":")).encode() + b"\n"
        (results / f"{job['id']}.result").write_bytes(sealed(copy))
    print(f"{count} results of {len(copy)} bytes", flush=True)
    measured([palpate, "campaign", "merge", out / "plan", "--out", out / "merged.jsonl"])
    measured([palpate, "campaign", "report", out / "merged.jsonl", "--out", out / "report"])
    print(f"report.html: {(out / 'report/report.html').stat().st_size / 1e3:.0f} kB")


main()

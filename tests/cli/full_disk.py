# SPDX-License-Identifier: MIT
"""Lets every write of every command fail as on a full disk, one after the other, then runs the command in the same folder.

Usage: full_disk.py PALPATE SOURCE SCRATCH LIBRARY. Call 1, 2, ... of full_disk.c fails until the command makes no more calls, once
alone and once with all calls after it. A trial holds if the command ends with 2 or 3 and one line, if every file is whole or absent,
and if the next run succeeds. Kept cases and references may be lost without an error: they are computed again."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from command_list import Setting, faults_in, files_in

slow = ("certify", "compare", "bench")  # only with PALPATE_FULL_DISK_ALL
left_out = ("run-palpation", "reconstruct", "falcon-pty", "transducer-pty", "inspect", "steps", "transducer", "run-refine", "import-all", "calibrate",
            "validate-subject")  # write nothing, or through the same functions as the others
most_calls = 2000


def fresh(setting, command):
    out = setting.scratch / "trial" / command.name
    shutil.rmtree(out, ignore_errors=True)
    if command.prepare:
        command.prepare(out)
    return out


def run(setting, command, out, environment):
    return subprocess.run(command.line(setting.program, out), env=environment, input=command.stdin or b"",
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=300)


def trial(setting, command, library, call, stays):
    """Returns what failed, the exit code and the faults; None if nothing failed."""
    out = fresh(setting, command)
    note = setting.scratch / "note"
    note.unlink(missing_ok=True)
    for cache in ("cases", "cache"):
        shutil.rmtree(setting.scratch / cache, ignore_errors=True)
    environment = dict(setting.environment, LD_PRELOAD=str(library), FULL_DISK_CALL=str(call), FULL_DISK_NOTE=str(note))
    if stays:
        environment["FULL_DISK_STAYS"] = "1"
    done = run(setting, command, out, environment)
    if not note.exists():
        return None
    failed = note.read_text().strip()
    said = done.stderr.decode(errors="replace")
    faults = []
    kept = any(str(setting.scratch / cache) in failed for cache in ("cases", "cache"))
    lines = [line for line in said.splitlines() if "warning: made by" not in line]
    results = out / "results.json"
    if done.returncode in command.exits and kept:
        pass
    elif done.returncode == 1 and results.exists() and b"No space left on device" in results.read_bytes():
        pass  # a case could not work; the results say so
    elif done.returncode not in (2, 3):
        faults.append(f"exit code {done.returncode}, said {said!r}")
    elif len(lines) != 1 or not lines[0].startswith("palpate: ") or "space" not in lines[0]:
        faults.append(f"said {said!r}")
    # A disk that refuses to cut a half line off again leaves it to the next run.
    faults += [fault for fault in faults_in(out, setting.scratch / "cases", setting.scratch / "cache")
               if not (stays and fault.startswith("history.jsonl is cut"))]
    faults += [f"{f} is left in TMPDIR" for f in files_in(setting.scratch / "tmp")]
    if command.name == "approve":
        setting.call(["gate", setting.scratch / "judged", "--baseline", out / "base.json", "--out", setting.scratch / "after"])
    if command.name == "subject-new":
        shutil.rmtree(out, ignore_errors=True)
    again = run(setting, command, out, setting.environment)
    if again.returncode not in command.exits:
        faults.append(f"next run: exit code {again.returncode}, said {again.stderr.decode(errors='replace')!r}")
    faults += ["next run: " + fault for fault in faults_in(out)]
    return failed, done.returncode, faults


def main():
    program, source, scratch, library = sys.argv[1:5]
    setting = Setting(program, source, scratch)
    total = 0
    broken = 0
    for command in setting.commands():
        if command.name in left_out or (command.name in slow and "PALPATE_FULL_DISK_ALL" not in os.environ):
            continue
        codes = {}
        for stays in (False, True):
            for call in range(1, most_calls):
                found = trial(setting, command, Path(library).resolve(), call, stays)
                if found is None:
                    break
                failed, code, faults = found
                codes[code] = codes.get(code, 0) + 1
                for fault in faults:
                    broken += 1
                    print(f"{command.name}, call {call}{' and later' if stays else ''}, {failed}: {fault}", flush=True)
        total += sum(codes.values())
        print(f"{command.name:18} {sum(codes.values()):4} failed calls; exit codes",
              ", ".join(f"{code}: {n}" for code, n in sorted(codes.items())), flush=True)
    print(f"{total} failed calls, {broken} faults")
    return 1 if broken or total == 0 else 0


sys.exit(main())

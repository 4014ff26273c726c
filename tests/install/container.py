#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compares the Containerfile with what it relies on: scripts/setup, the targets of the build, docs/.

Usage: container.py SOURCE BUILD NINJA"""

import re
import subprocess
import sys
from pathlib import Path

source, build, ninja = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
problems = []


def check(holds, problem):
    if not holds:
        problems.append(problem)


def packages(*options):
    done = subprocess.run([source / "scripts/setup", *options, "--list"], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


every, needed = packages(), packages("build")
lines = (source / "Containerfile").read_text().splitlines()
steps = [line[4:] for line in lines if line.startswith("RUN ")]
check("scripts/setup build" in steps, "no step runs scripts/setup build")
check(needed < every, f"scripts/setup build installs what scripts/setup does not: {needed - every}")

# Packages by apt: those of scripts/setup, and the one that was built.
for step in steps:
    for installed in re.findall(r"apt-get install ([^&]*)", step):
        named = {word for word in installed.split() if not word.startswith("-")}
        check(named <= needed | {"/package/palpate_*.deb"}, f"not of scripts/setup: {named}")
    check(not re.search(r"\b(curl|wget|pip3?|npm|git clone)\b", step), f"downloads without apt: {step}")

# docs/dependencies.md has a row for each package; those of tests alone are not needed for a build.
documented = {}
for row in re.findall(r"^\| ([^|]+) \| ([^|]+) \|", (source / "docs/dependencies.md").read_text(), re.MULTILINE):
    for name in re.findall(r"[a-z][a-z0-9+-]+", re.sub(r"\d+\.\d+", "", row[0])):
        documented[name] = row[1]
check(every <= set(documented), f"not in docs/dependencies.md: {every - set(documented)}")
for name in every & set(documented):
    of_tests = not set(re.split(r"[ ,()]+", documented[name])) - {"tests", "examples", "format"}
    check(of_tests == (name not in needed),
          f"{name} is used by \"{documented[name]}\", and scripts/setup build {'installs' if name in needed else 'lacks'} it")

# Targets and configuration that the steps name.
targets = re.search(r"--target ([\w -]+)", "\n".join(steps))[1].split()
known = subprocess.run([ninja, "-C", build, "-t", "targets", "all"], capture_output=True, text=True, check=True).stdout
for target in targets:
    check(re.search(rf"^{re.escape(target)}: ", known, re.MULTILINE), f"no target {target}")
pages = "\n".join((source / "docs" / page).read_text() for page in ("install.md", "ci.md"))
for step in steps:
    if step.startswith("cpack"):
        check(step in pages, f"docs/install.md has another command than: {step}")
for image in {line.split()[1] for line in lines if line.startswith("FROM ")}:
    check(f"container: {image}" in pages, f"docs/ci.md uses another image than {image}")
for copied in (line.split() for line in lines if line.startswith("COPY ") and "--from" not in line):
    check((source / copied[1]).exists(), f"{copied[1]} does not exist")
ignored = (source / ".containerignore").read_text().split()
check("build" in ignored, "the build folder is copied into the container")

print(*problems, sep="\n")
sys.exit(1 if problems else 0)

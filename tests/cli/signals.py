# SPDX-License-Identifier: MIT
"""Sends SIGINT, SIGTERM and SIGHUP to every command at random moments, then repeats the command in the same folder.

Usage: signals.py PALPATE SOURCE SCRATCH; PALPATE_SIGNAL_TRIALS [30] and PALPATE_SIGNAL_SEED in the environment. A trial holds if the command ends with 130, or whole with its own exit
code if it had finished, if every file is whole or absent, and if the repeated command gives what an undisturbed one gives."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from command_list import Setting, faults_in, files_in

# [s] Limit for a command that hangs after a signal. A second is promised; a machine under the load of other tests takes longer.
# Trials above a second are counted and printed.
hang = 10.0


def catches(process, number):
    """Whether the process has a handler of the signal. It has none while its libraries are loaded."""
    try:
        status = Path(f"/proc/{process.pid}/status").read_text()
    except OSError:
        return True
    caught = int(status.partition("SigCgt:")[2].split()[0], 16)
    return bool(caught >> (number - 1) & 1)


# Under nohup SIGHUP is ignored, by children too.
ENDING = [signal.SIGINT, signal.SIGTERM]
if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:
    ENDING.append(signal.SIGHUP)


class Trials:
    def __init__(self, setting, seed):
        self.setting = setting
        self.random = random.Random(seed)
        self.wholes = {}  # name -> (seconds, files, contents)
        self.slow = 0
        self.counts = {}
        self.broken = []

    def start(self, command, out):
        source = subprocess.PIPE if command.stdin is not None else subprocess.DEVNULL
        process = subprocess.Popen(command.line(self.setting.program, out), env=self.setting.environment, stdin=source,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        if command.stdin is not None:
            try:
                process.stdin.write(command.stdin)
                process.stdin.close()
            except BrokenPipeError:
                pass
        return process

    def fresh(self, command, name):
        out = self.setting.scratch / name / command.name
        shutil.rmtree(out, ignore_errors=True)
        if command.prepare:
            command.prepare(out)
        return out

    def end_of(self, process):
        """Exit code; None if it had to be killed."""
        try:
            code = process.wait(hang)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            code = None
        self.said = process.stderr.read().decode(errors="replace")
        return code

    def whole(self, command):
        """Runs the command undisturbed once."""
        if command.name not in self.wholes:
            out = self.fresh(command, "whole")
            begin = time.monotonic()
            if command.endless:
                seconds = 0.6
            else:
                process = self.start(command, out)
                process.stdin = None
                process.communicate()
                code = process.returncode
                seconds = time.monotonic() - begin
                if code not in command.exits:
                    raise SystemExit(f"{command.name}: undisturbed exit code {code}")
            contents = {name: (out / name).read_bytes() for name in command.same}
            self.wholes[command.name] = (seconds, files_in(out), contents)
        return self.wholes[command.name]

    def trial(self, command):
        seconds, files, contents = self.whole(command)
        out = self.fresh(command, "trial")
        number = self.random.choice(ENDING)
        delay = self.random.uniform(0.0, 1.02 * seconds)
        problems = []
        process = self.start(command, out)
        time.sleep(delay)
        in_main = catches(process, number)
        process.send_signal(number)
        begin = time.monotonic()
        code = self.end_of(process)
        took = time.monotonic() - begin
        self.slow += took > 1.0
        left = files_in(out)
        if code is None:
            problems.append(f"still runs {hang:g} s after the signal")
        elif code == -number and not in_main:
            code = "before main"
        elif code != 130 and (code not in command.exits or not set(files) <= set(left)):
            problems.append(f"exit code {code}, files {left}, said {self.said!r}")
        self.counts[code] = self.counts.get(code, 0) + 1
        problems += faults_in(out, self.setting.scratch / "cases", self.setting.scratch / "cache")
        problems += [f"{f} is left in TMPDIR" for f in files_in(self.setting.scratch / "tmp")]
        shutil.rmtree(self.setting.scratch / "tmp")
        (self.setting.scratch / "tmp").mkdir()
        if not command.endless:
            problems += self.repeat(command, out, files, contents)
        for problem in problems:
            self.broken.append(f"{command.name}, {number.name} after {delay:.3f} s: {problem}")
        return code, took, delay, number

    def repeat(self, command, out, files, contents):
        if command.name == "subject-new":  # into an empty folder alone
            shutil.rmtree(out, ignore_errors=True)
        process = self.start(command, out)
        process.stdin = None
        said = process.communicate()[1].decode(errors="replace")
        code = process.returncode
        problems = [] if code in command.exits else [f"repeated: exit code {code}, {said!r}"]
        found = files_in(out)
        if command.name != "approve" and found != files or len(found) != len(files):
            problems.append(f"repeated: files {found}, not {files}")
        problems += [f"repeated: {name} differs" for name, data in contents.items()
                     if not (out / name).exists() or (out / name).read_bytes() != data]
        return problems + ["repeated: " + fault for fault in faults_in(out)]


def main():
    program, source, scratch = sys.argv[1:4]
    count = int(os.environ.get("PALPATE_SIGNAL_TRIALS", 30))
    seed = int(os.environ.get("PALPATE_SIGNAL_SEED", random.SystemRandom().randrange(10**6)))
    print(f"{count} trials, seed {seed}", flush=True)
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # a shell's background job ignores it, and so would its children
    setting = Setting(program, source, scratch)
    trials = Trials(setting, seed)
    commands = setting.commands()
    first = trials.random.randrange(len(commands))
    for n in range(count):
        command = commands[(first + n) % len(commands)]
        code, took, delay, number = trials.trial(command)
        print(f"{command.name:18} {number.name} after {delay:6.3f} s: {code}, {took:.3f} s later", flush=True)
    print("exit codes:", ", ".join(f"{code}: {n}" for code, n in sorted(trials.counts.items(), key=str)))
    print(f"{trials.slow} of {count} took more than a second; {len(trials.broken)} faults")
    for problem in trials.broken:
        print(problem)
    return 1 if trials.broken else 0


sys.exit(main())

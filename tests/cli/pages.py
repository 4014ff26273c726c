#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the commands of README.md and docs/ in the order of each page, as a reader would type them.

Usage: pages.py PALPATE SOURCE BINARY SCRATCH [PAGE...]
A command is a line of a block "sh" ("sh fails" must end with 1), or a code span that begins with a program and has
arguments. A span with a placeholder (SCENE, DIR, ...), or of names alone, is a form: its command and options must exist. A block that begins
with #! is written to the file that its second line names. Comments of
the page above a block, paragraph or table say what the test cannot know. TEXT selects the commands that contain it:

    <!-- not run: REASON -->, <!-- not run (TEXT): REASON -->
    <!-- first: COMMAND -->              run before, to make what the page assumes
    <!-- instead (TEXT): OTHER -->       OTHER replaces TEXT, mostly to make a run shorter
    <!-- ends with (TEXT): 0 1 3 -->     exit codes; 0 if left out
    <!-- prints (TEXT): EXPRESSION -->   a line of the output matches it
    <!-- serves (TEXT): EXPRESSION -->   ends only by a signal; interrupted when a line matches
    <!-- file: NAME -->                  the block is the content of this file
"""

import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path

palpate, source, binary, scratch = (Path(word).resolve() for word in sys.argv[1:5])
pages = [Path(word) for word in sys.argv[5:]] or [Path("README.md"), *sorted(
    path.relative_to(source) for path in (source / "docs").glob("*.md"))]
processor_seconds = 120.0
kinds = ("not run", "first", "instead", "ends with", "prints", "serves", "file")
programs = r"(?:\w+=\S+ )?(?:build/release/|root/usr/bin/)?palpate|scripts/[\w-]+|cmake|cpack|ctest|python3|octave|valgrind"
command_span = re.compile(rf"(?:{programs})\s+\S")
placeholder = re.compile(r"(?<![\w/.$-])[A-Z]{3,}(?![\w=/])|(?<![\w$-])[A-Z]{3,}$|\.\.\.|\bN\b|i/N|[A-Z]+\.(?:so|jsonl|csv)")
helps = {}


class Mark:
    def __init__(self, kind, selector, text):
        self.kind, self.selector, self.text, self.used = kind, selector, text, False

    def selects(self, command):
        return not self.selector or self.selector in command


class Failure(Exception):
    pass


def marks_of(line):
    found = []
    for comment in re.findall(r"<!--\s*(.*?)\s*-->", line):
        parts = re.fullmatch(r"([a-z ]+?)(?: \((.*?)\))?:\s*(.+)", comment)
        if not parts or parts[1] not in kinds or (parts[1] == "instead" and not parts[2]):
            raise Failure(f"unknown comment: {comment}")
        found.append(Mark(parts[1], parts[2], parts[3]))
    return found


def blocks_of(page):
    """(line number, "sh" or another language or "span", lines, marks) of blocks, paragraphs and tables in order."""
    marks, block, language, begin, text = [], None, None, 0, []
    for number, line in enumerate([*(source / page).read_text().splitlines(), ""], 1):
        fence, comment = line.startswith("```"), re.fullmatch(r"<!--.*-->", line)
        if block is not None:
            if line == "```":
                yield begin, language, block, marks
                marks, block = [], None
            else:
                block.append(line)
            continue
        if text and (fence or comment or not line.strip()):
            spans = [s for s in re.findall(r"`([^`]+)`", " ".join(text)) if command_span.match(s)]
            if spans or marks:
                yield begin, "span", spans, marks
            marks, text = [], []
        if fence:
            block, language, begin = [], line[3:], number
        elif comment:
            marks += marks_of(line)
        elif line.strip():
            begin = begin if text else number
            text.append(line)


def commands_of(lines):
    """Lines joined where they continue; what belongs to one shell construct stays together."""
    return [c for c in "\n".join(lines).replace("\\\n", " ").split("\n") if c.strip() and not c.strip().startswith("#")]


def check_form(command):
    """A form names a command and options that exist."""
    words = command.split()
    if "palpate" not in words[0]:
        if words[0].startswith("scripts/") and not (source / words[0]).is_file():
            raise Failure(f"{words[0]} does not exist")
        return
    for depth in (2, 1):
        name = " ".join(words[1:1 + depth])
        if name not in helps:
            done = subprocess.run([palpate, "help", *name.split()], capture_output=True, text=True)
            helps[name] = done.stdout if done.returncode == 0 and re.fullmatch(r"[a-z -]+", name) else None
        if helps[name] is not None:
            break
    else:
        raise Failure(f"{command}: no such command")
    for option in re.findall(r"(?<!\S)--?[a-z][\w-]*", command):
        if not re.search(rf"(?<![\w-]){option}(?![\w-])", helps[name]):
            raise Failure(f"{command}: no option {option}")


class Folder:
    """What a reader has: the project with its build, and palpate on the PATH."""

    def __init__(self, page):
        self.path = scratch / str(page).removesuffix(".md").replace("/", "-")
        shutil.rmtree(self.path, ignore_errors=True)
        (self.path / "build").mkdir(parents=True)
        for name in ("fixtures", "examples", "scripts", "tests", "docs"):
            (self.path / name).symlink_to(source / name)
        (self.path / "build/release").symlink_to(binary)
        (self.path / "palpate").symlink_to(source)
        (self.path / "bin").mkdir()
        (self.path / "bin/python3").symlink_to(sys.executable)  # the one that has the modules of Debian's packages
        self.home = self.path / "home"
        self.home.mkdir()
        self.here = self.path
        self.environment = {k: v for k, v in os.environ.items() if not k.startswith(("PALPATE_", "XDG_"))} | {
            "HOME": str(self.home), "XDG_CACHE_HOME": str(scratch / "cache"), "MPLBACKEND": "Agg", "DISPLAY": "",
            "PATH": f"{self.path}/bin:{palpate.parent}:{os.environ['PATH']}"}

    def run(self, command, serves=None):
        """Exit code and output of a line of shell; a change of folder is kept."""
        script = f"{command}\ncode=$?\npwd > '{self.path}/here'\nexit $code"
        child = subprocess.Popen(["bash", "-c", f"exec {command}" if serves else script], cwd=self.here, env=self.environment,
                                 stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        limit = threading.Timer(600, child.kill)
        limit.start()
        said, served = "", False
        for line in child.stdout:
            said += line
            if serves and not served and re.search(serves, line):
                served = True
                child.send_signal(signal.SIGINT)
        code = child.wait()
        limit.cancel()
        if serves and served and code == 130:
            code = 0
        elif serves:
            raise Failure(f"{command}\nended with {code} before it printed {serves}:\n{said[-3000:]}")
        if not serves and (self.path / "here").exists():
            self.here = Path((self.path / "here").read_text().strip())
        return code, said


def run_commands(folder, commands, marks, expected):
    """Numbers of commands that were run and that were not."""
    ran = skipped = 0
    for command in commands:
        mine = [m for m in marks if m.selects(command)]
        for mark in mine:
            mark.used = True
        if any(m.kind == "not run" for m in mine):
            skipped += 1
            continue
        changed = command
        for mark in mine:
            if mark.kind == "instead":
                changed = changed.replace(mark.selector, mark.text)
        allowed = next((list(map(int, m.text.split())) for m in mine if m.kind == "ends with"), expected)
        serves = next((m.text for m in mine if m.kind == "serves"), None)
        before = spent()
        code, said = folder.run(changed, serves)
        if code not in allowed:
            raise Failure(f"{changed}\nended with {code}, expected {allowed}:\n{said[-3000:]}")
        for mark in mine:
            if mark.kind == "prints" and not re.search(mark.text, said, re.MULTILINE):
                raise Failure(f"{changed}\ndoes not print {mark.text}:\n{said[-3000:]}")
        ran += 1
        if spent() - before > 3:
            print(f"    {spent() - before:.1f} s: {changed}", flush=True)
    return ran, skipped


def follow(page):
    folder = Folder(page)
    ran = skipped = forms = 0
    for number, language, lines, marks in blocks_of(page):
        try:
            for mark in (m for m in marks if m.kind == "first"):
                mark.used = True
                code, said = folder.run(mark.text)
                if code != 0:
                    raise Failure(f"{mark.text}\nended with {code}:\n{said[-3000:]}")
            file = next((m for m in marks if m.kind == "file"), None)
            named = re.match(r"# ([\w./-]+):", lines[1]) if len(lines) > 1 and lines[0].startswith("#!") else None
            if file or named:
                path = folder.here / (file.text if file else named[1])
                path.parent.mkdir(parents=True, exist_ok=True)
                text = "\n".join(lines) + "\n"
                for mark in marks:
                    if mark.kind == "instead" and mark.selects(text):
                        text, mark.used = text.replace(mark.selector, mark.text), True
                path.write_text(text)
                if named:
                    path.chmod(0o755)
                if file:
                    file.used = True
            elif language in ("sh", "sh fails"):
                done = run_commands(folder, commands_of(lines), marks, [0] if language == "sh" else [1])
                ran, skipped = ran + done[0], skipped + done[1]
            elif language == "span":
                for span in lines:
                    marked = any(m.kind not in ("first", "file") and m.selects(span) for m in marks)
                    name = re.fullmatch(r"(?:build/release/)?palpate [a-z]+( [a-z]+)?( --[a-z-]+( [\d.]+)?)*|ctest .*", span)
                    if not marked and (name or placeholder.search(span)):
                        check_form(span)
                        forms += 1
                    else:
                        done = run_commands(folder, [span], marks, [0])
                        ran, skipped = ran + done[0], skipped + done[1]
            for mark in marks:
                if not mark.used:
                    raise Failure(f"a comment without a command: {mark.kind}: {mark.text}")
        except Failure as failure:
            raise Failure(f"{page}:{number}: {failure}") from None
    return ran, skipped, forms


def spent():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main():
    failures, total = [], [0, 0, 0]
    for page in pages:
        before = spent()
        try:
            counts = follow(page)
            total = [a + b for a, b in zip(total, counts)]
            if any(counts):
                print(f"{page}: {counts[0]} commands run, {counts[1]} not, {counts[2]} forms checked, "
                      f"{spent() - before:.1f} s of processor time", flush=True)
        except Failure as failure:
            failures.append(str(failure))
            print(f"FAILED {failure}", flush=True)
    print(f"{total[0]} commands run, {total[1]} not, {total[2]} forms checked, {spent():.1f} s of processor time")
    if len(sys.argv) == 5 and total[0] < 60:
        failures.append("fewer than 60 commands were found")
    if spent() > processor_seconds:
        failures.append(f"more than {processor_seconds} s of processor time")
        print(f"FAILED {failures[-1]}")
    return 1 if failures else 0


sys.exit(main())

# SPDX-License-Identifier: MIT
"""Measures `palpate live` beside viewers, for docs/live.md: the loop with no viewer, one, four, and one that never reads.
The cases take turns, so that other work on the machine meets all of them. OUT.html has the distributions side by side:
response (release to end of work), work (begin to end) and processor time of the loop's thread, and the worst period of a
round: its median over the rounds, and how much viewers change that median. OUT.json has the numbers. It judges nothing.

usage: live_load.py PALPATE SCENE OUT [--seconds S] [--rounds N] [--minutes M] [--set KEY=VALUE ...]

--minutes measures resident memory every minute and the loop against the clock, with one viewer.
"""

import csv
import glob
import html
import json
import math
import os
import platform
import random
import statistics
import sys
import threading
import time

from live import Live, Viewer

CASES = (("no viewer", 0, 0), ("one viewer", 1, 0), ("four viewers", 4, 0), ("one that never reads", 0, 1))
SHARES = (("median", 0.5), ("99 %", 0.99), ("99.9 %", 0.999), ("99.99 %", 0.9999), ("worst", 1.0))
KINDS = (("response", "Response time: from the release of a period to the end of its work"),
         ("work", "Work: from the begin of a period to its end, interruptions included"),
         ("processor", "Processor time of the loop's thread for a period, mean of 0.1 s"))


def option(name, otherwise):
    return float(sys.argv[sys.argv.index(name) + 1]) if name in sys.argv else otherwise


def overrides():
    return [word for n, word in enumerate(sys.argv) if word == "--set" or sys.argv[n - 1] == "--set"]


def look(viewer, seconds, found):
    """Counts frames for some seconds."""
    begin = time.monotonic()
    frames = 0
    while time.monotonic() < begin + seconds:
        state = viewer.state()
        frames += 1
    found.append((frames / (time.monotonic() - begin), state["dropped"]))


def thread_of(process):
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline:
        for path in glob.glob(f"/proc/{process.pid}/task/*/comm"):
            with open(path) as file:
                if file.read().strip() == "loop":
                    return os.path.dirname(path)
        time.sleep(0.01)
    raise SystemExit("no thread of the loop")


def watch_processor(thread, over, found):
    """Share of a processor that a thread uses, every 0.1 s."""
    def used():
        with open(thread + "/schedstat") as file:
            return int(file.read().split()[0])

    begin, before = time.monotonic(), used()
    while not over.wait(0.1):
        now, after = time.monotonic(), used()
        found.append(1e-9 * (after - before) / (now - begin))
        begin, before = now, after


def run(palpate, scene, out, count, deaf, seconds):
    live = Live(palpate, scene, out, "--no-record", *overrides())
    viewers = [Viewer(live) for _ in range(count)]
    silent = [Viewer(live, buffer=4096) for _ in range(deaf)]
    frames, processor, over = [], [], threading.Event()
    threads = [threading.Thread(target=look, args=(each, seconds, frames)) for each in viewers]
    threads.append(threading.Thread(target=watch_processor, args=(thread_of(live.process), over, processor)))
    for each in threads:
        each.start()
    time.sleep(seconds)
    over.set()
    for each in threads:
        each.join()
    live.end()
    del silent
    with open(out + "/summary.json") as file:
        summary = json.load(file)
    with open(out + "/times.csv", newline="") as file:
        return summary, list(csv.DictReader(file)), frames, processor


class Case:
    """What the rounds of one case found."""

    def __init__(self):
        self.bins = {"response": {}, "work": {}, "processor": {}}  # begin [us]: count
        self.worst = dict.fromkeys(self.bins, 0.0)
        self.worsts = {"response": [], "work": []}  # of each round
        self.periods = self.missed = self.dropped = 0
        self.frames = []

    def add(self, summary, times, frames, processor):
        for kind in ("response", "work"):
            for row in times:
                begin, count = int(row["time_us"]), int(row[kind])
                self.bins[kind][begin] = self.bins[kind].get(begin, 0) + count
            self.worsts[kind].append(summary[kind + "_us"]["worst"])
            self.worst[kind] = max(self.worsts[kind])
        for share in processor:
            value = 1e6 * share * summary["period_s"]
            self.bins["processor"][int(value)] = self.bins["processor"].get(int(value), 0) + 1
            self.worst["processor"] = max(self.worst["processor"], value)
        self.periods += summary["periods"]
        self.missed += summary["missed"]
        self.frames += [rate for rate, _ in frames]
        self.scheduling = summary["scheduling"]

    def at(self, kind, share):
        """Time that a share of the periods does not exceed [us]; None of too few."""
        if share == 1.0:
            return self.worst[kind]
        total = sum(self.bins[kind].values())
        if total * (1.0 - share) < 1.0:
            return None
        seen = 0
        for begin in sorted(self.bins[kind]):
            seen += self.bins[kind][begin]
            if seen >= share * total:
                return min(begin + 1.0, self.worst[kind])


def histogram(case, kind, most):
    """Counts on a logarithmic scale over the time on a logarithmic scale, eight bars a factor of two."""
    width, height, left, bottom, parts = 300, 130, 8, 20, 8
    low = 3.0
    columns = int(parts * math.log2(most / low)) + 1
    bars = [0] * columns
    for begin, count in case.bins[kind].items():
        bars[min(columns - 1, max(0, int(parts * math.log2(max(begin + 0.5, low) / low))))] += count
    top = math.log10(max(bars) + 1)
    step = (width - 2 * left) / columns
    text = [f'<svg viewBox="0 0 {width} {height}" role="img" aria-label="histogram">']
    for n, count in enumerate(bars):
        if count:
            tall = max(1.5, (height - bottom - 6) * math.log10(count + 1) / top)
            text.append(f'<rect x="{left + n * step:.1f}" y="{height - bottom - tall:.1f}" width="{max(step - .6, .8):.1f}" '
                        f'height="{tall:.1f}"><title>{count} periods</title></rect>')
    decade = 10.0
    while decade < most:
        x = left + step * parts * math.log2(decade / low)
        words = f"{decade:.0f} \u00b5s" if decade < 1000 else f"{decade / 1000:.0f} ms"
        text.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="4" y2="{height - bottom}"/>'
                    f'<text x="{x:.1f}" y="{height - 6}">{words}</text>')
        decade *= 10
    return "".join(text + ["</svg>"])


def rows_of(cases, kind):
    for name, case in cases.items():
        times = [case.at(kind, share) for _, share in SHARES]
        yield [name] + ["-" if time is None else f"{time:.0f}" for time in times]


def change_of_worst(alone, beside):
    """Change of the median of the worsts of the rounds, with its 95 % interval by drawing rounds anew [us]."""
    draw = random.Random(1)

    def median(values):
        return statistics.median(draw.choices(values, k=len(values)))

    changes = sorted(median(beside) - median(alone) for _ in range(4000))
    return statistics.median(beside) - statistics.median(alone), changes[100], changes[-101]


def rows_of_worsts(cases):
    """For each kind and case: median, least and largest of the worsts of the rounds, change of the median."""
    for kind in ("work", "response"):
        alone = next(iter(cases.values())).worsts[kind]
        for name, case in cases.items():
            worsts = case.worsts[kind]
            change = "{:+.0f} ({:+.0f} to {:+.0f})".format(*change_of_worst(alone, worsts)) if worsts is not alone else "-"
            yield [f"{kind}, {name}", f"{statistics.median(worsts):.0f}", f"{min(worsts):.0f}", f"{max(worsts):.0f}", change]


def page(cases, scene, command):
    style = open(os.path.join(os.path.dirname(__file__), "../../reports/assets/report.css")).read()
    body = [f"<h1>Does a viewer disturb the loop?</h1><p class=soft>{html.escape(os.path.basename(scene))}, "
            f"{next(iter(cases.values())).scheduling}, {os.cpu_count()} processors, {html.escape(platform.release())}. "
            f"Numbers of periods are on a logarithmic scale.</p>"]
    for kind, title in KINDS:
        most = 2 * max(case.worst[kind] for case in cases.values())
        body.append(f"<h2>{title}</h2><div class=side>")
        for name, case in cases.items():
            body.append(f"<figure><figcaption>{name}</figcaption>{histogram(case, kind, most)}</figure>")
        body.append("</div><div class=wide><table><tr><th>\u00b5s</th>" + "".join(f"<th>{name}</th>" for name, _ in SHARES) + "</tr>")
        for row in rows_of(cases, kind):
            body.append("<tr><th>" + row[0] + "</th>" + "".join(f"<td>{cell}</td>" for cell in row[1:]) + "</tr>")
        body.append("</table></div>")
    body.append("<h2>Counts</h2><div class=wide><table><tr><th></th><th>periods</th><th>missed</th><th>frames a second</th></tr>")
    for name, case in cases.items():
        rates = f"{min(case.frames):.1f} to {max(case.frames):.1f}" if case.frames else "-"
        body.append(f"<tr><th>{name}</th><td>{case.periods}</td><td>{case.missed}</td><td>{rates}</td></tr>")
    body.append("</table></div><h2>The worst period of a round</h2><div class=wide><table><tr><th>\u00b5s</th><th>median</th>"
                "<th>least</th><th>largest</th><th>change of the median, 95 % interval</th></tr>")
    for row in rows_of_worsts(cases):
        body.append("<tr><th>" + row[0] + "</th>" + "".join(f"<td>{cell}</td>" for cell in row[1:]) + "</tr>")
    body.append(f"</table></div><p class=soft>{html.escape(command)}</p>")
    return ('<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" '
            'content="width=device-width, initial-scale=1"><title>Does a viewer disturb the loop?</title><style>' + style +
            "body{max-width:1240px;margin:0 auto;padding:16px 20px 40px}.side{display:grid;gap:12px;"
            "grid-template-columns:repeat(auto-fit,minmax(230px,1fr))}figure{margin:0;background:var(--sheet);"
            "border-radius:10px;padding:8px 10px}svg{width:100%;height:auto;display:block}rect{fill:var(--series-0)}"
            "line{stroke:var(--grid)}text{font-size:9px;fill:var(--soft);text-anchor:middle}.wide{overflow-x:auto}"
            "td,th{padding:3px 12px 3px 0;text-align:right;font-variant-numeric:tabular-nums}th:first-child{text-align:left}"
            "</style></head><body>" + "".join(body) + "</body></html>\n")


def memory_of(process):
    with open(f"/proc/{process.pid}/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS"))


def watch_memory(palpate, scene, out, minutes):
    live = Live(palpate, scene, out, *overrides())
    viewer = Viewer(live)
    begin = viewer.state()
    clock = time.monotonic()
    for minute in range(minutes + 1):
        while time.monotonic() < clock + 60 * minute:
            state = viewer.state()
        print(f"minute {minute}: {memory_of(live.process)} kB", flush=True)
    elapsed = time.monotonic() - clock
    print(f"{state['periods'] - begin['periods']} periods in {elapsed:.3f} s, {state['missed']} missed, "
          f"{state['torn']} torn, {state['lost_rows']} rows lost")
    live.end()
    print(live.text.strip())


def main():
    palpate, scene, out = sys.argv[1:4]
    seconds, rounds, minutes = option("--seconds", 10), int(option("--rounds", 3)), int(option("--minutes", 0))
    cases = {name: Case() for name, _, _ in CASES}
    for n in range(rounds if seconds > 0 else 0):
        for name, count, deaf in CASES:
            cases[name].add(*run(palpate, scene, f"{out}-{count}-{deaf}", count, deaf, seconds))
    if seconds > 0:
        for kind, title in KINDS:
            print(f"{title} [us]\n" + "\n".join(", ".join(row) for row in rows_of(cases, kind)))
        for name, case in cases.items():
            rates = f", frames a second {min(case.frames):.1f} to {max(case.frames):.1f}" if case.frames else ""
            print(f"{name}: {case.missed} of {case.periods} missed{rates}")
        print("Worst period of a round [us]: median, least, largest, change of the median (95 % interval)")
        print("\n".join(", ".join(row) for row in rows_of_worsts(cases)))
        with open(out + ".html", "w") as file:
            file.write(page(cases, scene, " ".join(["live_load.py"] + [os.path.basename(word) for word in sys.argv[2:]])))
        with open(out + ".json", "w") as file:
            json.dump({name: {kind: {label: case.at(kind, share) for label, share in SHARES} for kind, _ in KINDS}
                       | {"worst_of_rounds": case.worsts} for name, case in cases.items()}, file, indent=2)
        print(out + ".html")
    if minutes:
        watch_memory(palpate, scene, out + "-memory", minutes)


if __name__ == "__main__":
    main()

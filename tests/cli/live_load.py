# SPDX-License-Identifier: MIT
"""Measures `palpate live` beside viewers, for docs/live.md: response times of the loop with no viewer, one, four, and one
that never reads; frames that arrive; resident memory every minute. It judges nothing.

usage: live_load.py PALPATE SCENE OUT [--seconds S] [--minutes M] [--set KEY=VALUE ...]
"""

import json
import sys
import threading
import time

from live import Live, Viewer


def option(name, otherwise):
    return float(sys.argv[sys.argv.index(name) + 1]) if name in sys.argv else otherwise


def overrides():
    return [word for n, word in enumerate(sys.argv) if word == "--set" or sys.argv[n - 1] == "--set"]


def look(viewer, seconds, found):
    """Counts frames and their bytes for some seconds."""
    end = time.monotonic() + seconds
    frames = 0
    begin = time.monotonic()
    while time.monotonic() < end:
        state = viewer.state()
        frames += 1
    found.append((frames / (time.monotonic() - begin), state["dropped"]))


def run(palpate, scene, out, count, deaf, seconds):
    live = Live(palpate, scene, out, "--no-record", *overrides())
    viewers = [Viewer(live) for _ in range(count)]
    silent = [Viewer(live, buffer=4096) for _ in range(deaf)]
    found = []
    threads = [threading.Thread(target=look, args=(each, seconds, found)) for each in viewers]
    for each in threads:
        each.start()
    time.sleep(seconds)
    for each in threads:
        each.join()
    live.end()
    del silent
    with open(out + "/summary.json") as file:
        return json.load(file), found, live.text.strip()


def memory_of(process):
    with open(f"/proc/{process.pid}/status") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS"))


def main():
    palpate, scene, out = sys.argv[1:4]
    seconds, minutes = option("--seconds", 30), int(option("--minutes", 0))
    print("viewers, median, 99 %, 99.9 %, worst response [us], missed of periods, frames a second, dropped", flush=True)
    for name, count, deaf in (("none", 0, 0), ("one", 1, 0), ("four", 4, 0), ("one that never reads", 0, 1)):
        if seconds <= 0:
            break
        summary, found, text = run(palpate, scene, f"{out}-{count}-{deaf}", count, deaf, seconds)
        times = summary["response_us"]
        print(name, *(f"{times[key] or 0:.0f}" for key in ("median", "p99", "p99_9", "worst")),
              f"{summary['missed']} of {summary['periods']}", [f"{rate:.1f}" for rate, _ in found], text.split(";")[-1],
              sep=", ", flush=True)
    if minutes:
        live = Live(palpate, scene, out + "-memory", *overrides())
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


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: MIT
"""Draws the force on the tool over its depth, with the events of a run.

    palpate run fixtures/scenes/epidural.toml
    python3 examples/force_over_depth.py palpate-out/run force.png

Needs h5py and matplotlib (Debian: python3-h5py python3-matplotlib)."""

import sys
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

if len(sys.argv) != 3:
    sys.exit(__doc__)
run, picture = Path(sys.argv[1]), sys.argv[2]

with h5py.File(run / "trace.h5") as file:
    trace = file["trace"]
    depth = 1e3 * trace["tool.depth_m"][:]
    force = trace["tool.force_n"][:]
    time = trace["time_s"][:]
    # Texts of the tick: what happened, and the layer that the tip is in.
    event = [text.decode() for text in trace["tool.event"][:]]

figure, axes = plt.subplots(figsize=(7, 4))
axes.plot(depth, force, linewidth=1.2)
for row, text in enumerate(event):
    if text:
        axes.axvline(depth[row], color="grey", linewidth=0.6)
        axes.annotate(text, (depth[row], force.max()), rotation=90, fontsize=7, va="top", ha="right")
axes.set_xlabel("depth (mm)")
axes.set_ylabel("force on the tool (N)")
figure.tight_layout()
figure.savefig(picture, dpi=150)

peak = force.argmax()
print(f"peak force {force[peak]:.6g} N at {depth[peak]:.6g} mm, t = {time[peak]:.6g} s; {picture}")

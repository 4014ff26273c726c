# SPDX-License-Identifier: MIT
"""Lists the quantities of results.json that are nearest to their bounds, worst first.

    palpate validate --quick
    python3 examples/tightest_claims.py palpate-out/validate/results.json 10

Needs nothing beyond Python."""

import json
import sys

if len(sys.argv) not in (2, 3):
    sys.exit(__doc__)
with open(sys.argv[1], encoding="utf-8") as file:
    results = json.load(file)
most = int(sys.argv[2]) if len(sys.argv) == 3 else 10


def used_share(quantity):
    """Share of the bound that is used: an error over its bound; else 0 in the middle of an interval, 1 at its ends; None without a size."""
    value, lower, upper = quantity["value"], quantity["lower"], quantity["upper"]
    if value is None:
        return float("inf")
    if upper is not None and lower in (None, 0.0) and upper > 0.0:
        return value / upper
    if lower is not None and upper is not None and upper > lower:
        return abs(2.0 * value - lower - upper) / (upper - lower)
    return None


rows = []
for case in results["cases"]:
    for quantity in case.get("quantities", []):
        share = used_share(quantity)
        if quantity["status"] != "info" and share is not None:
            rows.append((share, case["name"], quantity))
rows.sort(key=lambda row: -row[0])
for share, name, quantity in rows[:most]:
    print(f"{100 * share:8.2f} %  {quantity['status']:4}  {name}: {quantity['name']} = {quantity['value']:.4g} {quantity['unit']}")
print(f"{len(results['cases'])} cases, {sum(case['status'] == 'fail' for case in results['cases'])} failed")

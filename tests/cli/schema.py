#!/usr/bin/env python3
"""schema.py PROGRAM FIXTURES: `palpate schema` accepts every shipped scene and refuses errors of single keys."""
import json
import pathlib
import subprocess
import sys
import tomllib

try:
    import jsonschema
except ImportError:
    print("skipped: python3-jsonschema is not installed")
    sys.exit(0)

program, fixtures = sys.argv[1], pathlib.Path(sys.argv[2])
schema = json.loads(subprocess.run([program, "schema"], check=True, capture_output=True).stdout)
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)


def errors(path):
    return [f"{path}: {e.json_path}: {e.message}" for e in validator.iter_errors(tomllib.loads(path.read_text()))]


scenes = [p for p in [*fixtures.glob("scenes/**/*.toml"), *fixtures.glob("init/*.toml")] if p.parent.name != "invalid"]
assert len(scenes) > 25, scenes
problems = [line for path in scenes for line in errors(path)]

# Errors that one key, or two keys of one table, show. Relations between tables are beyond a schema.
refused = """damping-twice fraction-for-count gauge-and-diameter key-of-another-table layer-not-a-list load-nowhere
load-twice-placed missing-modulus negative-spacing number-for-table one-node record-name-with-comma seven-neighbours
short-vector text-for-number unknown-face unknown-gauge unknown-key unknown-table zero-substeps""".split()
for name in refused:
    if not errors(fixtures / "scenes/invalid" / f"{name}.toml"):
        problems.append(f"{name}: accepted")


def undescribed(node, path):
    for name, inner in node.get("properties", {}).items():
        inner = inner.get("items", inner) if "properties" in inner.get("items", {}) else inner
        if "properties" in inner:
            yield from undescribed(inner, f"{path}{name}.")
        elif len(inner.get("description", "")) < 5:
            yield f"{path}{name}: no description"


problems += undescribed(schema, "")
sys.exit("\n".join(problems) or 0)

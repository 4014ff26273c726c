#!/usr/bin/env bash
# init.sh PROGRAM SCRATCH: what `palpate init` writes can be inspected and run, and nothing is overwritten.
set -euo pipefail
palpate=$1
out=$2
fail() { echo "$*" >&2; exit 1; }
rm -rf "$out"
mkdir -p "$out"
cd "$out"
PATH="$(dirname "$palpate"):$PATH"

for kind in needle palpation mri mesh; do
  palpate init "$kind" --out "my $kind" >said
  palpate inspect "my $kind/scene.toml" >inspected || fail "$kind cannot be inspected"
  # The last line is the next command; a short run of it.
  next=$(tail -n 1 said)
  [[ $next == "palpate run "* ]] || fail "$kind: the last line is no command: $next"
  eval "$next --set simulation.duration=0.05 --out 'ran $kind'" >ran || fail "$kind does not run"
  grep -q '^ok: ' ran || fail "$kind: $(cat ran)"
  [ -s "ran $kind/report.html" ] || fail "$kind has no page"
done
# The first scenes of a newcomer run without a warning.
for kind in needle palpation mri; do
  palpate inspect "my $kind/scene.toml" --json | grep -q '"warnings": \[\]' || fail "$kind has warnings"
done

palpate init subject --out mine >said
[ -s mine/subject.c ] && [ -s mine/CMakeLists.txt ] || fail "no skeleton"
tail -n 1 said | grep -q 'palpate subject check' || fail "no next command"

echo "title = \"mine\"" >"my needle/scene.toml"
status=0
palpate init needle --out "my needle" 2>refused || status=$?
[ "$status" -eq 2 ] || fail "exit $status of a folder in use"
grep -q '^palpate: my needle: exists' refused || fail "$(cat refused)"
grep -q 'mine' "my needle/scene.toml" || fail "a scene was overwritten"

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
  # The last line is the next command.
  next=$(tail -n 1 said)
  [[ $next == "palpate run "* ]] || fail "$kind: the last line is no command: $next"
  # The first scenes of a newcomer run to their end without a warning; without one of the page either.
  eval "$next --out 'ran $kind'" >ran 2>&1 || fail "$kind does not run: $(cat ran)"
  grep -q '^ok: ' ran || fail "$kind: $(cat ran)"
  if grep -q 'warning' ran; then fail "$kind: $(cat ran)"; fi
  grep -q '"warnings": \[\]' "ran $kind/summary.json" || fail "$kind has warnings"
  [ -s "ran $kind/report.html" ] || fail "$kind has no page"
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

# A folder whose name begins as an option does: the next command that is printed runs.
next=$("$palpate" init needle --out=-folder --quiet)
[ "$next" = "palpate run ./-folder/scene.toml" ] || { echo "$next"; exit 1; }

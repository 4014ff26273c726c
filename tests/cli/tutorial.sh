#!/usr/bin/env bash
# Runs every block of commands of docs/tutorial.md in order. A block "sh fails" must end with 1.
#   tutorial.sh PALPATE SOURCE SCRATCH
set -euo pipefail
palpate=$1
source=$2
scratch=$3
rm -rf "$scratch"
mkdir -p "$scratch/bin" "$scratch/work"
ln -s "$palpate" "$scratch/bin/palpate"
ln -s "$source/fixtures" "$scratch/work/fixtures"
export PATH="$(dirname "$palpate"):$scratch/bin:$PATH" XDG_CACHE_HOME="$scratch/cache"

awk '
  /^```sh fails$/ { print "expect_failure() {"; inside = 1; next }
  /^```sh$/ { inside = 2; next }
  /^```$/ { if (inside == 1) print "}\nif expect_failure; then echo \"tutorial: no failure\"; exit 9; fi"
            inside = 0; next }
  inside { print }
' "$source/docs/tutorial.md" > "$scratch/steps.sh"
[ "$(grep -c '^palpate' "$scratch/steps.sh")" -ge 8 ] || { echo "tutorial: too few commands were found"; exit 1; }

cd "$scratch/work"
bash -euo pipefail "$scratch/steps.sh" > "$scratch/log" 2>&1 || { tail -40 "$scratch/log"; exit 1; }
must() { grep -Eq "$1" "$scratch/log" || { echo "tutorial: not found: $1"; tail -40 "$scratch/log"; exit 1; }; }
must "18 of 29 cases judged"
must "18 passed, 0 failed, 11 skipped of 29"
must "regressed"

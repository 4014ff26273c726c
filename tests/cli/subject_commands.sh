#!/usr/bin/env bash
# calibrate and certify with a simulator under test: the model behind the interface gives the same fit, and ticks of
# other processes are timed with their carrier.
set -euo pipefail
palpate=$1 root=$2 out=$3 library=$4 recordings=$5 faulty=$6
rm -rf "$out"
mkdir -p "$out"
fail() { echo "$1"; exit 1; }
scenes=$root/fixtures/scenes

if [ -f "$library" ]; then
  quick=("$recordings/bmi-25-continuous-01.h5" "$recordings/bmi-25-continuous-02.h5"
         --scene "$scenes/epidural-bmi-30.toml" --set 'tissue.layers.nodes=[3,3]' --set tissue.layers.spacing=0.02
         --set simulation.step=4e-3 --parameter syringe.thumb_force --quiet)
  "$palpate" calibrate "${quick[@]}" --out "$out/here" || [ $? -eq 1 ]
  "$palpate" calibrate "${quick[@]}" --subject "$library" --out "$out/there" || [ $? -eq 1 ]
  cmp "$out/here/fitted.toml" "$out/there/fitted.toml" || fail "the model behind the interface gives another fit"
  grep -q "subject carrier" "$out/there/report.html" || fail "the page does not name the simulator"
  ! grep -q "subject carrier" "$out/here/report.html" || fail "the page names a simulator without one"
fi

# Measured insertions: the same fit, and the simulator cannot read what it is to reproduce.
if [ -f "$library" ]; then
  sed -e 's/^nodes = .*/nodes = [5, 5]/; s/^spacing = .*/spacing = 0.01/; s/^frames = .*/frames = 0/' \
    "$scenes/phantom-muscle.toml" >"$out/coarse.toml"
  for friction in 175 185; do
    "$palpate" run "$out/coarse.toml" --set "material.phantom-muscle.friction=$friction" --out "$out/run" --quiet 2>/dev/null
    "$palpate" import "$out/run/trace.csv" --column tool.depth_m=depth_m --column tool.force_n=force_N \
      --subject "$friction" --out "$out/import" --quiet
    mv "$out/import/recording.h5" "$out/twin-$friction.h5"
  done
  fitted() {
    "$palpate" calibrate --condition "$out/coarse.toml" "$out"/twin-*.h5 --parameter material.phantom-muscle.friction \
      --out "$1" --quiet "${@:2}" 2>"$out/said" || [ $? -eq 1 ] || fail "calibrate --condition: $(cat "$out/said")"
  }
  fitted "$out/model"
  fitted "$out/other" --subject "$library"
  cmp "$out/model/coarse-fitted.toml" "$out/other/coarse-fitted.toml" || fail "a condition gets another fit behind the interface"
  grep -q "subject carrier" "$out/other/report.html" || fail "the page of a condition does not name the simulator"
fi
# A simulator cannot read earlier results where the kernel can prevent it; the run says which.
if [ -f "$faulty" ]; then
  mkdir -p "$out/peek"
  echo answer >"$out/peek/answer.csv"
  status=0
  "$palpate" run "$scenes/s26.toml" --subject "$faulty" --out "$out/peek" \
    --subject-options "{\"fault\": \"peek\", \"file\": \"$out/peek/answer.csv\"}" 2>"$out/said" || status=$?
  [ "$status" -ne 0 ] && grep -qE "answer.csv (was read|Permission denied)" "$out/said" || fail "peek: $status, $(cat "$out/said")"
  if grep -q "was read" "$out/said"; then
    "$palpate" run "$scenes/s26.toml" --subject "$faulty" --out "$out/sound" --quiet
    grep -q "confined" "$out/sound/report.html" && fail "a simulator that is said to be confined reads earlier results"
  fi
fi
# A simulator that ends leaves what it did until then.
if [ -f "$faulty" ]; then
  status=0
  timeout 60 "$palpate" live "$scenes/s26.toml" --ordinary --subject "$faulty" --subject-options '{"fault": "exit"}' \
    --out "$out/ended" >"$out/said" 2>"$out/error" || status=$?
  [ "$status" -eq 1 ] || fail "live with a simulator that ends: exit $status, $(cat "$out/error")"
  grep -q '"status": "failed"' "$out/ended/summary.json" || fail "live: $(ls "$out/ended")"
  # A run that fails leaves nothing of an earlier one in its folder.
  "$palpate" run "$scenes/s26.toml" --quiet --no-view --out "$out/again"
  status=0
  "$palpate" run "$scenes/s26.toml" --subject "$faulty" --subject-options '{"fault": "exit"}' --quiet --out "$out/again" \
    2>"$out/error" || status=$?
  [ "$status" -eq 1 ] && [ -z "$(ls "$out/again")" ] || fail "after a failed run: $status, $(ls "$out/again")"
fi
status=0
printf 'time_s,tip.z_m\n0,0\n0.1,0.001\n' >"$out/a.csv"
"$palpate" validate --subject "trace:$out/a.csv" --out "$out/every" 2>"$out/said" || status=$?
[ "$status" -eq 2 ] && grep -q "a trace answers the scene of one" "$out/said" || fail "a trace is judged by every case: $status"
status=0
"$palpate" calibrate "$recordings/bmi-25-continuous-01.h5" --scene "$scenes/epidural-bmi-30.toml" --quiet \
  --subject "exec:python3 $root/fixtures/subjects/python/adapter.py" --out "$out/none" 2> "$out/said" || status=$?
[ "$status" -eq 2 ] && grep -q "does not declare: tool-needle syringe" "$out/said" ||
  fail "a simulator without a needle: exit $status, $(cat "$out/said")"
[ ! -e "$out/none" ] || fail "a calibration that cannot be made leaves a folder"

certified() {  # folder, subject, carrier: a certificate that names the carrier and its control
  local status=0
  "$palpate" certify "$scenes/network-example/scene.toml" --ordinary --quiet --subject "$2" --out "$1" || status=$?
  [ "$status" -eq 0 ] || [ "$status" -eq 1 ] || [ "$status" -eq 3 ] || fail "certify --subject $2: exit $status"
  grep -q "$3; a tick includes" "$1/certificate.json" || fail "no carrier in $1/certificate.json"
  grep -q "an empty call takes" "$1/certificate.json" || fail "no control in $1/certificate.json"
}
certified "$out/pipe" "exec:python3 $root/fixtures/subjects/python/adapter.py" pipe
[ ! -f "$library" ] || certified "$out/host" "$library" "shared library"
status=0
"$palpate" certify "$scenes/s26.toml" --subject trace:a.csv --out "$out/trace" 2> "$out/said" || status=$?
[ "$status" -eq 2 ] && grep -q "a trace has no timing" "$out/said" || fail "a trace was certified: exit $status"

# A simulator is not the model in the program, whatever its name is.
if [ -f "$library" ]; then
  "$palpate" run "$scenes/s26.toml" --subject "$library" --out "$out/behind" --quiet --no-view --set simulation.duration=0.02
  "$palpate" approve "$out/behind" --baseline "$out/behind.json" --reason first --quiet
  status=0
  "$palpate" gate "$out/behind" --baseline "$out/behind.json" --subject model --out "$out/gate" 2>"$out/said" || status=$?
  [ "$status" -eq 2 ] && grep -q "behind the interface of subjects; --subject is the model" "$out/said" ||
    fail "a subject passes as the model: $status, $(cat "$out/said")"
fi

# dlopen() would wait for ever at a FIFO.
mkfifo "$out/fifo.so"
status=0
timeout 60 "$palpate" run "$scenes/s26.toml" --subject "$out/fifo.so" --out "$out/fifo" 2>"$out/said" || status=$?
[ "$status" -eq 2 ] && grep -q "fifo.so: .*a shared library" "$out/said" || fail "a FIFO: $status, $(cat "$out/said")"

# A state that diverges ends the run, with what came before it; a diverged answer may be empty.
adapter=$root/fixtures/subjects/python/adapter.py
sed 's/        finite = .*/        finite = struct.unpack_from("<d", request)[0] < 0.0095/' "$adapter" >"$out/diverges.py"
grep -q "< 0.0095" "$out/diverges.py" || fail "the adapter has another form"
status=0
"$palpate" run "$scenes/s26.toml" --subject "exec:python3 $out/diverges.py" --out "$out/diverged" --quiet \
  --set 'tissue.lattice.nodes=[3,3,3]' --set 'load.0.nodes=[26]' --set record.0.node=26 2>"$out/said" || status=$?
[ "$status" -eq 1 ] && grep -q '"diverged"' "$out/diverged/summary.json" || fail "a diverged state: $status, $(cat "$out/said")"
[ "$(wc -l <"$out/diverged/trace.csv")" -ge 10 ] || fail "the rows before the divergence are not kept"
# An answer that goes on after what it must hold is of another interface.
long_answer() {  # expression of sed for the adapter, expected message
  sed "$1" "$adapter" >"$out/long.py"
  cmp -s "$adapter" "$out/long.py" && fail "the adapter has another form: $1"
  status=0
  "$palpate" run "$scenes/s26.toml" --subject "exec:python3 $out/long.py" --out "$out/long" --quiet \
    --set 'tissue.lattice.nodes=[3,3,3]' --set 'load.0.nodes=[26]' --set record.0.node=26 2>"$out/said" || status=$?
  [ "$status" -ne 0 ] && grep -q "$2" "$out/said" || fail "$1: exit $status, $(cat "$out/said")"
}
long_answer 's/"MIT", "")/"MIT", "") + b"x"/' "gave an answer to hello that is 1 bytes too long"
long_answer 's/struct.pack("<d", math.nan)/struct.pack("<dd", math.nan, 0)/' "gave an answer to step that is 8 bytes too long"

# The list of known failures of the finite element subject holds.
elements=$(dirname "$faulty")/axisymmetric_subject.so
if [ -f "$elements" ]; then
  "$palpate" validate subject/needle subject/moved needle/bone haptics/falcon/groups haptics/falcon/overshoot --quick --subject "$elements" --quiet \
    --expected "$root/fixtures/subjects/axisymmetric/expected.toml" --out "$out/elements" || fail "other known failures"
fi

# Processes that a simulator leaves behind end with it, and a long reason is cut.
sed 's/            return UNSUPPORTED, text.*/            return FAILED, text("x" * 4000000)/; s/ != "none" or / == "none" or /' \
  "$adapter" >"$out/long.py"
status=0
"$palpate" run "$scenes/s26.toml" --out "$out/long" --subject "exec:sh -c 'sleep 86399 & exec python3 $out/long.py'" \
  2>"$out/said" || status=$?
[ "$status" -eq 2 ] || [ "$status" -eq 1 ] || fail "a long reason: exit $status"
grep -q "xxxx" "$out/said" && [ "$(wc -c <"$out/said")" -lt 4096 ] || fail "a reason of $(wc -c <"$out/said") bytes"
! grep -al "^sleep.86399" /proc/[0-9]*/cmdline >/dev/null 2>&1 || fail "a process of the simulator is left behind"

# A known failure has a reason and is listed once.
printf '[[failure]]\ncase = "oscillator/order/rk4"\nquantity = "observed_order"\nreason = "%s"\n' why " " >"$out/twice.toml"
status=0
"$palpate" validate oscillator/order/rk4 --expected "$out/twice.toml" -q --out "$out/twice" >"$out/said" 2>&1 || status=$?
[ "$status" -eq 2 ] && grep -q 'reason is empty' "$out/said" && grep -q 'is listed twice for the case' "$out/said" || fail "$status, $(cat "$out/said")"

# A simulator that answers zero for every position and velocity keeps momentum and energy, and is stable. It fails.
cat >"$out/dead.py" <<END
import struct, sys
sys.argv = [sys.argv[0]]
exec(open("$root/fixtures/subjects/python/adapter.py").read().split("while len(header")[0])
while len(header := sys.stdin.buffer.read(16)) == 16:
    length, call, _, number = struct.unpack("<IHHQ", header)
    status, reply = answer(call, sys.stdin.buffer.read(length))
    if call == 5:  # get_state
        reply = bytes(len(reply))
    sys.stdout.buffer.write(struct.pack("<IHHQ", len(reply), call, status, number) + reply)
    sys.stdout.buffer.flush()
END
status=0
"$palpate" validate subject/momentum subject/energy subject/stability --subject "exec:python3 $out/dead.py" \
  --out "$out/dead" >"$out/said" 2>&1 || status=$?
[ "$status" -eq 1 ] || { cat "$out/said"; exit 1; }
grep -q "0 passed, 3 failed" "$out/said" || { cat "$out/said"; exit 1; }

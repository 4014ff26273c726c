#!/usr/bin/env bash
# A campaign on a Slurm cluster of two nodes on this machine, one of which is killed in the middle, has the bytes of a run
# without a cluster. munged, slurmctld and two slurmd are started without systemd, on ports and in folders of this test.
# PALPATE_SLURM_JOBS, PALPATE_SLURM_SHARDS, PALPATE_SLURM_SCENE and PALPATE_SLURM_LENGTHS (two times in s) change it.
set -euo pipefail
palpate=$1 scripts=$2 scenes=$3 out=$4
skip() { echo "skipped: $1"; exit 0; }
fail() { echo "$1"; tail -n 5 "$out"/*.log 2>/dev/null || true; exit 1; }
for program in munged slurmctld slurmd sbatch; do
  PATH=$PATH:/usr/sbin command -v "$program" >/dev/null ||
    skip "$program is not installed (packages slurmctld slurmd slurm-client munge)"
done
[ "$(id -u)" -eq 0 ] || skip "slurmd starts jobs of other users, so it needs root"
PATH=$PATH:/usr/sbin
rm -rf "$out"
mkdir -p "$out"
out=$(realpath "$out")
run=$(mktemp -d /tmp/palpate-slurm-XXXXXX)  # sockets have short names
declare -A pid=()
stop() {
  for each in "${pid[@]}"; do kill "$each" 2>/dev/null || true; done
  for each in "${pid[@]}"; do wait "$each" 2>/dev/null || true; done
  rm -rf "$run"
}
trap stop EXIT
start() {  # name, command...
  "${@:2}" >>"$out/$1.log" 2>&1 &
  pid[$1]=$!
}
free_port() { python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'; }

mkdir -m 0755 "$run/munge"
mkdir "$run/state" "$run/spool-a" "$run/spool-b"
chmod 0755 "$run"
dd if=/dev/urandom of="$run/munge/key" bs=1024 count=1 status=none
chmod 0400 "$run/munge/key"
start munged munged --foreground --force --key-file="$run/munge/key" --socket="$run/munge/socket" \
  --pid-file="$run/munge/pid" --log-file="$run/munge/log" --seed-file="$run/munge/seed"
host=$(hostname -s)
cat >"$run/slurm.conf" <<END
ClusterName=palpate
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmdUser=root
SlurmctldPort=$(free_port)
AuthType=auth/munge
AuthInfo=socket=$run/munge/socket
CryptoType=crypto/munge
CommunicationParameters=NoAddrCache
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
JobRequeue=0
StateSaveLocation=$run/state
SlurmdSpoolDir=$run/spool-%n
SlurmctldPidFile=$run/slurmctld.pid
SlurmdPidFile=$run/slurmd-%n.pid
SlurmctldTimeout=30
SlurmdTimeout=5
MessageTimeout=5
MinJobAge=60
KillWait=2
MaxArraySize=10001
SchedulerParameters=sched_interval=1,batch_sched_delay=0
NodeName=a NodeHostname=$host NodeAddr=127.0.0.1 Port=$(free_port) CPUs=1
NodeName=b NodeHostname=$host NodeAddr=127.0.0.1 Port=$(free_port) CPUs=1
PartitionName=all Nodes=a,b Default=YES MaxTime=60 State=UP
END
export SLURM_CONF=$run/slurm.conf
wait_until() {  # seconds, what, command...: a limit for a cluster that does not start
  for ((n = 0; n < 10 * $1; ++n)); do
    "${@:3}" && return
    sleep 0.1
  done
  fail "$2"
}
wait_until 20 "munged does not start" test -S "$run/munge/socket"
start slurmctld slurmctld -D -f "$run/slurm.conf"
start node-a slurmd -D -N a -f "$run/slurm.conf"
start node-b slurmd -D -N b -f "$run/slurm.conf"
idle() { [ "$(sinfo -h -N -o '%t' 2>/dev/null | grep -c idle)" -eq 2 ]; }
wait_until 60 "the nodes do not come up" idle

cd "$out"
jobs=${PALPATE_SLURM_JOBS:-24}
cat >campaign.toml <<END
title = "Cubes"
scenes = ["${PALPATE_SLURM_SCENE:-$scenes/cube.toml}"]
method = "sobol"
samples = $jobs
[[patient]]
name = "small"
set = ["tissue.lattice.nodes=[5,5,8]", "load=[{nodes=[12], force=[0.0,0.0,0.005]}]", "record=[{name=\"top\", node=12}]"]
[[parameter]]
key = "simulation.duration"
range = [${PALPATE_SLURM_LENGTHS:-1.6, 2.0}]
END
"$palpate" campaign plan campaign.toml --out plan
cp -r plan alone
"$palpate" campaign run alone --jobs 2 --quiet
"$palpate" campaign merge alone --out alone.jsonl

shards=${PALPATE_SLURM_SHARDS:-4}
POLL=1 PALPATE=$palpate "$scripts/slurm-campaign" plan "$shards" merged.jsonl --mem=0 >campaign.log 2>&1 &
campaign=$!
results() { find plan/results -name '*.result' | wc -l; }
begun() { [ "$(results)" -ge $((jobs / 8)) ] || ! kill -0 "$campaign" 2>/dev/null; }
wait_until 500 "no results" begun
# The machine goes: its daemon and all that it started, at once. Processes of this cluster alone are touched.
on_node_b() {
  local each parent
  for each in $(grep -lzx "SLURM_CONF=$run/slurm.conf" /proc/[0-9]*/environ 2>/dev/null); do
    grep -qzx "SLURMD_NODENAME=b" "$each" 2>/dev/null || continue
    each=${each#/proc/}
    each=${each%/environ}
    echo "$each"
    parent=$(ps -o ppid= -p "$each" | tr -d ' ')
    [ "$(ps -o comm= -p "${parent:-0}")" = slurmstepd ] && echo "$parent"
  done
}
lost=()
has_task() {
  mapfile -t lost < <(on_node_b | sort -u)
  [ ${#lost[@]} -gt 0 ] || ! kill -0 "$campaign" 2>/dev/null
}
wait_until 60 "no task on node b" has_task
before=$(results)
written() { find plan/results -name '*.result' -printf '%f %i %T@\n' | sort; }
written >before.txt
kill -KILL "${pid[node-b]}" "${lost[@]}" 2>/dev/null || true
unset 'pid[node-b]'
echo "node b killed with ${#lost[@]} processes after $before of $jobs results"
status=0
wait "$campaign" || status=$?
cat campaign.log
[ "$status" -eq 0 ] || fail "exit code $status"
[ ${#lost[@]} -gt 0 ] || fail "the campaign ended before a node could be killed"
cmp alone.jsonl merged.jsonl || fail "other bytes than one machine's"
[ -z "$(comm -23 before.txt <(written))" ] || fail "a finished job ran again"
[ "$(results)" -eq "$jobs" ] || fail "$(results) results of $jobs jobs"
echo "$jobs jobs on two nodes, one killed: the bytes of one machine"

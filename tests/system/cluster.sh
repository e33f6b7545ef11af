#!/bin/bash
# A Slurm of two nodes on this machine, for as long as a command runs: cluster.sh FOLDER COMMAND...
# Everything of it lies in FOLDER. Exits 77 where Slurm is not installed or may not be started.
set -u
folder=$(realpath "$1")
shift
export PATH=$PATH:/usr/sbin
for program in munged slurmctld slurmd sbatch; do
  command -v $program > /dev/null || { echo "no $program: install slurm-wlm and munge" >&2; exit 77; }
done
[[ $(id -u) == 0 ]] || { echo "Slurm's daemons need root" >&2; exit 77; }

mkdir -p "$folder"/{state,spool.n1,spool.n2} /run/munge
chown munge /run/munge
chmod 755 /run/munge
munge= # a folder that its user can reach; none: one runs already
if [[ ! -S /run/munge/munge.socket.2 ]]; then
  munge=$(mktemp -d /tmp/fjell-munge-XXXXXX)
  head -c 1024 /dev/urandom > "$munge/key"
  chmod 400 "$munge/key"
  chown -R munge "$munge"
  (cd / && runuser -u munge -- munged --force --key-file="$munge/key" --pid-file="$munge/pid" \
    --log-file="$munge/log" --seed-file="$munge/seed")
fi
host=$(hostname -s)
# Ports of our own: two checks at once must not meet.
base=$((17000 + $$ % 2000 * 4))
cat > "$folder/slurm.conf" << EOF
ClusterName=fjell
SlurmctldHost=$host
SlurmctldPort=$base
AuthType=auth/munge
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
ReturnToService=2
SchedulerParameters=sched_interval=1,defer
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool.%n
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.%n.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.%n.log
MpiDefault=none
SlurmdTimeout=5
MessageTimeout=2
JobRequeue=1
NodeName=n1 NodeHostname=$host Port=$((base + 1)) CPUs=1
NodeName=n2 NodeHostname=$host Port=$((base + 2)) CPUs=1
PartitionName=all Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
EOF
export SLURM_CONF=$folder/slurm.conf
# A daemon that has just begun writes its pid file a moment later.
stop() {
  for pid in "$folder"/slurmd.n1.pid "$folder"/slurmd.n2.pid "$folder"/slurmctld.pid ${munge:+"$munge/pid"}; do
    [[ -e ${pid%.pid}.gone ]] && continue
    for _ in $(seq 50); do [[ -s $pid ]] && break || sleep 0.1; done
    [[ -s $pid ]] && kill "$(< "$pid")" 2> /dev/null
    for _ in $(seq 50); do [[ -s $pid ]] && sleep 0.1 || break; done # it removes the file when it ends
  done
  [[ $munge ]] && rm -rf "$munge"
}
trap stop EXIT
slurmctld -f "$SLURM_CONF" && slurmd -f "$SLURM_CONF" -N n1 && slurmd -f "$SLURM_CONF" -N n2 || exit 77
"$@"

#!/bin/bash
# Under cluster.sh: a node dies in the middle of an array. lose_node.sh FOLDER_OF_THE_CLUSTER OUT LAUNCH...
# First goes what would tell of its steps, then a shard's step that is held in the middle. Slurm takes the node for lost
# after SlurmdTimeout and queues the shard again, for two minutes later, which is not waited for.
set -u
cluster=$1 out=$2
shift 2
drained() { while [[ $(squeue -h) ]]; do sleep 0.2; done; }
parent() { sed -n 's/^PPid:[[:space:]]*//p' "/proc/$1/status"; }
hold() { # a process: whether it was a shard's first step of errors on our first node, which then is held
  grep -qzs '^SLURMD_NODENAME=n1$' "/proc/$1/environ" && grep -qzs "^SLURM_CONF=$SLURM_CONF\$" "/proc/$1/environ" &&
    grep -qzs '^step1$' "/proc/$1/cmdline" && kill -STOP "$1"
}

"$@" > /dev/null || exit 1
worker=
while [[ ! $worker ]]; do
  if [[ -s $out ]]; then # on a busy machine all of it may be over before we look: once more
    drained
    rm -f "$out" plan/step1/*
    "$@" > /dev/null || exit 1
  fi
  for process in $(pgrep -x fjell-bake); do
    if hold "$process"; then worker=$process; break; fi
  done
done
script=$(parent "$worker")
kill -9 "$(< "$cluster/slurmd.n1.pid")" "$(parent "$script")" "$script" "$worker"
mv "$cluster/slurmd.n1.pid" "$cluster/slurmd.n1.gone" # nobody is to wait for it
until sinfo -h -n n1 -o %t | grep -q down; do sleep 0.2; done
for job in $(squeue -h -r -t PD -o '%i %r' | sed -n 's/ BeginTime$//p'); do
  echo "queued again: $job"
  scontrol update "JobId=$job" StartTime=now
done
drained
[[ -s $out ]] || exit 3
sinfo -h -n n1 -o %t

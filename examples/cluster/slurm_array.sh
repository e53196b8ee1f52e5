#!/bin/bash
# A dataset on a Slurm cluster: an array of tasks, each of which does every N-th job.
#
#     sbatch --array=1-15 slurm_array.sh /shared/dataset --spp 64
#
# The first argument is the folder on a file system that all nodes see; the others go to `holo dataset` as they are. Tasks do
# not talk to each other. What a task has done is kept: after a failure, a time limit or a change of options, submit the same
# again. HOLO names the program where it is not on PATH.
#SBATCH --job-name=holo-dataset
#SBATCH --output=holo-dataset-%A_%a.log
#SBATCH --cpus-per-task=2
#SBATCH --mem=2G
#SBATCH --time=08:00:00
#SBATCH --requeue

set -euo pipefail
if [ $# -lt 1 ]; then
    echo "usage: sbatch --array=1-N $0 DIR [options of holo dataset]" >&2
    exit 2
fi
out=$1
shift

# Arrays may begin at any number; shards count from 1.
part=$((SLURM_ARRAY_TASK_ID - SLURM_ARRAY_TASK_MIN + 1))
exec "${HOLO:-holo}" dataset --out "$out" --shard "$part/$SLURM_ARRAY_TASK_COUNT" --threads "$SLURM_CPUS_PER_TASK" "$@"

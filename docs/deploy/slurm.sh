#!/bin/sh
#SBATCH --job-name=texmap
#SBATCH --array=1-8
#SBATCH --cpus-per-task=1
#SBATCH --mem=101M
#SBATCH --time=1
#SBATCH --requeue
# Exit code 75: something outside of the batch ended a task. It runs again, and skips what is complete.
texmap batch render @all.txt '--output=out/{model}.png' --resolution=512x512 --jobs=1 --threads=1 --resume --shard=auto --shard-count=8
code=$?
[ $code -ne 75 ] || scontrol requeue "${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}"
exit $code

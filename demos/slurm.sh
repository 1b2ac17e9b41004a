#!/bin/sh
# One part of a picture for each task of a Slurm array; see demos/hosts.md. SPDX-License-Identifier:
# MIT
#SBATCH --job-name=render
#SBATCH --array=0-7
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=16
set -eu
picture="--scene bear --size 640x360 --spp 64"
first=$((64 * SLURM_ARRAY_TASK_ID))

build/render $picture --first-sample $first --pfm "build/part-$SLURM_ARRAY_TASK_ID.pfm"

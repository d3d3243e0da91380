#!/usr/bin/python3
# An archive by Dask: dask_shards.py SCHEDULER SHARDS LIST OPTIONS...
# SCHEDULER: tcp://HOST:8786 of `dask scheduler`. Its workers (`dask worker --nthreads CORES`) see this folder and have
# kasumi. LIST: a picture a line. OPTIONS: of `kasumi estimate`, --camera-memory or --calibration first. A worker that
# dies takes its kasumi with it, and another goes on behind what is there; so does the same command when it was stopped.
# Afterwards: kasumi estimate --merge parts/*.jsonl --out archive.sqlite
import os
import subprocess
import sys

from dask.distributed import Client

scheduler, shards, pictures, *options = sys.argv[1:]
folder = os.getcwd()
os.makedirs("parts", exist_ok=True)


def estimate(shard):
    command = ["setpriv", "--pdeathsig", "KILL", "kasumi", "estimate", "@" + pictures, *options, "--jobs", "1"]
    command += ["--shard", f"{shard}/{shards}", "--resume", "--out", f"parts/{shard}.jsonl"]
    subprocess.run(command, cwd=folder, check=True)


# pure=False: files are written, so nothing that ran before makes it superfluous.
with Client(scheduler) as client:
    client.gather(client.map(estimate, range(1, int(shards) + 1), retries=3, pure=False))

#!/bin/sh
# An archive by GNU parallel, a process a core: parallel.sh SHARDS LIST OPTIONS...
# LIST: a picture a line. OPTIONS: of `kasumi estimate`, --camera-memory or --calibration first. Stopped, by whatever, the
# same command goes on. Afterwards: kasumi estimate --merge parts/*.jsonl --out archive.sqlite
set -eu
shards=$1 list=$2
shift 2
mkdir -p parts
seq "$shards" |
  parallel --quote --retries 3 kasumi estimate "@$list" "$@" --jobs 1 --shard "{}/$shards" --resume --out "parts/{}.jsonl"

#!/bin/sh
# One hash over all channels and ticks of each clip, from gcc and clang at -O0 and -O2: prints them, fails unless equal.
#   same_bits.sh CLIP...
# SPDX-License-Identifier: MIT
set -eu
status=0
for clip in "$@"; do
    first=
    for cc in gcc clang; do
        for opt in -O0 -O2; do
            dir=build/same/$cc$opt
            make -s "B=$dir" "CC=$cc" "OPT=$opt" PROGRAM=tests/fw_hash.c "CLIP=$clip" image > /dev/null
            hash=$(WIGGLY_FAST=1 WIGGLY_BUS=/dev/null "$dir/$(basename "$clip" .wgl)/fw_hash.elf" 2>&1 | grep -o 'hash [0-9a-f]*')
            echo "$clip $cc $opt: $hash"
            first=${first:-$hash}
            [ "$hash" = "$first" ] || status=1
        done
    done
done
exit $status

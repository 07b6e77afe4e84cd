#!/bin/sh
# Everything CI runs. Each step prints its own `N passed, N failed` or counts as one; the last line is the sum.
#   check.sh            output of a step is shown when it fails, all of it is in build/check/
# SPDX-License-Identifier: MIT
set -u
cd "$(dirname "$0")/.." || exit 2
export OPENBLAS_NUM_THREADS=1
mkdir -p build/check
passed=0
failed=0

# step NAME COMMAND...
step() {
    name=$1
    shift
    log=build/check/$(echo "$name" | tr ' /' '__').log
    start=$(date +%s)
    timeout 900 "$@" > "$log" 2>&1 < /dev/null
    code=$?
    sum=$(grep -E '^[0-9]+ passed, [0-9]+ failed' "$log" | tail -1)
    good=$(echo "${sum:-0 passed, 0 failed}" | sed -E 's/^([0-9]+) passed.*/\1/')
    bad=$(echo "${sum:-0 passed, 0 failed}" | sed -E 's/.* ([0-9]+) failed.*/\1/')
    [ -z "$sum" ] && [ $code -eq 0 ] && good=1
    [ $code -ne 0 ] && [ "$bad" -eq 0 ] && bad=1
    passed=$((passed + good))
    failed=$((failed + bad))
    printf '%-44s %5d passed %3d failed %4d s\n' "$name" "$good" "$bad" $(($(date +%s) - start))
    [ "$bad" -ne 0 ] && tail -40 "$log"
    return 0
}

python=/usr/bin/python3
san="-fsanitize=address,undefined -fno-sanitize-recover=undefined"

step "format" sh -c 'files=$(find . -path ./build -prune -o -name "*.[ch]" -print -o -name "*.cpp" -print)
    [ -n "$files" ] && clang-format --dry-run -Werror $files'
step "build host, gcc" make -s WERROR=1 all bake
for board in null mps2-an386 microbit sifive_e atmega2560 lm3s6965evb; do
    step "build $board" make -s BOARD=$board WERROR=1 all
    step "pure $board" make -s BOARD=$board pure
done
step "build host, clang" make -s WERROR=1 B=build/clang CC=clang CFLAGS=-Wno-unused-command-line-argument all

for test in tests/test_player_*.c tests/test_device_*.c; do
    name=$(basename "$test" .c)
    step "$name" sh -c "make -s SAN='$san' build/tests/$name && build/tests/$name"
done
for test in tests/test_bake_*.c; do
    name=$(basename "$test" .c)
    step "$name" sh -c "make -s build/tests/$name && build/tests/$name"
done
step "fuzz corpus and mutations" sh -c 'make -s build/tests/replay &&
    build/tests/replay 50000 tests/fuzz/corpus/*.wgl tests/regress/*.wgl tests/vectors/*.wgl'
step "fuzz, coverage guided" sh -c 'make -s build/tests/fuzz_open &&
    mkdir -p build/check/corpus && cp tests/fuzz/corpus/*.wgl tests/regress/*.wgl build/check/corpus &&
    build/tests/fuzz_open -runs=30000 -seed=1 -max_len=8192 build/check/corpus'
step "reference decoder, bit for bit" $python tests/reference/test_player_bits.py
step "arithmetic against mpmath" $python tests/reference/fix_oracle.py
step "emulated servos" $python tests/test_servo_emulation.py
step "emulated panels" $python tests/test_display_emulation.py
step "screens of the emulators" $python tests/test_screens.py
step "command line" $python tests/test_bake_cli.py
step "filters, captures, limits" $python tests/test_bake_filters.py
step "meshes to bases" $python tests/test_bake_pca.py
step "damaged files" $python tests/test_bake_damage.py
step "bodies, hostile input" $python tests/test_bake_body_damage.py
step "rigs, hostile input" $python tests/test_bake_skin_damage.py
step "rigs end to end" $python tests/test_bake_skins.py
step "bodies end to end" $python tests/test_bake_bodies.py
step "solids against mpmath" $python tests/reference/solid_oracle.py --check
step "talking face" $python tests/test_bake_face.py
step "flat shapes" $python tests/test_bake_flat.py
step "flat shapes, hostile input" $python tests/test_bake_flat_refuse.py
step "pictures" $python tests/test_bake_pictures.py
step "window" $python tests/test_view.py
step "examples bake" sh -c 'mkdir -p build/check && for scene in nod puppet face faerie morph rod luxo block cactus cloth walk bug twist cigar elbow \
    cartoon homer; do
    build/wiggly bake examples/$scene/$scene.yaml -o build/check/$scene.wgl --quiet || exit 1; done
    build/wiggly bake tests/scenes/buses.yaml -o build/check/buses.wgl --quiet'
step "same bits, every compiler" sh tests/tools/same_bits.sh build/check/nod.wgl build/check/puppet.wgl \
    build/check/buses.wgl build/check/face.wgl build/check/faerie.wgl build/check/cactus.wgl build/check/twist.wgl \
    build/check/elbow.wgl build/check/cartoon.wgl build/check/homer.wgl
$python tests/tools/clip_source.py tests/vectors/v1_shapes.wgl build/check/shapes
$python tests/tools/clip_source.py tests/vectors/v1_skins.wgl build/check/skins
for clip in nod puppet buses face shapes skins; do
    step "same bits, every board: $clip" $python tests/test_boards.py build/check/$clip.wgl
done
step "budgets" $python tests/tools/budget.py
step "bytes beside other formats" $python tests/bench/bench_bytes.py --check
step "shapes beside other formats" $python tests/bench/bench_shapes.py --check
step "bodies beside frames" $python tests/bench/bench_body_bytes.py --check
step "README commands" $python tests/test_readme.py

step "demo" make -s demo

echo "$passed passed, $failed failed"
[ $failed -eq 0 ]

#!/bin/sh
# Installs what the baker, the tests and the demonstration need on Debian 12 and is not there yet.
# Silent when nothing is missing. Elsewhere it only looks for the commands and says what to install.
# SPDX-License-Identifier: MIT
set -eu

# package, the command it provides (- for none), what it is for
list() {
    cat <<'LIST'
gcc                     gcc                      player, device, baker, tests on this machine
libc6-dev               -                        its headers
make                    make                     the Makefile
libassimp-dev           -                        baker: BVH, glTF, FBX and other sources
libcyaml-dev            -                        baker: scene files
libyaml-dev             -                        baker: line numbers in scene files
liblapacke-dev          -                        baker: banded and dense solvers
libopenblas-dev         -                        baker: what they run on
g++                     g++                      baker: the bridges to CGAL and TetGen
libcgal-dev             -                        baker: checks surfaces
libtet1.5-dev           -                        baker: tetrahedra
libsuitesparse-dev      -                        baker: sparse Cholesky factors
libarpack2-dev          -                        baker: lowest modes
libpng-dev              -                        baker: pictures
libimagequant-dev       -                        baker: palettes of pictures on shapes
librsvg2-dev            -                        baker: SVG drawings
pkg-config              pkg-config               the Makefile: where librsvg is
libsdl2-dev             -                        wiggly view
gnuplot-nox             gnuplot                  baker and demonstration: plots
assimp-testmodels       -                        examples/puppet, homer, faerie, morph: their sources
python3                 python3                  reference decoders, oracles, tools
python3-numpy           -                        oracles
python3-mpmath          -                        oracles
python3-pil             -                        pictures in tests
xvfb                    Xvfb                     a screen for the tests of wiggly view
xdotool                 xdotool                  keys and mouse for them
python3-scipy           -                        oracles
libcgal-demo            -                        examples/cactus, walk, homer: their sources
libmeshoptimizer-dev    -                        benchmark: its vertex codec
coinor-libipopt-dev     -                        tests, benchmark: another solver to compare weights with
openarena-data          -                        benchmark: an animated character
python3-yaml            -                        demonstration: servo maps as the scenes have them
gcc-arm-none-eabi       arm-none-eabi-gcc        boards mps2-an386, microbit
libnewlib-arm-none-eabi -                        its string.h
gcc-riscv64-unknown-elf riscv64-unknown-elf-gcc  board sifive_e
gcc-avr                 avr-gcc                  board atmega2560
avr-libc                -                        its headers and start-up code
binutils-avr            avr-nm                   board atmega2560
simavr                  simavr                   emulator of the ATmega2560
libsimavr-dev           -                        the same as a library
libelf-dev              -                        libsimavr-dev needs it and does not say so
qemu-system-arm         qemu-system-arm          emulator of mps2-an386 and microbit
qemu-system-misc        qemu-system-riscv32      emulator of sifive_e
clang                   clang                    second compiler, fuzzer
libclang-rt-14-dev      -                        the fuzzer's run time
clang-format            clang-format             make format, make check
LIST
}

fail() {
    echo "setup.sh: $*" >&2
    exit 1
}

if ! command -v dpkg-query >/dev/null; then
    missing=$(list | while read -r package program _; do
        [ "$program" = - ] || command -v "$program" >/dev/null || echo "$package"
    done)
    [ -z "$missing" ] || fail "this is not Debian; install what corresponds to:" $missing
    exit 0
fi

names=$(list | cut -d ' ' -f 1)
there=$(dpkg-query -W -f '${Package} ${db:Status-Status}\n' $names 2>/dev/null || true)
missing=$(for package in $names; do
    case "
$there
" in
    *"
$package installed
"*) ;;
    *) echo "$package" ;;
    esac
done)
[ -n "$missing" ] || exit 0
missing=$(echo $missing)

if [ "$(id -u)" = 0 ]; then
    root=
elif command -v sudo >/dev/null; then
    root=sudo
else
    fail "missing: $missing
as root: apt-get update && apt-get install -y --no-install-recommends $missing"
fi
echo "setup.sh: installing $missing" >&2
$root apt-get update -q >&2 || fail "apt-get update failed; is there a network, and may you sudo?"
$root env DEBIAN_FRONTEND=noninteractive \
    apt-get install -q -y --no-install-recommends $missing >&2 || fail "could not install $missing
as root: apt-get update && apt-get install -y --no-install-recommends $missing"

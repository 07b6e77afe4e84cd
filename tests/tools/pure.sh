#!/bin/sh
# Fails when archives need anything from outside but what a compiler calls on its own: the four
# memory functions and integer arithmetic. Floating point, malloc, stdio or the hal show up here.
#   pure.sh NM ARCHIVE...      the archives may use each other
# SPDX-License-Identifier: MIT
set -eu
nm=$1
shift

# libgcc names its helpers by operation and operand types; f, the type of floats, is not in the set
memory='memcpy|memset|memmove|memcmp'
integer='__[su]*(div|mod|divmod|mul|ashl|ashr|lshr|rotl|rotr|neg|add|sub|cmp|clz|ctz)[sdhqptiuo]+[234]?(_s8)?'
arm='__aeabi_(u?idiv(mod)?|u?ldivmod|lmul|llsl|llsr|lasr|u?lcmp|mem(cpy|set|clr|move)[48]?)'
thumb='__gnu_thumb1_case_[a-z]+'
avr='__(prologue_saves|epilogue_restores|tablejump2?)__|__do_(copy_data|clear_bss)'
riscv='__riscv_(save|restore)_[0-9]+'

defined=$(mktemp)
trap 'rm -f "$defined"' EXIT
"$nm" --defined-only -g "$@" | awk 'NF == 3 { print $3 }' | sort -u > "$defined"
if [ ! -s "$defined" ]; then # nothing in, nothing wrong: an empty archive must not pass
    echo "pure: no symbols in $*" >&2
    exit 2
fi
foreign=$("$nm" --undefined-only "$@" | awk '$1 == "U" { print $2 }' | sort -u |
    comm -23 - "$defined" | grep -Evx "$memory|$integer|$arm|$thumb|$avr|$riscv" || true)
if [ -n "$foreign" ]; then
    echo "pure: not allowed in $*:" >&2
    echo "$foreign" >&2
    exit 1
fi

# The machine you sit at. SPDX-License-Identifier: MIT
CROSS    :=
OPT      ?= -O2
HAL      := posix
LD       :=
EMULATOR := env WIGGLY_BUS=@BUS@ WIGGLY_LOG=@LOG@ WIGGLY_FAST=1 @IMAGE@

# The port to copy: see hal/null/hal.c. Builds with the host's compiler. SPDX-License-Identifier: MIT
CROSS    :=
HAL      := null
LD       :=
EMULATOR := @IMAGE@

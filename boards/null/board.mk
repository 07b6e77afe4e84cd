# The port to copy: see hal/null/hal.c. Builds with the host's compiler. SPDX-License-Identifier: MIT
CROSS    :=
HAL      := null
# what shows the clip's shapes: a directory of firmware/panel/
PANEL    ?= none
LD       :=
EMULATOR := @IMAGE@

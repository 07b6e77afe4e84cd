# wiggly: see `make help`. One file, GNU make, no configure; objects in build/$(BOARD)/.
# SPDX-License-Identifier: MIT
BOARD ?= host
B ?= build/$(BOARD)
include boards/$(BOARD)/board.mk

# ---- flags: the same for every board ------------------------------------------------------------
MEM    ?= near
KERNEL ?= plain
PANEL  ?= none
STD    := -std=c99 -pedantic -ffp-contract=off
WARN   := -Wall -Wextra -Wshadow -Wconversion -Wdouble-promotion -Wmissing-prototypes -Wvla
WARN   += $(if $(WERROR),-Werror)
OPT    ?= -Os
CC     := $(CROSS)gcc
AR     := $(CROSS)ar
CFLAGS += $(STD) $(WARN) $(OPT) $(CPU) -g -MMD -MP -ffunction-sections -fdata-sections
PURE_I := -Iinclude -Ifirmware/player/mem/$(MEM)
DEVICE_I := -Ifirmware/player -Ifirmware/device -Ifirmware/device/raster -Ifirmware/device/display

PLAYER := $(wildcard firmware/player/*.c firmware/player/mem/$(MEM)/*.[cS] firmware/player/kernel/$(KERNEL)/*.[cS])
PLAYER := $(patsubst %,$B/%.o,$(basename $(PLAYER)))
DEVICE := $(patsubst %.c,$B/%.o,$(wildcard firmware/device/*.c firmware/device/*/*.c))

.PHONY: all player device bake test check bench budget demo run clean help setup pure format
all: player device ## the player and device libraries for BOARD, with nothing but a C99 compiler
player: $B/libplayer.a ## libplayer.a for BOARD
device: $B/libdevice.a

$B/libplayer.a: $(PLAYER)
$B/libdevice.a: $(DEVICE)
$B/%.a:
	@mkdir -p $(@D)
	$(AR) rcs $@ $^
# rows 1 and 2 of the module table: no -Ihal here, so a forbidden include does not compile
$B/firmware/player/%.o: firmware/player/%.c
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $(PURE_I) -c $< -o $@
$B/firmware/player/%.o: firmware/player/%.S
	@mkdir -p $(@D)
	$(CC) $(CPU) -g -c $< -o $@
$B/firmware/device/%.o: firmware/device/%.c
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $(PURE_I) $(DEVICE_I) -c $< -o $@

# ---- the baker (host only) ----------------------------------------------------------------------
RSVG_CF   := $(patsubst -I%,-isystem %,$(shell pkg-config --cflags librsvg-2.0 2>/dev/null)) # headers of others: no warnings
BAKE_LIBS := -lassimp -lcyaml -lpng -limagequant $(shell pkg-config --libs librsvg-2.0 2>/dev/null) -lSDL2 -lyaml -ltet -larpack -lcholmod -llapacke -lopenblas -lgmp -lmpfr -lstdc++ -lm
BAKE      := $(patsubst %,build/bake/%.o,$(basename $(wildcard host-bake/*.c host-bake/body/*.c host-bake/skin/*.c host-bake/bridge/*.cpp)))
BAKE_CF   := -std=c11 -D_DEFAULT_SOURCE $(WARN) -O2 -g -ffp-contract=off -MMD -MP $(PURE_I) -Ihost-bake -Ihost-bake/body -Ihost-bake/skin \
    -Ihost-bake/bridge $(DEVICE_I) $(RSVG_CF)
BRIDGE_CF := -std=c++17 -O2 -g -DNDEBUG -Wall -Wextra $(if $(WERROR),-Werror) -MMD -MP -Ihost-bake/bridge
bake: build/wiggly ## the host baker, build/wiggly
build/bake/%.o: %.c
	@mkdir -p $(@D)
	gcc $(BAKE_CF) -c $< -o $@
# C++ lives here alone: CGAL and TetGen, behind extern "C"
build/bake/host-bake/bridge/%.o: host-bake/bridge/%.cpp
	@mkdir -p $(@D)
	g++ $(BRIDGE_CF) -c $< -o $@
build/libbake.a: $(filter-out %/main.o,$(BAKE))
	rm -f $@; ar rcs $@ $^
build/wiggly: build/bake/host-bake/main.o build/libbake.a build/host/libdevice.a build/host/libplayer.a
	gcc -o $@.new $^ $(BAKE_LIBS)
	@mv $@.new $@ # whoever runs it meanwhile runs the old one

# ---- tests --------------------------------------------------------------------------------------
build/tests/test_bake_%: tests/test_bake_%.c build/libbake.a build/host/libdevice.a build/host/libplayer.a
	@mkdir -p $(@D)
	gcc $(BAKE_CF) -Itests $(DEVICE_I) $< -o $@ $(filter %.a,$^) $(BAKE_LIBS)
# the pure code and its tests in one go, under the sanitizers unless SAN= says otherwise
SAN      ?= -fsanitize=address,undefined -fno-sanitize-recover=undefined
PURE_SRC := $(wildcard firmware/player/*.c firmware/player/*/near/*.c firmware/player/*/plain/*.c \
    firmware/device/*.c firmware/device/*/*.c)
PURE_CF  := $(STD) $(WARN) -O1 -g $(SAN) $(PURE_I) -Itests $(DEVICE_I)
PURE_H   := $(wildcard firmware/*/*.h firmware/*/*/*.h include/*.h hal/*.h tests/*.h tests/fuzz/*.h)
build/tests/test_%: tests/test_%.c $(PURE_SRC) $(PURE_H)
	@mkdir -p $(@D)
	gcc $(PURE_CF) $< $(PURE_SRC) -o $@ -lm
# this one includes the firmware's loop
build/tests/test_device_loop: PURE_CF += -Ihal -Ifirmware firmware/panel/none.c
build/tests/test_device_loop: firmware/main.c firmware/panel/none.c
build/tests/replay: tests/fuzz/replay.c $(PURE_SRC) $(PURE_H)
	@mkdir -p $(@D)
	gcc $(PURE_CF) $(filter %.c,$^) -o $@
build/tests/fuzz_open: tests/fuzz/fuzz_open.c $(PURE_SRC) $(PURE_H)
	@mkdir -p $(@D)
	clang $(PURE_CF) -fsanitize=fuzzer $(filter %.c,$^) -o $@
TESTS := $(patsubst tests/%.c,build/tests/%,$(wildcard tests/test_*.c))
test: $(TESTS) ## the unit tests
	@for t in $(TESTS); do $$t || exit 1; done
check: setup ## installs what is missing, then everything CI runs
	@tests/check.sh
bench: build/bench_spline build/bench_bodies build/bench_weights bake tools ## splines, bodies, weights; bytes beside other formats
	OPENBLAS_NUM_THREADS=1 build/bench_spline 100000
	OPENBLAS_NUM_THREADS=1 build/bench_bodies
	OPENBLAS_NUM_THREADS=1 build/bench_weights --ipopt
	/usr/bin/python3 tests/bench/bench_body_bytes.py
	/usr/bin/python3 tests/bench/bench_bytes.py
	/usr/bin/python3 tests/bench/bench_shapes.py
build/tests/test_bake_bounded build/bench_weights: BAKE_LIBS += -lipopt # the oracle: another interior point solver
build/bench_%: tests/bench_%.c build/libbake.a build/host/libdevice.a build/host/libplayer.a
	gcc $(BAKE_CF) $< -o $@ $(filter %.a,$^) $(BAKE_LIBS)
budget: bake tools ## bytes, stack, instructions and cycles against tests/budget/player.csv
	/usr/bin/python3 tests/tools/budget.py
format: ## clang-format over everything
	find . -path ./build -prune -o -name '*.[ch]' -print -o -name '*.cpp' -print | xargs clang-format -i

# ---- boards: an image is a program, the clip, player, device and the board's hal ------------------
CLIP    ?= build/nod.wgl
FRAMES  ?= 0
PROGRAM ?= firmware/main.c
RUN     ?=
CLIP_B  := $B/$(basename $(notdir $(CLIP)))
CLIP_C  := $(basename $(CLIP)).c
IMAGE   := $(CLIP_B)/$(basename $(notdir $(PROGRAM))).elf
HAL_O   := $(patsubst %,$B/%.o,$(basename $(wildcard $(HAL:%=hal/%/*.[cS]))))
HAL_I   := -Ihal -Ihal/bare -Iboards/$(BOARD)
IMAGE_I := $(PURE_I) -I$(CLIP_B) $(DEVICE_I) -Ifirmware -Ifirmware/panel/$(PANEL) -Ihal
.PHONY: image tools stack test-boards
image: $(IMAGE) ## firmware for BOARD with CLIP=x.wgl linked in; FRAMES=n stops after n frames
run: FRAMES = CLIP_FRAMES
run: image tools ## plays CLIP=x.wgl once through on the emulator of BOARD
	@: > $(CLIP_B)/bus.bin # a board without a bus leaves it so
	@rm -f $(CLIP_B)/screen.png
	@/usr/bin/python3 tests/tools/run_board.py $(BOARD) $(IMAGE) --bus $(CLIP_B)/bus.bin $(DUMP) $(RUN)
	@test ! -f $(CLIP_B)/screen.png || echo "display at the end: $(CLIP_B)/screen.png"
	@echo "servo bus: $$(wc -c < $(CLIP_B)/bus.bin) bytes in $(CLIP_B)/bus.bin$$(test ! -s $(CLIP_B)/bus.bin || echo ", beginning with")"
	@od -An -tx1 -N 96 -w32 $(CLIP_B)/bus.bin
tools: build/tools/avr_run build/tools/libqemu_roi.so
build/tools/avr_run: tests/tools/avr_run.c
	@mkdir -p $(@D)
	gcc $(STD) $(WARN) -O2 $< -o $@ -lsimavr -lelf
build/tools/libqemu_roi.so: tests/tools/qemu_roi.c
	@mkdir -p $(@D)
	gcc $(STD) $(WARN) -O2 -fPIC -shared -fvisibility=hidden $< -o $@
$B/hal/bare/mem.o: CFLAGS += -fno-tree-loop-distribute-patterns
$B/hal/%.o: hal/%.c
	@mkdir -p $(@D)
	$(CC) $(CFLAGS) $(HAL_I) -c $< -o $@
$B/hal/%.o: hal/%.S
	@mkdir -p $(@D)
	$(CC) $(CPU) -g -c $< -o $@
# the default clip; its baker is the host's, whatever BOARD and its flags are
build/nod.wgl: examples/nod/nod.yaml $(wildcard host-bake/*.[ch] host-bake/*/*)
	@MAKEFLAGS= $(MAKE) -s BOARD=host B=build/host bake
	build/wiggly bake $< -o $@ --quiet
# the baker writes x.c and x.h beside x.wgl
$(CLIP_C): $(filter build/nod.wgl,$(CLIP))
	@test -f $@ || { echo "no $@: bake it with build/wiggly bake SCENE.yaml -o $(CLIP)" >&2; exit 1; }
# copied and linked anew each time: FRAMES and another directory's x.wgl are no newer files
$(CLIP_B)/clip.h: $(CLIP_C) FORCE
	@mkdir -p $(@D)
	@cp $(basename $(CLIP)).h $@
# chips that are alike share a file; without a display nothing of shapes and pictures is linked
PANEL_ili9341 := st7789
PANEL_ssd0303 := ssd1306
SCREEN  := $(if $(filter main.c,$(notdir $(PROGRAM))),$(if $(filter-out none,$(PANEL)),firmware/screen.c) firmware/panel/$(or $(PANEL_$(PANEL)),$(PANEL)).c)
$(IMAGE): $(PROGRAM) $(SCREEN) $(CLIP_C) $(CLIP_B)/clip.h $(HAL_O) $B/libdevice.a $B/libplayer.a FORCE
	$(CC) $(filter-out -MMD -MP,$(CFLAGS)) $(IMAGE_I) -DBOARD_FRAMES=$(FRAMES) \
	    $(filter %.c %.o %.a,$^) -Wl,--gc-sections $(LD) -o $@
# what an emulated board's own display (not one that PANEL= names) shows of a clip that has a view
DUMP = $(if $(filter file,$(origin PANEL)),$(if $(filter firmware/screen.c,$(SCREEN)),$(shell \
    grep -q 'CLIP_VIEWS [1-9]' $(CLIP_B)/clip.h && echo --screendump $(CLIP_B)/screen.png)))
FORCE:
pure: player device ## player and device need nothing but integer helpers, for BOARD
	tests/tools/pure.sh $(CROSS)nm $B/libplayer.a $B/libdevice.a
stack: image ## worst-case stack of the firmware, for BOARD (GCC 10 or later: not the AVR)
	/usr/bin/python3 tests/tools/stack.py --image $(IMAGE) --cross "$(CROSS)" --root reset \
	    --root wg_open --root wg_player_update --root wg_player_sample --root wg_servo_step \
	    $B/firmware $B/hal $(IMAGE)-*.ci
test-boards: ## every board, emulated, against the host: CLIP=x.wgl
	/usr/bin/python3 tests/test_boards.py $(CLIP)

# ---- the demonstration --------------------------------------------------------------------------
setup: ## installs what is missing on Debian 12: as root, or through sudo
	@tests/tools/setup.sh
demo: setup ## bakes the examples, plays them here and on emulated boards, measures pulses and pictures
	@$(MAKE) --no-print-directory -s bake build/tools/libqemu_roi.so
	@/usr/bin/python3 tests/tools/demo.py

clean: ## removes build/
	rm -rf build
help: ## this list
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 12

-include $(shell find build -name '*.d' 2>/dev/null)

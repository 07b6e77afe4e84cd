# Arduino Mega 2560: 8 bits, 256 KB flash of which the near 64 KB hold the clip, 8 KB RAM.
# SPDX-License-Identifier: MIT
CROSS    := avr-
CPU      := -mmcu=atmega2560
MEM      := avr
HAL      := atmega
LD       := -mmcu=atmega2560
EMULATOR := build/tools/avr_run --log @LOG@ --bus @BUS@ --reply @REPLY@ --mcu atmega2560 --hz 16000000 @IMAGE@

/* Reads of clip bytes and constant tables on AVR, whose flash has an address space of its own: LPM.
 * Clips lie in the near 64 KB; `const` alone would be copied into RAM.
 * SPDX-License-Identifier: MIT */
#ifndef WIGGLY_MEM_H
#define WIGGLY_MEM_H

#include <avr/pgmspace.h>
#include <stdint.h>

#define WG_TABLE PROGMEM

static inline uint8_t wg_rd8(const void *p)
{
    return pgm_read_byte(p);
}

static inline uint16_t wg_rd16(const void *p)
{
    return pgm_read_word(p);
}

static inline uint32_t wg_rd32(const void *p)
{
    return pgm_read_dword(p);
}

#endif

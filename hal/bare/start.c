/* From the reset vector to main, and the two semihosting calls.
 * Source: Arm semihosting specification, which RISC-V adopted with the same numbers.
 * SPDX-License-Identifier: MIT */
#include "bare.h"
#include "hal.h"

#define SYS_WRITE0          0x04
#define SYS_EXIT_EXTENDED   0x20
#define EXIT_BY_APPLICATION 0x20026

extern const uint32_t data_load[]; /* these five from sections.ld */
extern uint32_t data_start[], data_end[], bss_start[], bss_end[];

int main(void);

void bare_start(void)
{
    const uint32_t *from = data_load;
    for (uint32_t *to = data_start; to < data_end; to++) {
        *to = *from++;
    }
    for (uint32_t *to = bss_start; to < bss_end; to++) {
        *to = 0;
    }
    hal_stop(main());
}

void semihost_log(const char *text)
{
    semihost(SYS_WRITE0, text);
    semihost(SYS_WRITE0, "\n");
}

void semihost_stop(int code)
{
    const uint32_t reason[2] = {EXIT_BY_APPLICATION, (uint32_t)code};
    semihost(SYS_EXIT_EXTENDED, reason);
}

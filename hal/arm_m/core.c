/* What every Cortex-M shares: vectors, faults, semihosting. The HALs poll, so there are no
 * interrupts to dispatch. Code is Thumb-1, for the M0.
 * Source: ARMv6-M and ARMv7-M Architecture Reference Manuals, B1.5.
 * SPDX-License-Identifier: MIT */
#include "bare.h"

#define BKPT_SEMIHOST 0xbeabu /* bkpt 0xab */
#define FRAME_R0      0       /* words of the frame that an exception pushes */
#define FRAME_PC      6

extern uint32_t stack_top[];

void reset(void);
void fault(void);
void fault_frame(uint32_t *frame);

typedef struct {
    const void *stack;
    void (*entry[15])(void); /* exceptions 1..15 */
} vector_table;

__attribute__((section(".vectors"), used)) const vector_table vectors = {
    stack_top,
    {reset, fault, fault, fault, fault, fault, 0, 0, 0, 0, fault, fault, 0, fault, fault},
};

void reset(void)
{
    bare_start();
}

/* The frame lies on the main stack: nothing here ever switches to the other one. */
__attribute__((naked)) void fault(void)
{
    __asm volatile("mov r0, sp\n ldr r1, =fault_frame\n bx r1");
}

/* A semihosting breakpoint without a debugger escalates to a hard fault: step over it with the
 * answer -1. Anything else is a bug: tell the emulator; a chip locks up and its watchdog bites. */
__attribute__((used)) void fault_frame(uint32_t *frame)
{
    const uint16_t *at = (const uint16_t *)(uintptr_t)frame[FRAME_PC];
    if (*at == BKPT_SEMIHOST) {
        frame[FRAME_PC] += 2;
        frame[FRAME_R0] = UINT32_MAX;
        return;
    }
    semihost_stop(BARE_FAULT);
    for (;;) {
    }
}

int32_t semihost(int32_t operation, const void *argument)
{
    register int32_t r0 __asm("r0") = operation;
    register const void *r1 __asm("r1") = argument;
    __asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void bare_sleep(void)
{
    __asm volatile("wfi");
}

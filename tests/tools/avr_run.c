/* Runs an AVR image in simavr: both serial lines into files, cycles between two addresses, stack.
 *   avr_run [--log FILE] [--bus FILE] [--mcu NAME] [--hz N] [--roi SYMBOL_ADDRESS] IMAGE.elf
 * --roi gives the byte address of a function; cycles are counted from each entry to its return,
 * without the cycles of interrupts that came in between. The exit code is GPIOR0 when the image
 * stops in a sleep with interrupts off, 98 when it crashed.
 * SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GPIOR0_ADDRESS 0x3e /* ATmega640/1280/2560 and 328: the same data address */
#define CRASHED 98

typedef struct {
    const char *log, *bus, *mcu, *image;
    uint32_t hz, roi;
} options;

typedef struct {
    uint64_t start, interrupted, min, max, total, calls;
    uint32_t entry;
    uint16_t entry_sp; /* 0: outside; the function has returned when SP is above it */
    uint16_t lowest_sp;
} roi;

static void die(const char *text, const char *what)
{
    fprintf(stderr, "avr_run: %s %s\n", text, what);
    exit(2);
}

static options parse(int argc, char **argv)
{
    options o = {.mcu = "atmega2560", .hz = 16000000};
    int i = 1;
    for (; i + 1 < argc && argv[i][0] == '-'; i += 2) {
        if (!strcmp(argv[i], "--log")) {
            o.log = argv[i + 1];
        } else if (!strcmp(argv[i], "--bus")) {
            o.bus = argv[i + 1];
        } else if (!strcmp(argv[i], "--mcu")) {
            o.mcu = argv[i + 1];
        } else if (!strcmp(argv[i], "--hz")) {
            o.hz = (uint32_t)strtoul(argv[i + 1], NULL, 0);
        } else if (!strcmp(argv[i], "--roi")) {
            o.roi = (uint32_t)strtoul(argv[i + 1], NULL, 0);
        } else {
            die("unknown option", argv[i]);
        }
    }
    if (i + 1 != argc) {
        die("expects", "one image");
    }
    o.image = argv[i];
    return o;
}

static void on_byte(struct avr_irq_t *irq, uint32_t value, void *file)
{
    (void)irq;
    putc((int)(value & 0xffu), file);
}

/* Takes simavr's own echo off the USART and sends its bytes to a file. */
static FILE *capture(avr_t *avr, char usart, const char *path)
{
    FILE *file = fopen(path ? path : "/dev/null", "wb");
    uint32_t flags = 0;
    if (!file) {
        die("cannot write", path);
    }
    avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS(usart), &flags);
    flags &= ~(uint32_t)AVR_UART_FLAG_STDIO;
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS(usart), &flags);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ(usart), UART_IRQ_OUTPUT),
                            on_byte, file);
    return file;
}

static uint16_t stack_pointer(const avr_t *avr)
{
    return (uint16_t)(avr->data[R_SPL] | avr->data[R_SPH] << 8);
}

static void roi_leave(roi *r, uint64_t cycle)
{
    uint64_t cycles = cycle - r->start - r->interrupted;
    r->min = cycles < r->min ? cycles : r->min;
    r->max = cycles > r->max ? cycles : r->max;
    r->total += cycles;
    r->calls++;
    r->entry_sp = 0;
}

/* Before each instruction: has the function been entered, or has it returned? The entry SP is that
 * with the return address pushed; it is exceeded again by the return, and by nothing before. */
static void roi_step(roi *r, const avr_t *avr)
{
    uint16_t sp = stack_pointer(avr);
    if (!r->entry_sp && avr->pc == r->entry && r->entry) {
        r->entry_sp = sp;
        r->start = avr->cycle;
        r->interrupted = 0;
    } else if (r->entry_sp && sp > r->entry_sp) {
        roi_leave(r, avr->cycle);
    }
}

static int run(avr_t *avr, roi *r)
{
    int state;
    do {
        roi_step(r, avr);
        int in_interrupt = avr->interrupts.running_ptr > 0;
        uint64_t before = avr->cycle;
        state = avr_run(avr);
        if (in_interrupt || avr->interrupts.running_ptr > 0) {
            r->interrupted += avr->cycle - before;
        }
        uint16_t sp = stack_pointer(avr);
        if (avr->cycle > 1000 && sp < r->lowest_sp) { /* the start code has set SP up by then */
            r->lowest_sp = sp;
        }
    } while (state != cpu_Done && state != cpu_Crashed);
    return state;
}

int main(int argc, char **argv)
{
    options o = parse(argc, argv);
    elf_firmware_t firmware;
    roi r = {.min = UINT64_MAX, .entry = o.roi, .lowest_sp = UINT16_MAX};
    memset(&firmware, 0, sizeof firmware);
    if (elf_read_firmware(o.image, &firmware) < 0) {
        die("cannot read", o.image);
    }
    avr_t *avr = avr_make_mcu_by_name(o.mcu);
    if (!avr) {
        die("unknown MCU", o.mcu);
    }
    avr_init(avr);
    firmware.frequency = o.hz;
    avr_load_firmware(avr, &firmware);
    avr->log = LOG_ERROR;
    FILE *log_file = capture(avr, '0', o.log);
    FILE *bus_file = capture(avr, '1', o.bus);
    int state = run(avr, &r);
    fclose(log_file);
    fclose(bus_file);
    printf("cycles %llu peak stack %u\n", (unsigned long long)avr->cycle,
           (unsigned)(avr->ramend - r.lowest_sp));
    if (r.calls) {
        printf("roi calls %llu min %llu max %llu total %llu\n", (unsigned long long)r.calls,
               (unsigned long long)r.min, (unsigned long long)r.max, (unsigned long long)r.total);
    }
    return state == cpu_Crashed ? CRASHED : avr->data[GPIOR0_ADDRESS];
}

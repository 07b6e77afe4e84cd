/* Runs an AVR image in simavr: both serial lines into files, cycles between two addresses, stack.
 *   avr_run [--log FILE] [--bus FILE] [--reply FILE] [--mcu NAME] [--hz N] [--roi ADDRESS]
 *           IMAGE.elf
 * --reply is what arrives on the bus, one byte after each of the first that the image sends.
 * --roi gives the byte address of a function; cycles are counted from each entry to its return,
 * without the cycles of interrupts that came in between. The exit code is GPIOR0 when the image
 * stops in a sleep with interrupts off, 98 when it crashed.
 * SPDX-License-Identifier: MIT */
#define _POSIX_C_SOURCE 200809L
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>

#define GPIOR0_ADDRESS 0x3e /* ATmega640/1280/2560 and 328: the same data address */
#define CRASHED        98

typedef struct {
    const char *log, *bus, *reply, *mcu, *image;
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
        } else if (!strcmp(argv[i], "--reply")) {
            o.reply = argv[i + 1];
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

/* A serial line: what leaves goes to `out`, what arrives comes from `in`, if there is any. */
typedef struct {
    FILE *out, *in;
    avr_irq_t *input;
} line;

static void on_byte(struct avr_irq_t *irq, uint32_t value, void *data)
{
    line *l = data;
    (void)irq;
    putc((int)(value & 0xffu), l->out);
    int reply = l->in ? getc(l->in) : EOF;
    if (reply != EOF) {
        avr_raise_irq(l->input, (uint32_t)reply);
    }
}

static FILE *open_or_die(const char *path, const char *mode)
{
    FILE *file = fopen(path ? path : "/dev/null", mode);
    if (!file) {
        die("cannot open", path);
    }
    return file;
}

/* Takes simavr's own echo off the USART and connects it to the line. */
static void connect(avr_t *avr, char usart, line *l)
{
    uint32_t irqs = (uint32_t)AVR_IOCTL_UART_GETIRQ(usart);
    uint32_t flags = 0;
    avr_ioctl(avr, (uint32_t)AVR_IOCTL_UART_GET_FLAGS(usart), &flags);
    flags &= ~(uint32_t)AVR_UART_FLAG_STDIO;
    avr_ioctl(avr, (uint32_t)AVR_IOCTL_UART_SET_FLAGS(usart), &flags);
    l->input = avr_io_getirq(avr, irqs, UART_IRQ_INPUT);
    avr_irq_register_notify(avr_io_getirq(avr, irqs, UART_IRQ_OUTPUT), on_byte, l);
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
 * with the return address pushed, which the return takes away. More than that is a function within
 * that gives its frame back: SP's upper byte is written first. */
static void roi_step(roi *r, const avr_t *avr)
{
    uint16_t sp = stack_pointer(avr);
    if (!r->entry_sp && avr->pc == r->entry && r->entry) {
        r->entry_sp = sp;
        r->start = avr->cycle;
        r->interrupted = 0;
    } else if (r->entry_sp && sp == r->entry_sp + avr->address_size) {
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

static void report(const avr_t *avr, const roi *r)
{
    printf("cycles %llu peak stack %u\n", (unsigned long long)avr->cycle,
           (unsigned)(avr->ramend - r->lowest_sp));
    if (r->calls) {
        printf("roi calls %llu min %llu max %llu total %llu\n", (unsigned long long)r->calls,
               (unsigned long long)r->min, (unsigned long long)r->max,
               (unsigned long long)r->total);
    }
}

static avr_t *load(const options *o)
{
    elf_firmware_t firmware;
    memset(&firmware, 0, sizeof firmware);
    avr_t *avr = avr_make_mcu_by_name(o->mcu);
    if (!avr || elf_read_firmware(o->image, &firmware) < 0) {
        die("unknown MCU or unreadable image:", o->image);
    }
    avr_init(avr);
    firmware.frequency = o->hz;
    avr_load_firmware(avr, &firmware);
    avr->log = LOG_ERROR;
    return avr;
}

int main(int argc, char **argv)
{
    options o = parse(argc, argv);
    roi r = {.min = UINT64_MAX, .entry = o.roi, .lowest_sp = UINT16_MAX};
    line log_line = {.out = open_or_die(o.log, "wb")};
    line bus_line = {.out = open_or_die(o.bus, "wb"), .in = open_or_die(o.reply, "rb")};
    avr_t *avr = load(&o);
    connect(avr, '0', &log_line);
    connect(avr, '1', &bus_line);
    int state = run(avr, &r);
    fclose(log_line.out);
    fclose(bus_line.out);
    report(avr, &r);
    return state == cpu_Crashed ? CRASHED : avr->data[GPIOR0_ADDRESS];
}

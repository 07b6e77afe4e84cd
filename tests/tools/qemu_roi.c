/* QEMU plugin: instructions of each call of one function, and the deepest stack.
 *   -plugin libqemu_roi.so,entry=A[,stack_low=A,stack_high=A] -d plugin
 * A call lasts from its first instruction to the instruction before the one it returns to; the
 * return address is where the calling block ended. A function that is entered by a tail call has
 * no such address: that is reported as lost, never counted. No interrupts, no recursion.
 * Source: QEMU docs/devel/tcg-plugins; the prototypes are declared here because distributions do
 * not ship qemu-plugin.h. Works with plugin API 0 and 1 (QEMU 4.2 to 7.2, not later).
 * SPDX-License-Identifier: MIT */
#include <inttypes.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define API_VERSION      1
#define NO_REGISTERS     0
#define READS_AND_WRITES 3
#define ADD_U64          0

struct qemu_plugin_tb;
struct qemu_plugin_insn;
typedef void (*exec_callback)(unsigned cpu, void *data);
typedef void (*memory_callback)(unsigned cpu, uint32_t info, uint64_t address, void *data);

extern void qemu_plugin_register_vcpu_tb_trans_cb(uint64_t id,
                                                  void (*)(uint64_t, struct qemu_plugin_tb *));
extern void qemu_plugin_register_atexit_cb(uint64_t id, void (*)(uint64_t, void *), void *data);
extern size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *tb);
extern struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *, size_t);
extern uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *insn);
extern size_t qemu_plugin_insn_size(const struct qemu_plugin_insn *insn);
extern void qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb *, exec_callback, int,
                                                 void *data);
extern void qemu_plugin_register_vcpu_insn_exec_inline(struct qemu_plugin_insn *, int, void *,
                                                       uint64_t);
extern void qemu_plugin_register_vcpu_mem_cb(struct qemu_plugin_insn *, memory_callback, int, int,
                                             void *data);
extern bool qemu_plugin_mem_is_store(uint32_t info);
extern void qemu_plugin_outs(const char *text);

#define EXPORT __attribute__((visibility("default")))
EXPORT extern int qemu_plugin_version;
EXPORT int qemu_plugin_install(uint64_t id, const void *info, int argc, char **argv);
EXPORT int qemu_plugin_version = API_VERSION;

/* Where a block of code starts and ends; lives as long as QEMU does. */
typedef struct {
    uint64_t start, end;
} block;

static uint64_t entry, stack_low, stack_high;
static uint64_t instructions; /* executed so far, kept by inline code */
static uint64_t previous_end; /* of the block that ran last */
static bool inside;
static uint64_t return_to, instructions_at_entry;
static uint64_t calls, lost, total, most, least = UINT64_MAX;
static uint64_t deepest = UINT64_MAX, deepest_inside = UINT64_MAX;

static void on_block(unsigned cpu, void *data)
{
    const block *b = data;
    (void)cpu;
    if (inside && b->start == return_to) {
        uint64_t count = instructions - instructions_at_entry;
        least = count < least ? count : least;
        most = count > most ? count : most;
        total += count;
        calls++;
        inside = false;
    }
    if (b->start == entry) {
        lost += inside;
        inside = true;
        return_to = previous_end;
        instructions_at_entry = instructions;
    }
    previous_end = b->end;
}

static void on_memory(unsigned cpu, uint32_t info, uint64_t address, void *data)
{
    (void)cpu;
    (void)data;
    if (!qemu_plugin_mem_is_store(info) || address < stack_low || address >= stack_high) {
        return;
    }
    deepest = address < deepest ? address : deepest;
    if (inside) {
        deepest_inside = address < deepest_inside ? address : deepest_inside;
    }
}

static void on_translation(uint64_t id, struct qemu_plugin_tb *tb)
{
    size_t count = qemu_plugin_tb_n_insns(tb);
    const struct qemu_plugin_insn *last = qemu_plugin_tb_get_insn(tb, count - 1);
    block *b = malloc(sizeof *b);
    (void)id;
    if (!b) {
        abort();
    }
    b->start = qemu_plugin_insn_vaddr(qemu_plugin_tb_get_insn(tb, 0));
    b->end = qemu_plugin_insn_vaddr(last) + qemu_plugin_insn_size(last);
    qemu_plugin_register_vcpu_tb_exec_cb(tb, on_block, NO_REGISTERS, b);
    for (size_t i = 0; i < count; i++) {
        struct qemu_plugin_insn *insn = qemu_plugin_tb_get_insn(tb, i);
        qemu_plugin_register_vcpu_insn_exec_inline(insn, ADD_U64, &instructions, 1);
        if (stack_high) {
            qemu_plugin_register_vcpu_mem_cb(insn, on_memory, NO_REGISTERS, READS_AND_WRITES, NULL);
        }
    }
}

static void on_exit(uint64_t id, void *data)
{
    char text[256];
    (void)id;
    (void)data;
    snprintf(text, sizeof text, "instructions %" PRIu64 " peak stack %" PRIu64 "\n", instructions,
             deepest == UINT64_MAX ? 0 : stack_high - deepest);
    qemu_plugin_outs(text);
    if (calls || lost) {
        snprintf(text, sizeof text,
                 "roi calls %" PRIu64 " min %" PRIu64 " max %" PRIu64 " total %" PRIu64
                 " peak stack %" PRIu64 " lost %" PRIu64 "\n",
                 calls, least, most, total,
                 deepest_inside == UINT64_MAX ? 0 : stack_high - deepest_inside, lost);
        qemu_plugin_outs(text);
    }
}

static void option(const char *name, const char *value)
{
    uint64_t number = strtoull(value, NULL, 0);
    if (!strcmp(name, "entry")) {
        entry = number;
    } else if (!strcmp(name, "stack_low")) {
        stack_low = number;
    } else if (!strcmp(name, "stack_high")) {
        stack_high = number;
    }
}

int qemu_plugin_install(uint64_t id, const void *info, int argc, char **argv)
{
    (void)info;
    for (int i = 0; i < argc; i++) {
        char *value = strchr(argv[i], '=');
        if (value) {
            *value = 0;
            option(argv[i], value + 1);
        }
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, on_translation);
    qemu_plugin_register_atexit_cb(id, on_exit, NULL);
    return 0;
}

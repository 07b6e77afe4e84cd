/* Image that hashes the results of every function of wg_mul.h, which each kind of processor has its
 * own way to compute: the lines must be the same on all boards. tests/test_player_mul.c checks the
 * host's results.
 *   logs "NAME XXXXXXXX" (FNV-1a, 32 bits, over little-endian bytes) for each and stops with 0
 * SPDX-License-Identifier: MIT */
#include "hal.h"
#include "mul_pairs.h"

static uint32_t hash_function(uint8_t function)
{
    uint32_t hash = UINT32_C(2166136261), seed = 1, sum = 0;
    for (uint32_t i = 0; i < MUL_PAIRS; i++) {
        uint32_t word = mul_result(function, mul_fit(function, mul_pair_at(i, &seed)));
        sum += (uint8_t)word; /* AVR: with carries into r1, which a product must have left at 0 */
        for (uint8_t byte = 0; byte < 4; byte++) {
            hash = (hash ^ (word & 0xffu)) * UINT32_C(16777619);
            word >>= 8;
        }
    }
    return hash ^ sum;
}

static void log_hash(const char *name, uint32_t hash)
{
    char text[] = "----- 00000000";
    for (uint8_t i = 0; name[i]; i++) {
        text[i] = name[i];
    }
    for (uint8_t digit = 0; digit < 8; digit++) {
        text[13 - digit] = "0123456789abcdef"[hash & 15u];
        hash >>= 4;
    }
    hal_log(text);
}

int main(void)
{
    hal_init();
    for (uint8_t function = 0; function < MUL_FUNCTIONS; function++) {
        log_hash(mul_names[function], hash_function(function));
    }
    hal_stop(0);
    return 0;
}

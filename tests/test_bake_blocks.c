/* Where vertices stand and what blocks of them hold, as packed.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "check.h"
#include "record.h"
#include "shape_pack.h"
#include "shape_parts.h"

#include <stdlib.h>
#include <string.h>

static uint32_t seed;

/* -1..1 */
static double noise(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (seed >> 8) / 8388608.0 - 1;
}

/* The dense displacement of a basis, decoded from packed bytes by the table of SPEC 4.15. */
static void decode(const packed *out, int block, int basis, double *dense)
{
    const uint8_t *r = out->at[WG_SECTION_BLOCKS].at + WG_BLOCK_BYTES * (unsigned)block;
    const uint8_t *d = out->at[WG_SECTION_DATA].at + get32(r + WG_BLOCK_DATA);
    int n = 3 * get16(r + WG_BLOCK_COUNT), first = 3 * get16(r + WG_BLOCK_FIRST);
    int b = get16(r + WG_BLOCK_B), pair = b != (int)WG_ABSENT;
    int half = get16(r + WG_BLOCK_A) == basis ? 0 : pair && b == basis ? 1 : -1;
    for (int i = 0; i < n && half >= 0; i++) {
        if (get8(r + WG_BLOCK_BITS) == 16) {
            dense[first + i] += (int16_t)get16(d + 2 * (pair ? 2 * i + half : i));
        } else {
            int at = pair ? i / 2 * 4 + 2 * half + i % 2 : i;
            dense[first + i] += 256 * (int8_t)d[at];
        }
    }
}

static void packed_blocks_hold_every_entry(int bits)
{
    enum { N = 101, K = 7 };
    shape_form form = {.vertex_count = N, .bits = bits, .affine = -1, .basis_count = K};
    build b = {.scene = &(scene){.path = bake_copy("test")}, .frac = bake_alloc(K, sizeof(int))};
    packed out;
    bake_error error = {""};
    shapes sh = {.count = 1, .mesh = bake_alloc(1, sizeof *sh.mesh)};
    memset(&out, 0, sizeof out);
    form.rest = bake_alloc(3 * N, sizeof *form.rest);
    form.basis = bake_alloc(K, sizeof *form.basis);
    seed = 5;
    for (int j = 0; j < K; j++) { /* local, apart, overlapping, with holes, everywhere, nowhere */
        form.basis[j] = (shape_basis){.channel = j, .piece = -1, .scale = 1e-3};
        form.basis[j].entry = bake_alloc(3 * N, sizeof(int16_t));
        for (int i = 0; i < N; i++) {
            int in = j == 0   ? i < 11
                     : j == 1 ? i >= 50 && i < 60
                     : j == 2 ? i < 20
                     : j == 3 ? i % 9 == 0
                     : j == 6 ? 0
                              : 1;
            for (int k = 0; k < 3 && in; k++) {
                form.basis[j].entry[3 * i + k] = (int16_t)(256 * (int)(100 * noise()));
            }
        }
    }
    shape_make_blocks(&form);
    sh.mesh->form = form;
    b.shapes = &sh;
    CHECK_EQ(shapes_pack(&b, &out, &error), 0);
    CHECK_EQ(out.count[WG_SECTION_BLOCKS], form.block_count);
    size_t total = 0;
    for (int j = 0; j < K; j++) {
        double dense[3 * N] = {0};
        for (int i = 0; i < form.block_count; i++) {
            decode(&out, i, j, dense);
        }
        for (int i = 0; i < 3 * N; i++) {
            CHECK_EQ(dense[i], form.basis[j].entry[i]);
        }
    }
    for (int i = 0; i < form.block_count; i++) {
        total += shape_block_bytes(&form, &form.block[i]);
    }
    size_t left = 6 * N + 3; /* rest, and alignment */
    CHECK(out.at[WG_SECTION_BLOCKS].count + out.at[WG_SECTION_DATA].count <= total + left);
    CHECK(out.at[WG_SECTION_BLOCKS].count + out.at[WG_SECTION_DATA].count + 3 >= total + 6 * N);
    for (unsigned i = 0; i <= WG_SECTION_KNOWN; i++) {
        bytes_free(&out.at[i]);
    }
    shape_form_free(&form);
    free(sh.mesh);
    free(b.frac);
    free(((scene *)(uintptr_t)b.scene)->path);
}

static void packed_blocks_hold_every_8_bit_entry(void)
{
    packed_blocks_hold_every_entry(8);
}

static void packed_blocks_hold_every_16_bit_entry(void)
{
    packed_blocks_hold_every_entry(16);
}

/* Local shapes side by side, in any order of the vertices: after sorting each basis is one block. */
static void sorting_makes_one_block_of_a_local_shape(void)
{
    enum { N = 300, K = 5 };
    uint64_t moves[N];
    int order[N], runs[K] = {0}, seen[N] = {0};
    seed = 11;
    for (int i = 0; i < N; i++) { /* shape j moves a fifth of them and shares some with the next */
        int j = (int)((noise() + 1) / 2 * 6);
        moves[i] = j >= K ? 0 : (uint64_t)1 << j | (noise() > 0.6 && j + 1 < K ? 2ull << j : 0);
    }
    shape_order(moves, N, order);
    for (int i = 0; i < N; i++) {
        seen[order[i]]++;
        for (int j = 0; j < K; j++) {
            int on = moves[order[i]] >> j & 1, was = i > 0 && (moves[order[i - 1]] >> j & 1);
            runs[j] += on && !was;
        }
    }
    for (int i = 0; i < N; i++) {
        CHECK_EQ(seen[i], 1);
    }
    for (int j = 0; j < K; j++) { /* a chain of overlaps: Gray order keeps neighbours together */
        CHECK(runs[j] <= 2);
    }
    CHECK_EQ(moves[order[N - 1]], 0);
}

int main(void)
{
    TEST(packed_blocks_hold_every_8_bit_entry);
    TEST(packed_blocks_hold_every_16_bit_entry);
    TEST(sorting_makes_one_block_of_a_local_shape);
    return check_done();
}

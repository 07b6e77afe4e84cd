/* Shapes: poses against a dense model of SPEC 6.8, and against closed forms.
 * SPDX-License-Identifier: MIT */
#include "shape_fixture.h"

static void open_model(fixture *f, model *m, uint32_t *state)
{
    static const build_shape_data LIKE = {0, FRAC, WG_ABSENT, {-300, 70000, 5}, NULL};
    build b = {{{0}}, 1};
    begin(&b);
    model_build(m, &b, &LIKE, state);
    open_fixture(f, &b);
    memcpy(f->values, m->value, sizeof m->value);
}

static int64_t model_posed(const model *m, unsigned bases, unsigned i)
{
    static const int32_t ORIGIN[3] = {-300, 70000, 5};
    return 256 * (model_component_at(m, bases, i) + ORIGIN[i % 3u]);
}

/* ---- bases ----------------------------------------------------------------------------------- */

static void sums_are_those_of_dense_bases(void)
{
    static model m;
    fixture f;
    wg_pose pose;
    uint32_t state = 1;
    for (unsigned n = 0; n < 300; n++) {
        open_model(&f, &m, &state);
        wg_pose_init(&pose, &f.file, 0, f.weights);
        wg_pose_set(&pose, f.values, WG_BASES_MAX, NULL);
        CHECK_EQ(pose.vertices, m.vertices);
        int32_t *xyz = posed(&pose, 0, m.vertices);
        for (unsigned i = 0; i < 3u * m.vertices; i++) {
            CHECK_EQ(xyz[i], model_posed(&m, WG_BASES_MAX, i));
        }
        free(xyz);
        free(f.clip);
    }
}

static void every_cut_gives_the_same_vertices(void)
{
    static model m;
    fixture f;
    wg_pose pose;
    uint32_t state = 77;
    for (unsigned n = 0; n < 12; n++) {
        open_model(&f, &m, &state);
        wg_pose_init(&pose, &f.file, 0, f.weights);
        wg_pose_set(&pose, f.values, WG_BASES_MAX, NULL);
        for (unsigned first = 0; first < m.vertices; first++) {
            for (unsigned count = 0; count <= m.vertices - first; count++) {
                int32_t *xyz = posed(&pose, first, count);
                for (unsigned i = 0; i < 3u * count; i++) {
                    CHECK_EQ(xyz[i], model_posed(&m, WG_BASES_MAX, 3u * first + i));
                }
                free(xyz);
            }
        }
        free(f.clip);
    }
}

static void the_first_bases_alone_are_a_level_of_detail(void)
{
    static model m;
    fixture f;
    wg_pose pose;
    uint32_t state = 4;
    for (unsigned n = 0; n < 40; n++) {
        open_model(&f, &m, &state);
        wg_pose_init(&pose, &f.file, 0, f.weights);
        for (unsigned bases = 0; bases <= m.bases; bases++) {
            wg_pose_set(&pose, f.values, (uint16_t)bases, NULL);
            int32_t *xyz = posed(&pose, 0, m.vertices);
            for (unsigned i = 0; i < 3u * m.vertices; i++) {
                CHECK_EQ(xyz[i], model_posed(&m, bases, i));
            }
            free(xyz);
        }
        free(f.clip);
    }
}

/* One vertex with one basis: gain 2^14, shift 2 make a weight of a 16th of the value. */
static void weights_are_rounded_and_clamped(void)
{
    static const struct {
        int32_t value;
        int weight;
    } CASES[] = {{0, 0},
                 {8, 1},
                 {7, 0},
                 {-8, 0},
                 {-9, -1},
                 {160, 10},
                 {16 * 32767, 32767},
                 {16 * 32768, 32767},
                 {1 << 29, 32767},
                 {-16 * 32767, -32767},
                 {-16 * 32768, -32767},
                 {-(1 << 29), -32767}};
    static const int16_t REST[3] = {100, -200, 300}, MOVED[3] = {32767, 16384, -32768};
    const build_shape_data shape = {1, FRAC, WG_ABSENT, {0, 0, 0}, REST};
    const build_block_data block = {0, WG_ABSENT, 0, 1, 16, MOVED, NULL};
    build b = {{{0}}, 1};
    fixture f;
    wg_pose pose;
    begin(&b);
    build_shape(&b, &shape);
    build_basis(&b, 0, 16384, 2);
    build_block(&b, &block);
    open_fixture(&f, &b);
    wg_pose_init(&pose, &f.file, 0, f.weights);
    for (unsigned n = 0; n < sizeof CASES / sizeof *CASES; n++) {
        f.values[0] = CASES[n].value;
        wg_pose_set(&pose, f.values, 1, NULL);
        CHECK_EQ(f.weights[0], CASES[n].weight);
        int32_t xyz[3];
        wg_pose_vertices(&pose, 0, 1, xyz);
        for (unsigned c = 0; c < 3; c++) {
            double moved = REST[c] + CASES[n].weight * (double)MOVED[c] / 32768;
            CHECK_EQ(xyz[c], 256 * (int32_t)(int16_t)floor(moved + 0.5));
        }
    }
    free(f.clip);
}

/* ---- the affine part ------------------------------------------------------------------------- */

static void the_identity_is_as_good_as_none(void)
{
    static const int32_t ORIGIN[3] = {1 << 20, -(1 << 22), 99};
    fixture with, without;
    wg_pose a, b;
    int32_t xyz[2][9];
    open_points(&with, AFFINE, ORIGIN);
    open_points(&without, WG_ABSENT, ORIGIN);
    wg_pose_init(&a, &with.file, 0, with.weights);
    wg_pose_init(&b, &without.file, 0, without.weights);
    wg_pose_set(&a, with.values, 0, NULL);
    wg_pose_set(&b, without.values, 0, NULL);
    wg_pose_vertices(&a, 0, POINT_COUNT, xyz[0]);
    wg_pose_vertices(&b, 0, POINT_COUNT, xyz[1]);
    for (unsigned i = 0; i < 9; i++) {
        CHECK_EQ(xyz[0][i], xyz[1][i]);
        CHECK_EQ(xyz[1][i], 256 * (POINTS[i] + ORIGIN[i % 3u]));
    }
    free(with.clip);
    free(without.clip);
}

/* Entries whose products are whole: turns by 90 degrees, scales, sums. `bits` is what they leave. */
static void check_exact(const double *entry, unsigned bits)
{
    static const int32_t ORIGIN[3] = {1000, -2000, 3000};
    fixture f;
    wg_pose pose;
    int32_t xyz[9];
    open_points(&f, AFFINE, ORIGIN);
    set_entries(&f, entry);
    for (unsigned r = 0; r < 3; r++) { /* 3 r - 2.5 units of length */
        f.values[AFFINE + 9u + r] = (int32_t)((3 * (int)r - 2) * (1 << WAY) - (1 << (WAY - 1)));
    }
    wg_pose_init(&pose, &f.file, 0, f.weights);
    wg_pose_set(&pose, f.values, 0, NULL);
    CHECK_EQ(pose.turn_bits, bits);
    wg_pose_vertices(&pose, 0, POINT_COUNT, xyz);
    for (unsigned i = 0; i < 9; i++) {
        const double *row = entry + 3u * (i % 3u);
        const int16_t *p = POINTS + i / 3u * 3u;
        double want = row[0] * p[0] + row[1] * p[1] + row[2] * p[2];
        want += ORIGIN[i % 3u] + ldexp(3 * (int)(i % 3u) - 2.5, FRAC);
        CHECK_EQ(xyz[i], (int64_t)floor(256 * want));
    }
    free(f.clip);
}

static void whole_entries_are_exact(void)
{
    static const double TURN_Z[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
    static const double TURN_X[9] = {1, 0, 0, 0, 0, -1, 0, 1, 0};
    static const double TWICE_LESS[9] = {1.5, 0, 0, 0, -1.5, 0, 0, 0, 1.75};
    static const double THREE[9] = {3, 0, 0, 0, 3, 0, 0, 0, 3};
    static const double ROW_FITS[9] = {1, 1, 1, -1, 1, -1.75, 0.5, 0, 0}; /* 4 - 2^-14 at most */
    static const double ROW_DOES_NOT[9] = {1.5, 1.5, -1.5, 0, 0, 0, 0.5, 0, 1}; /* 4.5 */
    static const double HUGE_ONE[9] = {127, 0, 0, 0, 0.5, 0, 0, 0, -127};
    check_exact(TURN_Z, 14);
    check_exact(TURN_X, 14);
    check_exact(TWICE_LESS, 14);
    check_exact(THREE, 13);
    check_exact(ROW_FITS, 14);
    check_exact(ROW_DOES_NOT, 13);
    check_exact(HUGE_ONE, 8);
}

static void entries_beyond_128_are_clamped(void)
{
    static const int32_t NOWHERE[3] = {0, 0, 0};
    static const double ENTRY_OF[9] = {500, -500, 20, 3, 0, 0, 0, 0, 1};
    static const int16_t WANT[9] = {21845, -21845, 5120, 768, 0, 0, 0, 0, 256};
    fixture f;
    wg_pose pose;
    int32_t xyz[9];
    open_points(&f, AFFINE, NOWHERE);
    set_entries(&f, ENTRY_OF);
    wg_pose_init(&pose, &f.file, 0, f.weights);
    wg_pose_set(&pose, f.values, 0, NULL);
    CHECK_EQ(pose.turn_bits, 8);
    for (unsigned i = 0; i < 9; i++) {
        CHECK_EQ(pose.turn[i], WANT[i]);
    }
    wg_pose_vertices(&pose, 0, POINT_COUNT, xyz);
    CHECK_EQ(xyz[0], 21845 * 4000 + 21845 * 3000 + 5120 * 2000);
    free(f.clip);
}

/* A row of 65535 steps is the most: with 65536, three coordinates of -32768 would make 2^31. */
static void rows_add_up_to_65535_at_the_most(void)
{
    static const int32_t NOWHERE[3] = {0, 0, 0};
    for (int last = 1; last <= 2; last++) {
        const double step = ldexp(1, -14);
        const double entry[9] = {0, 0, 0, 32767 * step, -32767 * step, last * step, 0, 0, 1};
        fixture f;
        wg_pose pose;
        int32_t xyz[9];
        open_points(&f, AFFINE, NOWHERE);
        set_entries(&f, entry);
        wg_pose_init(&pose, &f.file, 0, f.weights);
        wg_pose_set(&pose, f.values, 0, NULL);
        CHECK_EQ(pose.turn_bits, last == 1 ? 14 : 13);
        wg_pose_vertices(&pose, 0, POINT_COUNT, xyz);
        CHECK_EQ(xyz[8], 256 * POINTS[8]);
        free(f.clip);
    }
}

/* 2^5 a raw unit of the channel: the way is exact until it reaches 2^30. */
static void the_way_saturates_at_2_30(void)
{
    static const struct {
        int32_t value, move;
    } CASES[] = {{(1 << 24) + 12345, ((1 << 24) + 12345) * 32},
                 {(1 << 25) - 1, ((1 << 25) - 1) * 32},
                 {1 << 25, (1 << 30) - 1},
                 {1 << 29, (1 << 30) - 1},
                 {-(1 << 25) + 1, (-(1 << 25) + 1) * 32},
                 {-(1 << 29), -(1 << 30) + 1}};
    static const int32_t NOWHERE[3] = {0, 0, 0};
    fixture f;
    wg_pose pose;
    open_points(&f, AFFINE, NOWHERE);
    wg_pose_init(&pose, &f.file, 0, f.weights);
    for (unsigned n = 0; n < sizeof CASES / sizeof *CASES; n++) {
        f.values[AFFINE + 10u] = CASES[n].value;
        wg_pose_set(&pose, f.values, 0, NULL);
        CHECK_EQ(pose.move[1], CASES[n].move);
    }
    free(f.clip);
}

/* Any values at all: nothing overflows (the sanitizers watch), and rows stay within 65535. */
static void no_value_overflows(void)
{
    fixture f;
    wg_pose pose, normals;
    uint32_t state = 9;
    int32_t xyz[9];
    for (unsigned n = 0; n < 4000; n++) {
        const int32_t origin[3] = {1 << 28, -(1 << 28), n & 1u ? 1 << 28 : 0};
        wg_rigid camera = {{1 << 30, 0, 0, 0, 0, 1 << 30, 0, -(1 << 30), 0},
                           {(1 << 30) - 1, -(1 << 30) + 1, 7},
                           (int8_t)(n % 256u)};
        int32_t turn[3] = {759250125, 759250125, 0}; /* 45 degrees */
        if (n % 3u == 0) {
            camera.turn_q30[0] = camera.turn_q30[1] = turn[0];
            camera.turn_q30[6] = -turn[1];
            camera.turn_q30[7] = 0;
        }
        open_points(&f, AFFINE, origin);
        for (unsigned i = AFFINE; i < CHANNELS; i++) {
            int32_t v = (int32_t)(model_next(&state) << 6) - (1 << 29);
            f.values[i] = v >> (n % 4u == 3 ? 0 : model_next(&state) % 16u);
        }
        wg_pose_init(&pose, &f.file, 0, f.weights);
        wg_pose_set(&pose, f.values, 0, n % 2u ? &camera : NULL);
        wg_pose_init(&normals, &f.file, 1, f.weights);
        wg_pose_set_normals(&normals, f.values, 0, &pose);
        for (unsigned r = 0; r < 3; r++) {
            CHECK(abs(pose.turn[3 * r]) + abs(pose.turn[3 * r + 1]) + abs(pose.turn[3 * r + 2]) <=
                  65535);
            CHECK(abs(normals.turn[3 * r]) + abs(normals.turn[3 * r + 1]) +
                      abs(normals.turn[3 * r + 2]) <=
                  65535);
        }
        wg_pose_vertices(&pose, 0, POINT_COUNT, xyz);
        wg_pose_vertices(&normals, 0, POINT_COUNT, xyz);
        free(f.clip);
    }
}

int main(void)
{
    TEST(sums_are_those_of_dense_bases);
    TEST(every_cut_gives_the_same_vertices);
    TEST(the_first_bases_alone_are_a_level_of_detail);
    TEST(weights_are_rounded_and_clamped);
    TEST(the_identity_is_as_good_as_none);
    TEST(whole_entries_are_exact);
    TEST(entries_beyond_128_are_clamped);
    TEST(rows_add_up_to_65535_at_the_most);
    TEST(the_way_saturates_at_2_30);
    TEST(no_value_overflows);
    return check_done();
}

/* Shapes: what turns with a pose, normals and camera, against closed forms and doubles.
 * SPDX-License-Identifier: MIT */
#include "shape_fixture.h"

/* ---- normals --------------------------------------------------------------------------------- */

/* What POINTS become as normals under an affine part. */
static void pose_normals(const double *entry, int32_t *xyz, int16_t *turn)
{
    static const int32_t ORIGIN[3] = {5, 6, 7}; /* not looked at */
    fixture f;
    wg_pose pose, normals;
    int16_t weights[1];
    open_points(&f, AFFINE, ORIGIN);
    set_entries(&f, entry);
    f.values[AFFINE + 9u] = 12345; /* nor is the way */
    wg_pose_init(&pose, &f.file, 0, f.weights);
    wg_pose_set(&pose, f.values, 0, NULL);
    wg_pose_init(&normals, &f.file, 1, weights);
    wg_pose_set_normals(&normals, f.values, 0, &pose);
    wg_pose_vertices(&normals, 0, POINT_COUNT, xyz);
    memcpy(turn, normals.turn, sizeof normals.turn);
    free(f.clip);
}

/* n' = M^-T n up to length; det M < 0 turns it round, as it does the corners of a triangle. */
static void normals_turn_with_the_cofactors(void)
{
    static const struct {
        double entry[9];
        int16_t want[9];
    } CASES[] = {
        {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {16384, 0, 0, 0, 16384, 0, 0, 0, 16384}},
        {{0, -1, 0, 1, 0, 0, 0, 0, 1}, {0, -16384, 0, 16384, 0, 0, 0, 0, 16384}},
        {{1, 0.5, 0, 0, 1, 0, 0, 0, 1}, {16384, 0, 0, -8192, 16384, 0, 0, 0, 16384}},
        {{-1, 0, 0, 0, 1, 0, 0, 0, 1}, {16384, 0, 0, 0, -16384, 0, 0, 0, -16384}},
        {{0.5, 0, 0, 0, 1, 0, 0, 0, 1}, {16384, 0, 0, 0, 8192, 0, 0, 0, 8192}},
        {{0.0078125, 0, 0, 0, 0.0078125, 0, 0, 0, 0.0078125}, /* products of 2^14: one shift */
         {8192, 0, 0, 0, 8192, 0, 0, 0, 8192}},
        {{1, 1, 1, 1, 1, 1, 1, 1, 1}, {0, 0, 0, 0, 0, 0, 0, 0, 0}},
    };
    for (unsigned n = 0; n < sizeof CASES / sizeof *CASES; n++) {
        int32_t xyz[9];
        int16_t turn[9];
        pose_normals(CASES[n].entry, xyz, turn);
        for (unsigned i = 0; i < 9; i++) {
            const int16_t *row = CASES[n].want + 3u * (i % 3u), *p = POINTS + i / 3u * 3u;
            CHECK_EQ(turn[i], CASES[n].want[i]);
            CHECK_EQ(xyz[i], (int64_t)floor((row[0] * (double)p[0] + row[1] * (double)p[1] +
                                             row[2] * (double)p[2]) /
                                            64));
        }
    }
}

static void cross(const double *a, const double *b, double *out)
{
    for (unsigned i = 0; i < 3; i++) {
        out[i] = a[(i + 1u) % 3u] * b[(i + 2u) % 3u] - a[(i + 2u) % 3u] * b[(i + 1u) % 3u];
    }
}

/* The columns of the cofactor matrix are the cross products of M's other two columns. The matrix is
 * stored to half a unit, and its largest entry has at least 10922 units, because one bit more would
 * not have fitted: three entries of 10922 doubled make 65532, at the edge of a row. The positions'
 * own matrix is off by half a unit of 2^-14 an entry, so each product of two by (|a| + |b|) 2^-15. */
static void normals_are_those_of_the_turned_triangle(void)
{
    uint32_t state = 5;
    for (unsigned n = 0; n < 500; n++) {
        double entry[9], column[3][3], c[9], largest = 0;
        int32_t xyz[9];
        int16_t turn[9];
        for (unsigned i = 0; i < 9; i++) {
            entry[i] = ldexp((double)(model_next(&state) % 65536u) - 32768, -15); /* |entry| <= 1 */
            column[i % 3u][i / 3u] = entry[i];
        }
        pose_normals(entry, xyz, turn);
        for (unsigned k = 0; k < 3; k++) {
            double product[3];
            cross(column[(k + 1u) % 3u], column[(k + 2u) % 3u], product);
            for (unsigned r = 0; r < 3; r++) {
                c[3u * r + k] = product[r];
                largest = fmax(largest, fabs(product[r]));
            }
        }
        double unit = 0; /* what one unit of turn stands for: from the largest entry */
        int16_t most = 0;
        for (unsigned i = 0; i < 9; i++) {
            most = (int16_t)(abs(turn[i]) > most ? abs(turn[i]) : most);
        }
        CHECK(most >= 10922);
        /* a power of two */
        unit = ldexp(1, (int)lrint(log2(largest / most)));
        for (unsigned i = 0; i < 9; i++) { /* two products, each off by 2 2^-15 and a little */
            CHECK_NEAR(turn[i] * unit, c[i], 0.5 * unit + 4 * ldexp(1, -15) + ldexp(1, -28));
        }
    }
}

/* ---- a camera -------------------------------------------------------------------------------- */

/* A random rotation in Q30, each entry within half a unit. */
static void random_turn(uint32_t *state, double *turn, int32_t *turn_q30)
{
    double q[4], length = 0;
    for (unsigned i = 0; i < 4; i++) {
        q[i] = (double)(model_next(state) % 20001u) - 10000;
        length += q[i] * q[i];
    }
    for (unsigned i = 0; i < 4; i++) {
        q[i] /= sqrt(length);
    }
    for (unsigned i = 0; i < 9; i++) {
        unsigned r = i / 3u, c = i % 3u, other = 3u - r - c;
        double sign = c == (r + 1u) % 3u ? -1 : 1;
        turn[i] = r == c ? 1 - 2 * (q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - q[r + 1u] * q[r + 1u])
                         : 2 * (q[r + 1u] * q[c + 1u] + sign * q[0] * q[(other % 3u) + 1u]);
        turn_q30[i] = (int32_t)lrint(ldexp(turn[i], 30));
    }
}

/* y = turn (E p + T + origin - centre). Per component, in raw units / 2^8, with P = sum |p_c|:
 *   entries of turn E  half a unit of 2^-turn_bits each, and 12 2^-22 that wg_pose_set cuts off,
 *                      and those of turn off by 2^-31 while |E| <= 2: 3 2 2^-31
 *   shifts             1 for the last one, 12 cut off the way, 1 for the centre, T is exact here,
 *                      three times |turn| <= 1.74 together
 *   turn_q30           3 2^-31 |way|, and |way| < 2^26 */
static double camera_tolerance(const int16_t *p, unsigned turn_bits)
{
    double sum = abs(p[0]) + abs(p[1]) + abs(p[2]);
    double entry = 0.5 * ldexp(1, -(int)turn_bits) + 12 * ldexp(1, -22) + 6 * ldexp(1, -31);
    return 256 * sum * entry + 1 + 12 + 1.74 + 0.1;
}

static void a_camera_turns_what_is_posed(void)
{
    static const int32_t ORIGIN[3] = {1000, -20000, 3000};
    uint32_t state = 3;
    for (unsigned n = 0; n < 400; n++) {
        fixture f;
        wg_pose pose;
        wg_rigid camera;
        double turn[9], e[9], centre[3], way[3];
        int32_t xyz[9];
        camera.centre_frac = (int8_t)(n % 15u + 4u);
        int32_t most = (int32_t)ldexp(1, 25 + camera.centre_frac - FRAC - 8); /* |way| < 2^26 */
        random_turn(&state, turn, camera.turn_q30);
        open_points(&f, AFFINE, ORIGIN);
        for (unsigned i = 0; i < 9; i++) {
            e[i] = ldexp((double)(model_next(&state) % 60000u) - 30000, -14); /* |e| < 2 */
        }
        set_entries(&f, e);
        for (unsigned r = 0; r < 3; r++) {
            f.values[AFFINE + 9u + r] = (int32_t)(model_next(&state) % 100000u) - 50000;
            camera.centre[r] = (int32_t)(model_next(&state) << 8) % most;
            centre[r] = ldexp(camera.centre[r], FRAC - camera.centre_frac);
            way[r] = ldexp(f.values[AFFINE + 9u + r], FRAC - WAY) + ORIGIN[r] - centre[r];
        }
        wg_pose_init(&pose, &f.file, 0, f.weights);
        wg_pose_set(&pose, f.values, 0, &camera);
        wg_pose_vertices(&pose, 0, POINT_COUNT, xyz);
        for (unsigned i = 0; i < 9; i++) {
            const int16_t *p = POINTS + i / 3u * 3u;
            double want = 0;
            for (unsigned k = 0; k < 3; k++) {
                double at = e[3 * k] * p[0] + e[3 * k + 1] * p[1] + e[3 * k + 2] * p[2] + way[k];
                want += 256 * turn[3u * (i % 3u) + k] * at;
            }
            CHECK_NEAR(xyz[i], want, camera_tolerance(p, pose.turn_bits));
        }
        free(f.clip);
    }
}

int main(void)
{
    TEST(normals_turn_with_the_cofactors);
    TEST(normals_are_those_of_the_turned_triangle);
    TEST(a_camera_turns_what_is_posed);
    return check_done();
}

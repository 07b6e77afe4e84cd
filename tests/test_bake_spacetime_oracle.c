/* Spacetime control against finite elements and matrix exponentials in coordinates q, where modes
 * are mixed. Source: Schulz 2013, 2.6, 2.8; vectors from tests/reference/spacetime_oracle.py.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spacetime_problem.h"

typedef struct {
    problem x;
    char name[64];
    motion m;
    int models, keys, rows, open; /* rows: of the last key */
    double changed, size, energy, coarse;
} oracle;

static void numbers(const char *text, double *out, int count)
{
    char *rest;
    for (int i = 0; i < count; i++, text = rest + (*rest == ','))
        out[i] = strtod(text, &rest);
}

static void read_case(const char *line, oracle *o)
{
    double v[12];
    int name = 0;
    if (o->open)
        motion_free(&o->m);
    memset(o, 0, sizeof *o);
    sscanf(line, "case,%63[^,],%n", o->name, &name);
    numbers(line + name, v, 12);
    o->x.way = (way)v[0];
    o->x.d = (int)v[1];
    o->x.count = (int)v[2];
    o->x.settings = (space_settings){.alpha = v[3], .beta = v[4], .stiffness = v[5]};
    for (int side = 0; side < 2; side++)
        o->x.settings.end[side] = (bake_end)v[6 + side];
    o->changed = v[8];
    o->size = v[9];
    o->energy = v[10];
    o->coarse = v[11];
}

static void read_model(const char *line, oracle *o)
{
    int d = o->x.d;
    double v[3 * D_MAX + D_MAX * D_MAX];
    model *m = &o->x.models[o->models];
    numbers(line + 6, v, 3 * d + d * d);
    memcpy(m->lambda, v, (size_t)d * sizeof *v);
    memcpy(m->inner, v + d, (size_t)d * sizeof *v);
    memcpy(m->outer, v + 2 * d, (size_t)d * sizeof *v);
    memcpy(m->Phi, v + 3 * d, (size_t)(d * d) * sizeof *v);
    link_model(&o->x, o->models++);
}

static void read_key(const char *line, oracle *o)
{
    double v[3 + D_MAX];
    int k = o->keys++;
    numbers(line + 4, v, 3 + o->x.d);
    memcpy(o->x.q[k], v + 3, (size_t)o->x.d * sizeof *v);
    o->x.keys[k] = (space_key){.time = v[0],
                               .q = o->x.q[k],
                               .weight = {v[1], 0},
                               .rows = (int)v[2],
                               .S = o->x.S[k],
                               .p = o->x.p[k]};
    o->rows = 0;
}

static void read_row(const char *line, oracle *o)
{
    double v[D_MAX + 1];
    int d = o->x.d, k = o->keys - 1;
    numbers(line + 4, v, d + 1);
    memcpy(o->x.S[k] + o->rows * d, v, (size_t)d * sizeof *v);
    o->x.p[k][o->rows++] = v[d];
}

static void read_end(const char *line, oracle *o)
{
    double v[D_MAX + 1];
    numbers(line + 4, v, o->x.d + 1);
    int side = (int)v[0];
    memcpy(o->x.end_v[side], v + 1, (size_t)o->x.d * sizeof *v);
    o->x.settings.end_v[side] = o->x.end_v[side];
}

/* Halving the elements divides the error of quintics by 2^4 at least: what it changed bounds what
 * is left. 1e-9: the oracle solves systems of 1e3 unknowns in doubles, and the exponentials have no
 * error of discretisation to bound the rest. */
static void check_at(const char *line, oracle *o)
{
    double v[D_MAX + 1], q[D_MAX];
    numbers(line + 3, v, o->x.d + 1);
    motion_eval(&o->m, v[0], q, NULL, NULL);
    for (int i = 0; i < o->x.d; i++) {
        double tolerance = (o->changed + 1e-9) * o->size;
        CHECK_NEAR(q[i], v[i + 1], tolerance);
        if (!(fabs(q[i] - v[i + 1]) <= tolerance))
            printf("case %s at %g\n", o->name, v[0]);
    }
}

/* Energies of minimisers: the finite elements' is from above, its error squares that of the motion.
 */
static void solve_case(oracle *o)
{
    o->m = solved_motion(&o->x);
    o->open = 1;
    double scale = o->energy + 1e-6, tolerance = fabs(o->energy - o->coarse) + 1e-8 * scale;
    if (o->energy >= 0.0)
        CHECK_NEAR(motion_energy(&o->m), o->energy, tolerance);
    if (o->energy >= 0.0 && !(fabs(motion_energy(&o->m) - o->energy) <= tolerance))
        printf("case %s\n", o->name);
}

static void oracle_agrees(void)
{
    static oracle o;
    char line[4096];
    int cases = 0, samples = 0;
    FILE *file = fopen("tests/vectors/spacetime_oracle.csv", "r");
    CHECK(file != NULL);
    while (file && fgets(line, sizeof line, file)) {
        if (line[0] == 'c' && ++cases)
            read_case(line, &o);
        if (line[0] == 'm')
            read_model(line, &o);
        if (line[0] == 'e')
            read_end(line, &o);
        if (line[0] == 'k')
            read_key(line, &o);
        if (line[0] == 'r')
            read_row(line, &o);
        if (line[0] == 'a' && !o.open)
            solve_case(&o);
        if (line[0] == 'a' && o.m.term && ++samples)
            check_at(line, &o);
    }
    CHECK(cases >= 70 && samples >= 980);
    if (o.open)
        motion_free(&o.m);
    if (file)
        fclose(file);
}

/* Central differences over h = 1e-5: h^2/6 of the third derivative more, which is <= 1e6 of q' here
 * (rates to 18/s, fades of 0.15 s), 1e8 of q''. */
static void velocity_and_acceleration_are_derivatives(void)
{
    static problem x;
    for (int kind = 0; kind < 3; kind++) {
        double q[3][D_MAX], v[3][D_MAX], a[D_MAX], h = 1e-5;
        random_problem(&x, (way)kind, 3, 4, BAKE_END_VELOCITY);
        motion m = solved_motion(&x);
        for (double t = m.from + 0.01; t < m.to - 0.01; t += 0.013) {
            motion_eval(&m, t - h, q[0], v[0], NULL);
            motion_eval(&m, t, q[1], v[1], a);
            motion_eval(&m, t + h, q[2], v[2], NULL);
            for (int i = 0; i < x.d; i++) {
                CHECK_NEAR(v[1][i], (q[2][i] - q[0][i]) / (2 * h), 1e6 * h * h / 6);
                CHECK_NEAR(a[i], (v[2][i] - v[0][i]) / (2 * h), 1e8 * h * h / 6);
            }
        }
        motion_free(&m);
    }
}

int main(void)
{
    TEST(oracle_agrees);
    TEST(velocity_and_acceleration_are_derivatives);
    return check_done();
}

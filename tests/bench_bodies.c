/* Seconds for bodies of the sizes of a published table, for 1e5 tetrahedra, and for whole bakes.
 *   bench_bodies [name ...]   all of them, or: block bug cactus cloth dinosaur large bake
 * Source: Schulz 2013, table 2.1. Meshes of these sizes, the poses and the velocities are our own: smooth fields.
 * precompute: from mesh and poses to linear models; update: what is done again when times, velocities, damping or
 * stiffness change. Seconds of processor time, one thread.
 *   S   n x d   poses as differences from rest, and modes at each key's pose (algorithm 2)
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bench_meshes.h"

#include "spacetime.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define SPLINES_MOST 5
#define KEYS_MOST    4

/* A row of the table: seconds are printed[0] before, printed[1] for each update. */
typedef struct {
    const char *name;
    void (*mesh)(body *);
    body_material material;
    int splines, keys; /* keys: of each spline */
    int dimension[SPLINES_MOST];
    int many; /* a model a key (blending), or one at rest */
    int held[SPLINES_MOST];
    double printed[2];
} row;

static const row table[] = {
    {"block", mesh_block, {2e4, 0.3, 1000, 5e-3}, 3, 2, {1350, 1350, 1350}, 0, {0}, {83, 0.54}},
    {"bug", mesh_bug, {1e6, 0.4, 1000, 2e-3}, 1, 2, {30}, 0, {0}, {9, 0.03}},
    {"cactus", mesh_cactus, {1e6, 0.4, 1000, 0}, 1, 2, {15}, 0, {1}, {1.6, 0.01}},
    {"cloth", mesh_cloth, {1e6, 0.3, 300, 5e-4}, 3, 4, {92, 143, 186}, 1, {1, 0, 2}, {74, 0.85}},
    {"dinosaur",
     mesh_dinosaur,
     {1e6, 0.4, 1000, 5e-3},
     5,
     3,
     {18, 18, 18, 18, 18},
     1,
     {1, 2, 1, 2, 1},
     {505, 0.6}},
};

/* One spline: what it is made from, and what is made. */
typedef struct {
    freedom f;
    double *pose[KEYS_MOST], *velocity[KEYS_MOST];
    space sp;
    linear_model model[KEYS_MOST];
} spline;

/* Where the time before goes. */
typedef struct {
    double hessians, modes, spaces, models;
    double residual; /* the largest of the modes */
} stages;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double lap(double *since)
{
    double t = now(), seconds = t - *since;
    *since = t;
    return seconds;
}

static void must(int failed, const bake_error *error)
{
    if (failed) {
        printf("failed: %s\n", error->text);
        exit(1);
    }
}

/* ---- poses -------------------------------------------------------------------------------------- */

/* What holds it: nothing, or a ball around the vertex that is farthest along `direction`. Returns its
 * centre; radius: a twentieth of the body's length. */
static int hold(const body *b, int held, freedom *f, double *radius)
{
    static const double direction[3][3] = {{0}, {0.3, -1, 0.2}, {-0.3, -1, 0.1}};
    int centre = 0;
    double most = -HUGE_VAL, length = body_length(b);
    *radius = 0.05 * length;
    freedom_make(b->vertex_count, f);
    for (int i = 0; i < b->vertex_count; i++) {
        double along = 0;
        for (int k = 0; k < 3; k++)
            along += direction[held][k] * b->rest[3 * i + k];
        if (along > most) {
            most = along;
            centre = i;
        }
    }
    for (int i = 0; held && i < b->vertex_count; i++)
        if (body_distance(b, i, centre) < *radius)
            freedom_fix(f, i);
    freedom_finish(f);
    return centre;
}

/* A smooth field, a few per cent of the body's length, that leaves what is held where it is. */
static double *field(const body *b, const spline *s, int number, int centre, double radius)
{
    double *u = bake_alloc(3 * (size_t)b->vertex_count, sizeof *u), length = body_length(b);
    double wave = 6.0 / length, size = 0.03 * length;
    for (int i = 0; i < b->vertex_count; i++) {
        const double *x = &b->rest[3 * i];
        double beyond = fmax(body_distance(b, i, centre) - radius, 0) / (3 * radius);
        double part = s->f.count < 3 * b->vertex_count ? fmin(beyond * beyond, 1) : 1;
        for (int k = 0; k < 3; k++)
            u[3 * i + k] = part * size * sin(wave * x[(k + 1) % 3] + number + 1.7 * k) *
                           cos(0.5 * wave * x[(k + 2) % 3] + 2.3 * number);
    }
    return u;
}

static void prepare_spline(const row *r, const body *b, int index, spline *s)
{
    double radius;
    int centre = hold(b, r->held[index], &s->f, &radius);
    for (int k = 0; k < r->keys; k++) {
        s->velocity[k] = field(b, s, 31 * index + 7 * k + 100, centre, radius);
        s->pose[k] = field(b, s, 13 * index + 5 * k + 1, centre, radius);
        for (int i = 0; i < 3 * b->vertex_count; i++)
            s->pose[k][i] += b->rest[i];
    }
}

static void free_spline(spline *s)
{
    for (int k = 0; k < KEYS_MOST; k++) {
        free(s->pose[k]);
        free(s->velocity[k]);
        if (s->model[k].d)
            linear_model_free(&s->model[k]);
    }
    space_free(&s->sp);
    freedom_free(&s->f);
}

/* ---- precompute --------------------------------------------------------------------------------- */

/* Modes of the potential that is at rest at x, expanded to n rows each. */
static void add_modes(const body *b, const freedom *f, const double *x, int count, double *out,
                      stages *t)
{
    size_t n = 3 * (size_t)b->vertex_count;
    double since = now(), *M = bake_alloc((size_t)f->count, sizeof *M);
    body other = *b;
    body_blocks blocks = {0};
    bake_error error;
    sparse K;
    modes m;
    other.rest = memcpy(bake_alloc(n, sizeof *x), x, n * sizeof *x);
    other.element = bake_alloc((size_t)b->element_count, sizeof *b->element);
    memcpy(other.element, b->element, (size_t)b->element_count * sizeof *b->element);
    other.mass = NULL;
    other.elements = NULL;
    must(body_prepare(&other, &error), &error);
    body_hessian(&other, x, &blocks);
    must(sparse_from_blocks(&blocks, f, &K, &error), &error);
    for (int i = 0; i < b->vertex_count; i++)
        for (int j = f->first[i]; j < f->first[i + 1]; j++)
            M[j] = b->mass[i];
    t->hessians += lap(&since);
    must(modes_solve(&K, M, count, &m, &error), &error);
    for (int j = 0; j < count; j++) {
        freedom_expand(f, m.phi + (size_t)j * (size_t)m.n, out + n * (size_t)j);
        t->residual = fmax(t->residual, m.residual[j]);
    }
    t->modes += lap(&since);
    modes_free(&m);
    body_blocks_free(&blocks);
    body_free(&other);
    sparse_free(&K);
    free(M);
}

static void start_space(const body *b, space *sp)
{
    sp->n = 3 * b->vertex_count;
    sp->origin = bake_alloc((size_t)sp->n, sizeof *sp->origin);
    sp->mass = bake_alloc((size_t)sp->n, sizeof *sp->mass);
    memcpy(sp->origin, b->rest, (size_t)sp->n * sizeof *sp->origin);
    for (int i = 0; i < sp->n; i++)
        sp->mass[i] = b->mass[i / 3];
}

/* All coordinates: V = M^-1/2. */
static void full_space(space *sp)
{
    sp->d = sp->n;
    sp->V = bake_alloc((size_t)sp->n * (size_t)sp->n, sizeof *sp->V);
    for (int i = 0; i < sp->n; i++)
        sp->V[(size_t)i * (size_t)(sp->n + 1)] = 1 / sqrt(sp->mass[i]);
}

static void make_space(const row *r, const body *b, int dimension, spline *s, stages *t)
{
    size_t n = 3 * (size_t)b->vertex_count;
    bake_error error;
    start_space(b, &s->sp);
    if (dimension == s->sp.n) {
        full_space(&s->sp);
        return;
    }
    int points = r->many ? r->keys : 1;
    /* a free body's three translations are modes at each pose, and the same ones */
    int count = dimension + (s->f.count == s->sp.n ? 3 * (points - 1) : 0), left = count - r->keys;
    double *S = bake_alloc(n * (size_t)count, sizeof *S), *next = S;
    for (int k = 0; k < r->keys; k++)
        for (size_t i = 0; i < n; i++)
            *next++ = s->pose[k][i] - b->rest[i];
    for (int k = 0; k < points; k++) {
        int part = left / (points - k);
        add_modes(b, &s->f, r->many ? s->pose[k] : b->rest, part, next, t);
        next += n * (size_t)part;
        left -= part;
    }
    double since = now();
    must(space_make(&s->sp, S, count, &error), &error);
    t->spaces += lap(&since);
    if (s->sp.d != dimension)
        printf("  %d dimensions instead of %d\n", s->sp.d, dimension);
    free(S);
}

static void make_model(const body *b, const space *sp, const double *x, linear_model *out,
                       stages *t)
{
    size_t n = (size_t)sp->n, d = (size_t)sp->d;
    double since = now(), *K = bake_alloc(d * d, sizeof *K), *dV = bake_alloc(n, sizeof *dV);
    double *part = bake_alloc(3 * d, sizeof *part);
    body_blocks blocks = {0};
    bake_error error;
    body_hessian(b, x, &blocks);
    body_gradient(b, x, dV);
    t->hessians += lap(&since);
    space_reduce_blocks(sp, &blocks, K);
    space_project(sp, x, part);
    for (size_t j = 0; j < d; j++)
        for (size_t i = 0; i < n; i++)
            part[d + j] += sp->V[j * n + i] * dV[i];
    const linear_terms at = {(int)d, K, part, part + d, part + 2 * d, 0};
    must(linear_model_make(&at, out, &error), &error);
    t->models += lap(&since);
    body_blocks_free(&blocks);
    free(K);
    free(dV);
    free(part);
}

/* ---- update ------------------------------------------------------------------------------------- */

/* Poses and velocities into the space, all splines; settings that differ from call to call. Returns the
 * seconds that projecting took. */
static double update(const row *r, spline *s, int call)
{
    double since = now(), *q = bake_alloc((size_t)(2 * r->keys * s->sp.d), sizeof *q), projected;
    space_settings settings = {.alpha = 0.1 + 0.01 * call,
                               .stiffness = 1 + 0.01 * call,
                               .end = {BAKE_END_VELOCITY, BAKE_END_VELOCITY}};
    const linear_model *models[KEYS_MOST];
    space_key keys[KEYS_MOST];
    bake_error error;
    motion m;
    size_t n = (size_t)s->sp.n;
    double *u = bake_alloc(2 * n * (size_t)r->keys, sizeof *u);
    for (size_t k = 0; k < (size_t)r->keys; k++) {
        for (size_t i = 0; i < n; i++) {
            u[2 * n * k + i] = s->pose[k][i] - s->sp.origin[i];
            u[2 * n * k + n + i] = s->velocity[k][i];
        }
    }
    space_project_vectors(&s->sp, u, 2 * r->keys, q);
    free(u);
    for (int k = 0; k < r->keys; k++) {
        double *pose = q + 2 * k * s->sp.d, *velocity = pose + s->sp.d;
        int end = k == r->keys - 1, inner = k && !end;
        keys[k] = (space_key){.time = 0.5 * k + 0.001 * (call % 7), .q = pose};
        keys[k].weight[0] = BAKE_HARD;
        models[k] = &s->model[k];
        if (!inner)
            settings.end_v[end] = velocity;
    }
    projected = lap(&since);
    const motion_input in = {&settings, keys, r->keys};
    must(r->many ? motion_blend(models, &in, &m, &error)
                 : motion_one_point(models[0], &in, &m, &error),
         &error);
    motion_free(&m);
    free(q);
    return projected;
}

/* ---- rows --------------------------------------------------------------------------------------- */

static void run_row(const row *r)
{
    static spline splines[SPLINES_MOST];
    body b = {0};
    stages t = {0};
    bake_error error;
    r->mesh(&b);
    b.material = r->material;
    must(body_prepare(&b, &error), &error);
    for (int i = 0; i < r->splines; i++)
        prepare_spline(r, &b, i, &splines[i]);
    double since = now(), before, after, projecting = 0;
    for (int i = 0; i < r->splines; i++) {
        make_space(r, &b, r->dimension[i], &splines[i], &t);
        for (int k = 0; k < (r->many ? r->keys : 1); k++)
            make_model(&b, &splines[i].sp, r->many ? splines[i].pose[k] : b.rest,
                       &splines[i].model[k], &t);
    }
    before = lap(&since);
    int calls = 0;
    do {
        for (int i = 0; i < r->splines; i++)
            projecting += update(r, &splines[i], calls);
        after = now() - since;
    } while (++calls < 1000 && after < 1);
    after /= calls;
    printf("%-9s %6d %6d %9.3g %9.3g %6.0f %11.3g %9.3g %6.0f\n", r->name, b.vertex_count,
           b.element_count, before, r->printed[0], r->printed[0] / before, after, r->printed[1],
           r->printed[1] / after);
    printf(
        "          hessians %.3g s, modes %.3g s, spaces %.3g s, models %.3g s; projecting %.3g s, "
        "splines %.3g s; residual %.1e\n",
        t.hessians, t.modes, t.spaces, t.models, projecting / calls, after - projecting / calls,
        t.residual);
    for (int i = 0; i < r->splines; i++)
        free_spline(&splines[i]);
    body_free(&b);
}

/* 30 modes of a free block of 1e5 tetrahedra. */
static void run_large(const row *unused)
{
    body b = {.material = {1e6, 0.4, 1000, 0}};
    double since = now(), *phi;
    stages t = {0};
    bake_error error;
    freedom f;
    (void)unused;
    box_tets(&b, (const double[]){1, 1, 1}, (const int[]){26, 26, 26});
    must(body_prepare(&b, &error), &error);
    freedom_make(b.vertex_count, &f);
    freedom_finish(&f);
    phi = bake_alloc(30 * 3 * (size_t)b.vertex_count, sizeof *phi);
    add_modes(&b, &f, b.rest, 30, phi, &t);
    printf("30 modes of %d tetrahedra, %d vertices: %.3g s (Hessian %.3g s), residual %.1e\n",
           b.element_count, b.vertex_count, lap(&since), t.hessians, t.residual);
    free(phi);
    freedom_free(&f);
    body_free(&b);
}

/* In a process of its own: so that memory is measured for each. */
static void run_alone(void (*run)(const row *), const row *r)
{
    struct rusage use;
    int status;
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        run(r);
        fflush(stdout);
        _exit(0);
    }
    if (child < 0 || wait4(child, &status, 0, &use) < 0 || status != 0)
        printf("          not finished\n");
    else
        printf("          at most %ld MB\n", use.ru_maxrss / 1024);
}

/* ---- whole bakes -------------------------------------------------------------------------------- */

static void run_bake(const char *name)
{
    char command[500], scene[100], cache[] = "build/bench/cache.XXXXXX";
    struct timespec t[2];
    snprintf(scene, sizeof scene, "examples/%s/%s.yaml", name, name);
    if (access(scene, R_OK) != 0 || access("build/wiggly", X_OK) != 0 || !mkdtemp(cache)) {
        printf("%s: not there\n", scene);
        return;
    }
    snprintf(command, sizeof command,
             "XDG_CACHE_HOME=%s build/wiggly bake %s -o build/bench/%s.wgl --quiet", cache, scene,
             name);
    printf("wiggly bake %s:", scene);
    for (int pass = 0; pass < 2; pass++) {
        fflush(stdout);
        clock_gettime(CLOCK_MONOTONIC, &t[0]);
        int failed = system(command);
        clock_gettime(CLOCK_MONOTONIC, &t[1]);
        double seconds =
            (double)(t[1].tv_sec - t[0].tv_sec) + 1e-9 * (double)(t[1].tv_nsec - t[0].tv_nsec);
        printf(" %.2f s %s%s", seconds, failed ? "FAILED " : "", pass ? "again\n" : "at first,");
    }
    snprintf(command, sizeof command, "rm -rf %s", cache);
    if (system(command) != 0)
        printf("%s is left\n", cache);
}

static int wanted(int argc, char **argv, const char *name)
{
    int found = argc < 2;
    for (int i = 1; i < argc; i++)
        found |= strcmp(argv[i], name) == 0;
    return found;
}

int main(int argc, char **argv)
{
    static const char *const scenes[] = {"block", "bug", "cactus", "cloth", "walk"};
    int failed = system("mkdir -p build/bench build/cgal && grep -m 1 'model name' /proc/cpuinfo");
    printf("%-9s %6s %6s %9s %9s %6s %11s %9s %6s\n", "", "verts", "elem.", "before s", "printed",
           "times", "update s", "printed", "times");
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (wanted(argc, argv, table[i].name))
            run_alone(run_row, &table[i]);
    if (wanted(argc, argv, "large"))
        run_alone(run_large, NULL);
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++)
        if (wanted(argc, argv, "bake"))
            run_bake(scenes[i]);
    return failed != 0;
}

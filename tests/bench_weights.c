/* Bounded biharmonic weights on domains of the sizes of Jacobson 2013, table 4.2, whose printed seconds
 * a handle stand beside ours; and with `--ipopt` the same quadratic programs by IPOPT.
 *   build/bench_weights [--ipopt] [ROW...]
 * Columns: elements, vertices, handles; seconds of all handles alone, and with their sum as a
 * constraint; seconds a handle and the printed ones; the largest KKT residual; memory of the solver at
 * its largest. IPOPT's weights are compared with ours, vertex by vertex.
 * SPDX-License-Identifier: MIT */
#include "bench_meshes.h"
#include "ipopt_oracle.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

typedef struct {
    const char *name, *file; /* NULL: a flat star */
    int elements, handles;
    double printed; /* seconds a handle; 0: none */
} row;

static const row table[] = {{"gingerman", NULL, 5040, 6, 0.1397},
                            {"frowny", NULL, 5442, 6, 0.0906},
                            {"alligator", NULL, 7019, 8, 0.1779},
                            {"pisa", NULL, 12422, 8, 0.3174},
                            {"mona", NULL, 32258, 8, 1.2417},
                            {"gargoyle", "elephant", 46003, 7, 1.1939},
                            {"hand", "hand", 51263, 20, 3.1268},
                            {"mouse", "triceratops", 112355, 12, 8.4464},
                            {"armadillo", "armadillo", 142073, 17, 12.0870},
                            {"large", "armadillo", 330000, 16, 0}};

/* Elements up to which handles are solved together, and by IPOPT, too: minutes otherwise. */
#define TOGETHER_MOST 60000

static int with_ipopt;
static const surface_origin origin = {"bench", "mesh", 1};

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void must(int result, const bake_error *error)
{
    if (result < 0) {
        printf("          %s\n", error->text);
        fflush(stdout);
        _exit(1);
    }
}

/* ---- domains ------------------------------------------------------------------------------------ */

/* A star with five round arms. */
static void make_star(outline *o)
{
    enum { POINTS = 400 };
    static int loop[2] = {0, POINTS};
    static double at[2 * POINTS];
    for (int i = 0; i < POINTS; i++) {
        double turn = 2 * acos(-1) * i / POINTS, r = 1 + 0.45 * cos(5 * turn);
        at[2 * i] = r * cos(turn);
        at[2 * i + 1] = r * sin(turn);
    }
    *o = (outline){1, POINTS, loop, at};
}

/* The vertices farthest from one another, as point handles. */
static void choose_handles(const double *at, int count, int wanted, handle *out)
{
    double *far = bake_alloc((size_t)count, sizeof *far);
    for (int i = 0; i < count; i++) {
        far[i] = HUGE_VAL;
    }
    for (int j = 0, best = 0; j < wanted; j++) {
        out[j] = (handle){.name = "point", .kind = HANDLE_POINT};
        memcpy(out[j].from, at + 3 * best, sizeof out[j].from);
        memcpy(out[j].to, at + 3 * best, sizeof out[j].to);
        int next = 0;
        for (int i = 0; i < count; i++) {
            const double *a = at + 3 * i, *b = out[j].from;
            far[i] = fmin(far[i], hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]));
            next = far[i] > far[next] ? i : next;
        }
        best = next;
    }
    free(far);
}

/* With cells such that there are about as many elements as the row wants. */
static void make_domain(const row *r, handles *h, domain *d)
{
    bake_error error;
    outline star = {0};
    body shell = {0};
    surface s = {0};
    double cell = r->file ? 0.03 : 0.05;
    domain_options how = {.origin = &origin, .wrap = 1};
    handles none = {0};
    if (r->file) {
        read_off(r->file, 1, &shell);
        int(*triangle)[3] = bake_alloc((size_t)shell.element_count, sizeof *triangle);
        for (int i = 0; i < shell.element_count; i++) {
            memcpy(triangle[i], shell.element[i], sizeof *triangle);
        }
        s = (surface){shell.vertex_count, shell.element_count, shell.rest,
                      (const int(*)[3])triangle};
    } else {
        make_star(&star);
    }
    for (int round = 0; round < 6; round++) {
        how.cell = cell;
        domain_free(d);
        must(r->file ? domain_solid(&s, &none, &how, d, &error)
                     : domain_flat(&star, &none, &how, d, &error),
             &error);
        double ratio = (double)d->element_count / r->elements;
        if (fabs(ratio - 1) < 0.05) {
            break;
        }
        cell *= pow(ratio, r->file ? 0.4 : 0.5);
    }
    handle *list = bake_alloc((size_t)r->handles, sizeof *list);
    choose_handles(d->at, d->vertex_count, r->handles, list);
    *h = (handles){.count = r->handles, .handle = list};
}

/* Seconds of all handles; the largest difference of a weight. */
static double compare(const sparse *q, const held *h, const double *w, double *off)
{
    double since = now(), *x = bake_alloc((size_t)q->n, sizeof *x), seconds = 0;
    *off = 0;
    for (int j = 0; j < h->handle_count; j++) {
        since = now();
        int status = ipopt_weights(q, h, j, x);
        seconds += now() - since;
        if (status != 0 && status != 1) { /* solved, or to an acceptable level */
            printf("          IPOPT: status %d on handle %d\n", status, j);
        }
        for (int i = 0; i < q->n; i++) {
            *off = fmax(*off, fabs(x[i] - w[(size_t)j * (size_t)q->n + (size_t)i]));
        }
    }
    free(x);
    return seconds;
}

/* ---- rows --------------------------------------------------------------------------------------- */

static long memory(void)
{
    struct rusage use;
    getrusage(RUSAGE_SELF, &use);
    return use.ru_maxrss / 1024;
}

static void run(const row *r)
{
    bake_error error;
    domain d = {0};
    handles h;
    held fixed;
    sparse k, q;
    make_domain(r, &h, &d);
    const domain_options how = {.cell = d.cell, .origin = &origin};
    must(domain_hold(&d, &h, &how, &fixed, &error), &error);
    double *length = bake_alloc(6 * (size_t)d.element_count, sizeof *length);
    double *mass = bake_alloc((size_t)d.vertex_count, sizeof *mass);
    laplacian_lengths(&d, length);
    must(laplacian_make(&d, length, MASS_VORONOI, &k, mass, &error), &error);
    must(laplacian_energy(&k, mass, 2, &q, &error), &error);
    double *w = bake_alloc((size_t)q.n * (size_t)r->handles, sizeof *w), alone, together, worst = 0;
    bounded_report *report = bake_alloc((size_t)r->handles, sizeof *report);
    double since = now();
    must(bounded_solve(&q, &fixed, BOUNDED_SEPARATE, NULL, w, report, &error), &error);
    alone = now() - since;
    long peak = memory();
    for (int j = 0; j < r->handles; j++) {
        worst = fmax(worst, fmax(report[j].stationarity, fmax(report[j].dual, report[j].bounds)));
    }
    double *both = bake_alloc((size_t)q.n * (size_t)r->handles, sizeof *both);
    int failed = 0;
    since = now();
    if (d.element_count < TOGETHER_MOST) {
        failed = bounded_solve(&q, &fixed, BOUNDED_COUPLED, NULL, both, report, &error);
    }
    together = now() - since;
    printf("%-10s %7d %6d %3d %8.2f %8.2f%s %9.4f %9.4f %6.1f %9.1e %5ld\n", r->name,
           d.element_count, q.n, r->handles, alone, together, failed ? "*" : " ",
           alone / r->handles, r->printed, r->printed * r->handles / alone, worst, peak);
    if (failed) {
        printf("          * %s\n", error.text);
    }
    if (with_ipopt && d.element_count < TOGETHER_MOST) {
        double off, seconds = compare(&q, &fixed, w, &off);
        printf("          IPOPT %.2f s, %.1f times as long; weights differ by %.1e at most\n",
               seconds, seconds / alone, off);
    }
    fflush(stdout);
}

/* In a process of its own, so that memory is each row's. */
static void run_alone(const row *r)
{
    int status;
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        run(r);
        _exit(0);
    }
    if (child < 0 || waitpid(child, &status, 0) < 0 || status != 0) {
        printf("%-10s not finished: %d\n", r->name, status);
    }
}

int main(int argc, char **argv)
{
    int named = 0;
    for (int i = 1; i < argc; i++) {
        with_ipopt |= strcmp(argv[i], "--ipopt") == 0;
        named |= strcmp(argv[i], "--ipopt") != 0;
    }
    if (system("mkdir -p build/cgal") != 0) {
        return 1;
    }
    printf("%-10s %7s %6s %3s %8s %8s  %9s %9s %6s %9s %5s\n", "size of", "elem.", "verts", "h",
           "alone s", "coupled", "s/handle", "printed", "times", "KKT", "MB");
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        int wanted = !named;
        for (int k = 1; k < argc; k++) {
            wanted |= strcmp(argv[k], table[i].name) == 0;
        }
        if (wanted) {
            run_alone(&table[i]);
        }
    }
    return 0;
}

/* Endpoint weights: what every kind of them must be, closed forms, and where they differ.
 * Source: Jacobson 2013, 6.2.2, 6.2.3 (6.7)-(6.9), Figure 6.13; erratum of (6.9).
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "domain_shapes.h"
#include "ends.h"

static const surface_origin origin = {"arm.yaml", "arm", 1};
static const domain_options how = {.origin = &origin};

static const char *const kind_name[] = {"none", "bounded", "projection", "distance", "joints"};

typedef struct {
    domain d;
    handles h;
    double *w, *e; /* vertex_count x handle count */
} rigged;

static int weigh(const domain *d, const handles *h, double *w, bake_error *error)
{
    double *length = bake_alloc(6 * (size_t)d->element_count, sizeof *length);
    double *mass = bake_alloc((size_t)d->vertex_count, sizeof *mass);
    sparse k = {0}, q = {0};
    held fixed = {0};
    laplacian_lengths(d, length);
    int err = laplacian_make(d, length, MASS_VORONOI, &k, mass, error) < 0 ||
              laplacian_energy(&k, mass, 2, &q, error) < 0 ||
              domain_hold(d, h, &how, &fixed, error) < 0 ||
              bounded_solve(&q, &fixed, BOUNDED_SEPARATE, NULL, w, NULL, error) < 0 ||
              bounded_normalise(w, d->vertex_count, h->count, error) < 0;
    held_free(&fixed);
    sparse_free(&q);
    sparse_free(&k);
    free(mass);
    free(length);
    return err ? -1 : 0;
}

static void rig(rigged *r, ends_kind kind)
{
    bake_error error = {""};
    size_t size = (size_t)r->d.vertex_count * (size_t)r->h.count;
    if (!r->w) {
        r->w = bake_alloc(size, sizeof *r->w);
        CHECK(weigh(&r->d, &r->h, r->w, &error) == 0);
        r->e = bake_alloc(size, sizeof *r->e);
    }
    CHECK(ends_make(&r->d, &r->h, kind, r->w, &how, r->e, &error) == 0);
    if (error.text[0])
        puts(error.text);
}

static void release(rigged *r)
{
    shape_free(&r->d);
    free(r->w);
    free(r->e);
}

/* A sheet of 3 x 1 with an arm of two bones in its middle; one of 3 x 1 x 1 of tetrahedra. */
static const handle arm[2] = {
    {.name = "upper", .kind = HANDLE_BONE, .from = {0.5, 0.5, 0}, .to = {1.5, 0.5, 0}},
    {.name = "lower", .kind = HANDLE_BONE, .from = {1.5, 0.5, 0}, .to = {2.5, 0.5, 0}}};
static const handle solid_arm[2] = {
    {.name = "upper", .kind = HANDLE_BONE, .from = {0.5, 0.5, 0.5}, .to = {1.5, 0.5, 0.5}},
    {.name = "lower", .kind = HANDLE_BONE, .from = {1.5, 0.5, 0.5}, .to = {2.5, 0.5, 0.5}}};

static rigged flat_arm(void)
{
    return (rigged){.d = shape_sheet(3, 1, 30, 10), .h = {.count = 2, .handle = arm}};
}

static rigged thick_arm(void)
{
    return (rigged){.d = shape_box((const double[]){3, 1, 1}, (const int[]){24, 8, 8}),
                    .h = {.count = 2, .handle = solid_arm}};
}

static double at_point(const rigged *r, int bone, double x, double y, double z)
{
    return r->e[bone * r->d.vertex_count + shape_vertex(&r->d, x, y, z)];
}

/* ---- what all kinds must be ------------------------------------------------------------------ */

/* Bounds, and e = 0 and 1 at the ends of the bone [6.2.2]: exactly, but for joints, whose
 * weights are divided by their sums. */
static void all_kinds_are_bounded_and_interpolate(void)
{
    for (int solid = 0; solid < 2; solid++) {
        rigged r = solid ? thick_arm() : flat_arm();
        for (ends_kind kind = ENDS_BOUNDED; kind <= ENDS_JOINTS; kind++) {
            rig(&r, kind);
            for (int i = 0; i < 2 * r.d.vertex_count; i++)
                CHECK(r.e[i] >= 0 && r.e[i] <= 1);
            for (int k = 0; k < 2; k++) {
                const handle *b = &r.h.handle[k];
                CHECK_NEAR(at_point(&r, k, b->from[0], b->from[1], b->from[2]), 0, 1e-12);
                CHECK_NEAR(at_point(&r, k, b->to[0], b->to[1], b->to[2]), 1, 1e-12);
            }
        }
        release(&r);
    }
}

/* Along an edge, e changes by less than its length over a tenth of the bone: it is continuous,
 * where a wrong vertex would be a jump. */
static void gradients_are_finite(void)
{
    for (int solid = 0; solid < 2; solid++) {
        rigged r = solid ? thick_arm() : flat_arm();
        for (ends_kind kind = ENDS_BOUNDED; kind <= ENDS_JOINTS; kind++) {
            double steepest = 0;
            rig(&r, kind);
            for (int i = 0; i < r.d.element_count; i++)
                for (int a = 1; a <= r.d.dimension; a++) {
                    int u = r.d.element[i][0], v = r.d.element[i][a];
                    const double *p = r.d.at + 3 * u, *q = r.d.at + 3 * v;
                    double edge =
                        sqrt((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) +
                             (p[2] - q[2]) * (p[2] - q[2]));
                    for (int k = 0; k < 2; k++) {
                        const double *e = r.e + k * r.d.vertex_count;
                        steepest = fmax(steepest, fabs(e[u] - e[v]) / edge);
                    }
                }
            printf("%s, %s: steepest %.2f a bone's length\n", solid ? "solid" : "flat",
                   kind_name[kind], steepest);
            CHECK(steepest <= 10);
        }
        release(&r);
    }
}

/* On a flat shape bounded weights and projections are linear along the bone [6.2.2]. */
static void flat_ends_are_linear_on_the_bone(void)
{
    rigged r = flat_arm();
    for (ends_kind kind = ENDS_BOUNDED; kind <= ENDS_PROJECTION; kind++) {
        rig(&r, kind);
        for (int i = 0; i <= 10; i++) {
            CHECK_NEAR(at_point(&r, 0, 0.5 + 0.1 * i, 0.5, 0), 0.1 * i, 1e-12);
            CHECK_NEAR(at_point(&r, 1, 1.5 + 0.1 * i, 0.5, 0), 0.1 * i, 1e-12);
        }
    }
    release(&r);
}

/* Inside a solid they are held at the ends alone, and come near to linear [6.2.2]. */
static void solid_ends_are_nearly_linear_on_the_bone(void)
{
    rigged r = thick_arm();
    double worst = 0;
    rig(&r, ENDS_BOUNDED);
    for (int i = 0; i <= 8; i++)
        worst = fmax(worst, fabs(at_point(&r, 0, 0.5 + i / 8.0, 0.5, 0.5) - i / 8.0));
    printf("solid: up to %.3f from linear on the bone\n", worst);
    CHECK(worst <= 0.2);
    release(&r);
}

/* ---- closed forms ---------------------------------------------------------------------------- */

/* Along a thin bar the program has one dimension: least INT e''^2 with e >= 0 reached at the
 * start and e <= 1 at the end, so e' = 0 there, and e = 3 t^2 - 2 t^3 between, 0 and 1 beyond. A
 * bar is thin when its width, of which the bone holds only the middle, is small beside the bone:
 * the difference shrinks with the width. */
static double off_smoothstep(double width)
{
    handle bone = {.name = "bone", .kind = HANDLE_BONE};
    double worst = 0, middle = width / 2;
    bone.from[0] = 1;
    bone.to[0] = 3;
    bone.from[1] = bone.from[2] = bone.to[1] = bone.to[2] = middle;
    rigged r = {.d = shape_box((const double[]){4, width, width}, (const int[]){80, 2, 2}),
                .h = {.count = 1, .handle = &bone}};
    rig(&r, ENDS_BOUNDED);
    for (int v = 0; v < r.d.vertex_count; v++) {
        double t = fmin(fmax((r.d.at[3 * v] - 1) / 2, 0), 1);
        worst = fmax(worst, fabs(r.e[v] - t * t * (3 - 2 * t)));
    }
    release(&r);
    return worst;
}

static void on_a_thin_bar_ends_are_a_smooth_step(void)
{
    double wide = off_smoothstep(0.2), narrow = off_smoothstep(0.1);
    printf("bars of width L/10 and L/20: %.4f and %.4f from 3 t^2 - 2 t^3\n", wide, narrow);
    CHECK(narrow < wide);
    CHECK(narrow < 0.01);
}

static double distance2(const double *a, double x, double y)
{
    return (a[0] - x) * (a[0] - x) + (a[1] - y) * (a[1] - y);
}

/* (6.8), and (6.7) with (6.9) whose weights are divided by their sum, as printed elsewhere in the
 * chapter: they "regress to 0.5". */
static void projection_and_distance_follow_their_formulas(void)
{
    rigged r = flat_arm();
    rig(&r, ENDS_PROJECTION);
    for (int v = 0; v < r.d.vertex_count; v++) {
        double x = r.d.at[3 * v];
        CHECK_NEAR(r.e[v], x < 0.5 ? 0 : x > 1.5 ? 1 : x - 0.5, 1e-14);
    }
    rig(&r, ENDS_DISTANCE);
    for (int v = 0; v < r.d.vertex_count; v++) {
        double j[3], sum = 0;
        for (int k = 0; k < 3; k++)
            sum += j[k] = 1 / distance2(r.d.at + 3 * v, 0.5 + k, 0.5);
        if (sum < 1e20)
            CHECK_NEAR(r.e[v], 0.5 * (1 - j[0] / sum + j[1] / sum), 1e-13);
    }
    release(&r);
}

/* (6.7) where both joints' weights are 0, as around another bone's end: e = 1/2 [erratum J7]. */
static void ends_from_joints_are_a_half_far_from_both(void)
{
    rigged r = flat_arm();
    rig(&r, ENDS_JOINTS);
    CHECK_NEAR(at_point(&r, 0, 2.5, 0.5, 0), 0.5, 1e-12); /* where "lower" ends */
    CHECK_NEAR(at_point(&r, 1, 0.5, 0.5, 0), 0.5, 1e-12);
    release(&r);
}

/* ---- past the ends --------------------------------------------------------------------------- */

/* A box with one short bone: the full turn is reached past its ends with bounded weights, and falls
 * off with those of distances [6.3, Figure 6.13]. Bounded weights are exact to 1e-4. */
static void bounded_ends_reach_the_full_turn(void)
{
    static const handle bone = {
        .name = "bone", .kind = HANDLE_BONE, .from = {1.5, 0.5, 0.5}, .to = {2.5, 0.5, 0.5}};
    rigged r = {.d = shape_box((const double[]){4, 1, 1}, (const int[]){32, 8, 8}),
                .h = {.count = 1, .handle = &bone}};
    rig(&r, ENDS_BOUNDED);
    int full = 0, none = 0, past = 0, before = 0;
    for (int v = 0; v < r.d.vertex_count; v++) {
        past += r.d.at[3 * v] > 3.2;
        before += r.d.at[3 * v] < 0.8;
        full += r.d.at[3 * v] > 3.2 && r.e[v] >= 1 - 1e-4;
        none += r.d.at[3 * v] < 0.8 && r.e[v] <= 1e-4;
    }
    printf("past the ends: %d of %d at 1, %d of %d at 0\n", full, past, none, before);
    CHECK_EQ(full, past);
    CHECK_EQ(none, before);
    rig(&r, ENDS_DISTANCE);
    for (int v = 0; v < r.d.vertex_count; v++)
        if (r.d.at[3 * v] > 3.2)
            CHECK(r.e[v] < 0.95);
    release(&r);
}

/* ---- the part that the bone moves ------------------------------------------------------------ */

/* A limb of five bones: where a bone's weights are 0 its program is not solved, and e goes on as
 * its neighbours have it. What a pose sees is w e, and that stays: w fades out before the cut,
 * at which e has the free border's conditions. */
static void ends_go_on_where_the_bone_moves_nothing(void)
{
    handle bone[5];
    for (int k = 0; k < 5; k++)
        bone[k] = (handle){.name = "bone",
                           .kind = HANDLE_BONE,
                           .from = {0.5 + k, 0.5, 0},
                           .to = {1.5 + k, 0.5, 0}};
    rigged r = {.d = shape_sheet(6, 1, 60, 10), .h = {.count = 5, .handle = bone}};
    rig(&r, ENDS_BOUNDED);
    int n = 5 * r.d.vertex_count, unmoved = 0;
    double *part = bake_alloc((size_t)n, sizeof *part), worst = 0, *w = r.w;
    memcpy(part, r.e, (size_t)n * sizeof *part);
    r.w = bake_alloc((size_t)n, sizeof *r.w);
    for (int i = 0; i < n; i++)
        r.w[i] = 1;
    rig(&r, ENDS_BOUNDED);
    for (int i = 0; i < n; i++) {
        CHECK(part[i] >= 0 && part[i] <= 1);
        unmoved += w[i] <= 1e-7;
        worst = fmax(worst, w[i] * fabs(part[i] - r.e[i]));
    }
    printf("%d of %d left out: w e changes by up to %.1e\n", unmoved, n, worst);
    CHECK(unmoved > n / 4);
    CHECK(worst < 1.0 / 256);
    free(part);
    free(w);
    release(&r);
}

/* On a part of the shape that does not hang together with the bone, any constant has no energy:
 * e is its projection there. */
static void loose_parts_have_projections(void)
{
    static const handle bone = {
        .name = "bone", .kind = HANDLE_BONE, .from = {0.5, 0.5, 0}, .to = {1.5, 0.5, 0}};
    rigged r = {.d = shape_sheet(2, 3, 20, 30), .h = {.count = 1, .handle = &bone}};
    int kept = 0, n = r.d.vertex_count;
    for (int i = 0; i < r.d.element_count; i++) { /* without the row of cells from y = 1.4 to 1.5 */
        double low = 3;
        for (int a = 0; a < 3; a++)
            low = fmin(low, r.d.at[3 * r.d.element[i][a] + 1]);
        if (low < 1.35 || low > 1.45)
            memmove(r.d.element[kept++], r.d.element[i], sizeof r.d.element[i]);
    }
    r.d.element_count = kept;
    r.w = bake_alloc((size_t)n, sizeof *r.w);
    r.e = bake_alloc((size_t)n, sizeof *r.e);
    for (int v = 0; v < n; v++)
        r.w[v] = 1;
    rig(&r, ENDS_BOUNDED);
    for (int v = 0; v < n; v++)
        if (r.d.at[3 * v + 1] > 1.45)
            CHECK_NEAR(r.e[v], fmin(fmax(r.d.at[3 * v] - 0.5, 0), 1), 1e-12);
    CHECK_NEAR(at_point(&r, 0, 1, 0, 0), 0.5, 1e-6); /* by symmetry */
    release(&r);
}

/* A bone that begins outside: what is inside keeps its place along the whole of it. Handles that
 * are no bones have no ends. */
static void bones_may_begin_outside(void)
{
    static const handle h[2] = {
        {.name = "tail", .kind = HANDLE_BONE, .from = {-0.5, 0.5, 0.5}, .to = {1, 0.5, 0.5}},
        {.name = "point", .kind = HANDLE_POINT, .from = {1.75, 0.5, 0.5}}};
    rigged r = {.d = shape_box((const double[]){2, 1, 1}, (const int[]){16, 8, 8}),
                .h = {.count = 2, .handle = h}};
    for (ends_kind kind = ENDS_BOUNDED; kind <= ENDS_DISTANCE; kind++) {
        rig(&r, kind);
        if (kind != ENDS_DISTANCE)
            CHECK_NEAR(at_point(&r, 0, 0, 0.5, 0.5), 1 / 3.0, 1e-12);
        CHECK_NEAR(at_point(&r, 0, 1, 0.5, 0.5), 1, 1e-12);
        for (int v = 0; v < r.d.vertex_count; v++)
            CHECK(r.e[r.d.vertex_count + v] == 0);
    }
    release(&r);
}

/* ---- what is refused ------------------------------------------------------------------------- */

static void bones_without_length_or_samples_are_named(void)
{
    static const handle point = {
        .name = "stub", .line = 7, .kind = HANDLE_BONE, .from = {1, 0.5, 0}, .to = {1, 0.5, 0}};
    static const handle small = {
        .name = "dot", .line = 8, .kind = HANDLE_BONE, .from = {1, 0.5, 0}, .to = {1.01, 0.5, 0}};
    const handle *wrong[2] = {&point, &small};
    const char *expect[2] = {"arm.yaml:7: bone 'stub' ends where it starts",
                             "arm.yaml:8: bone 'dot' holds one vertex"};
    for (int i = 0; i < 2; i++) {
        domain d = shape_sheet(2, 1, 20, 10);
        handles h = {.count = 1, .handle = wrong[i]};
        double *w = bake_alloc((size_t)d.vertex_count, sizeof *w);
        double *e = bake_alloc((size_t)d.vertex_count, sizeof *e);
        bake_error error = {""};
        for (int v = 0; v < d.vertex_count; v++)
            w[v] = 1;
        CHECK(ends_make(&d, &h, ENDS_BOUNDED, w, &how, e, &error) < 0);
        CHECK(strstr(error.text, expect[i]) != NULL);
        free(w);
        free(e);
        shape_free(&d);
    }
}

/* ---- the filter ------------------------------------------------------------------------------ */

static double filtered(const ends_filter *f, double x)
{
    ends_apply(f, &x, 1);
    return x;
}

static void filters_are_monotone_and_pass_through_their_points(void)
{
    static const double x[5] = {0.1, 0.3, 0.35, 0.7, 0.9}, y[5] = {0.02, 0.02, 0.6, 0.65, 1};
    ends_filter f = {5, x, y};
    CHECK_NEAR(filtered(&f, 0), 0, 0);
    CHECK_NEAR(filtered(&f, 1), 1, 0);
    for (int i = 0; i < 5; i++)
        CHECK_NEAR(filtered(&f, x[i]), y[i], 1e-15);
    for (int i = 0; i < 10000; i++)
        CHECK(filtered(&f, (i + 1) / 10000.0) >= filtered(&f, i / 10000.0) - 1e-15);
    for (int i = 0; i < 5; i++) { /* slopes from both sides: second derivatives are below 2000 */
        double left = (y[i] - filtered(&f, x[i] - 1e-7)) / 1e-7;
        double right = (filtered(&f, x[i] + 1e-7) - y[i]) / 1e-7;
        CHECK_NEAR(left, right, 1e-3);
    }
}

static void filters_on_a_line_change_nothing(void)
{
    static const double x[4] = {0, 0.25, 0.8, 1};
    ends_filter none = {0, NULL, NULL}, line = {4, x, x};
    for (int i = 0; i <= 1000; i++) {
        CHECK_NEAR(filtered(&none, i / 1000.0), i / 1000.0, 0);
        CHECK_NEAR(filtered(&line, i / 1000.0), i / 1000.0, 1e-15);
    }
}

/* One point (1/2, 1/4): secants 1/2 and 3/2, slopes 1/2, 1, 3/2, all within the circle of radius 3;
 * by hand f(1/4) = (0 + 1/4) / 2 + (1/2) (1/2 - 1) / 8 and f(3/4) = 5/8 + (1/2) (1 - 3/2) / 8. */
static void a_filter_of_one_point_is_known_by_hand(void)
{
    static const double x = 0.5, y = 0.25;
    ends_filter f = {1, &x, &y};
    CHECK_NEAR(filtered(&f, 0.25), 0.125 - 0.03125, 1e-15);
    CHECK_NEAR(filtered(&f, 0.75), 0.625 - 0.03125, 1e-15);
}

int main(void)
{
    TEST(all_kinds_are_bounded_and_interpolate);
    TEST(gradients_are_finite);
    TEST(flat_ends_are_linear_on_the_bone);
    TEST(solid_ends_are_nearly_linear_on_the_bone);
    TEST(on_a_thin_bar_ends_are_a_smooth_step);
    TEST(projection_and_distance_follow_their_formulas);
    TEST(ends_from_joints_are_a_half_far_from_both);
    TEST(bounded_ends_reach_the_full_turn);
    TEST(ends_go_on_where_the_bone_moves_nothing);
    TEST(loose_parts_have_projections);
    TEST(bones_may_begin_outside);
    TEST(bones_without_length_or_samples_are_named);
    TEST(filters_are_monotone_and_pass_through_their_points);
    TEST(filters_on_a_line_change_nothing);
    TEST(a_filter_of_one_point_is_known_by_hand);
    return check_done();
}

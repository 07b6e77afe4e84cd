/* What the certificate says of rigs: where weights were solved and how exactly, what pruning them
 * costs, what fields lose.
 * Source: Jacobson 2013, 4.3; (5.2).
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify_parts.h"
#include "shapes.h"
#include "skins.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const METHOD[] = {"linear", "dual quaternions", "shift"};
static const char *const WEIGHTS[] = {"bounded", "coupled", "biharmonic", "harmonic",
                                      "from the file"};
static const char *const ENDS[] = {"", ", stretchable (bounded)", ", stretchable (projection)",
                                   ", stretchable (distance)", ", stretchable (joints)"};

static size_t skin_bytes(const skin *k, const scene_rig *rig)
{
    size_t each = k->end ? 3 : 2;
    size_t total = WG_SKIN_BYTES + WG_SPAN_BYTES + WG_BONE_BYTES * (size_t)k->bone_count;
    for (int i = 0; i < k->vertex_count; i++) {
        total += each * (size_t)k->stored[i].count;
    }
    for (int i = 0; i < rig->bone_count; i++) {
        total += WG_JOINT_BYTES * (size_t)rig->bones[i].joint_count;
    }
    return total;
}

static void count_influences(const skin *k, int count[INFLUENCES_MAX + 1])
{
    memset(count, 0, (INFLUENCES_MAX + 1) * sizeof *count);
    for (int i = 0; i < k->vertex_count; i++) {
        count[k->stored[i].count]++;
    }
}

/* ---- fields ----------------------------------------------------------------------------------- */

/* Largest difference of a field's mean with all weights from that with those stored, over all poses of
 * its rig, in the channel's unit. The weights are those of skin_pack.c. */
static double field_error(const scene_rig *rig, const skin *k, int index)
{
    const double *row = k->field + (size_t)index * (size_t)k->bone_count;
    const int size[2] = {1, k->bone_count};
    double *used = bake_alloc((size_t)k->bone_count, sizeof *used), sum = 0, worst = 0;
    bake_error error;
    influence v;
    for (int j = 0; j < k->bone_count; j++) {
        used[j] = rig->bones[j].value < 0 ? 0 : row[j];
        sum += used[j];
    }
    for (int j = 0; j < k->bone_count && sum > 0; j++) {
        used[j] /= sum;
    }
    int known = sum > 0 && influence_make(used, NULL, size, INFLUENCES_MAX, &v, &error) == 0;
    for (int p = 0; known && p < k->poses.count; p++) {
        const double *value = k->poses.value + (size_t)p * (size_t)k->poses.channels;
        double exact = 0, stored = 0;
        for (int j = 0; j < k->bone_count; j++) {
            exact += used[j] == 0 ? 0 : used[j] * value[rig->bones[j].value];
        }
        for (int j = 0; j < v.count; j++) {
            stored += influence_weight(&v, j) * value[rig->bones[v.bone[j]].value];
        }
        worst = fmax(worst, fabs(exact - stored));
    }
    free(used);
    return worst;
}

static int field_over(const build *b, const scene_rig *rig, const skin *k, int index)
{
    double allowed = b->scene->channels[rig->fields[index].channel].tolerance;
    return allowed > 0 && field_error(rig, k, index) > allowed;
}

int certify_skins(const build *b)
{
    int failed = 0;
    for (int i = 0; b->shapes && i < b->shapes->count; i++) {
        const skin *k = b->shapes->mesh[i].skin;
        for (int f = 0; k && f < b->scene->rigs[k->rig].field_count; f++) {
            failed += field_over(b, &b->scene->rigs[k->rig], k, f);
        }
    }
    return failed;
}

/* ---- for people ------------------------------------------------------------------------------- */

static void print_handles(const scene_rig *rig, const skin *k, FILE *to)
{
    if (k->handle_count > 0) {
        fputs("    handle             energy stationary      dual    bounds   at 0   at 1\n", to);
    }
    for (int i = 0; i < k->handle_count; i++) {
        const bounded_report *r = &k->handle[i].report;
        fprintf(to, "    %-14s %10.4g %10.1e %9.1e %9.1e %6d %6d\n",
                rig->bones[k->handle[i].bone].name, r->energy, r->stationarity, r->dual, r->bounds,
                r->low, r->high);
    }
}

static void print_domain(const skin *k, FILE *to)
{
    if (k->handle_count > 0) {
        fprintf(to, ", on %d %s of %d vertices%s, from which the mesh is %.3g away at most",
                k->domain_elements, k->dimension == 3 ? "tetrahedra" : "triangles",
                k->domain_vertices, k->wrapped ? " around the surface" : "", k->far);
    }
    fputc('\n', to);
}

static void print_fields(const build *b, const scene_rig *rig, const skin *k, FILE *to)
{
    for (int i = 0; i < rig->field_count; i++) {
        const scene_channel *c = &b->scene->channels[rig->fields[i].channel];
        fprintf(to, "    field %s: off by %.3g %s at most%s\n", c->name, field_error(rig, k, i),
                unit_name(c->unit), field_over(b, rig, k, i) ? "  OVER" : "");
    }
}

void certificate_print_skins(const build *b, FILE *to)
{
    for (int i = 0; b->shapes && i < b->shapes->count; i++) {
        const skin *k = b->shapes->mesh[i].skin;
        int count[INFLUENCES_MAX + 1];
        if (k == NULL) {
            continue;
        }
        const scene_rig *rig = &b->scene->rigs[k->rig];
        fprintf(to, "rig %s: %d bones, %s%s; weights %s", rig->name, k->bone_count,
                METHOD[rig->method], ENDS[rig->ends], WEIGHTS[rig->weights]);
        print_domain(k, to);
        print_handles(rig, k, to);
        count_influences(k, count);
        fputs("    vertices with", to);
        for (int n = 1; n <= INFLUENCES_MAX; n++) {
            if (count[n] > 0) {
                fprintf(to, " %d: %d,", n, count[n]);
            }
        }
        fprintf(to, " %zu bytes; pruning and rounding move them by %.3g at most in %d poses\n",
                skin_bytes(k, rig), k->pruned, k->poses.count);
        print_fields(b, rig, k, to);
    }
}

void certificate_print_skin_failures(const build *b, FILE *to)
{
    for (int i = 0; b->shapes && i < b->shapes->count; i++) {
        const skin *k = b->shapes->mesh[i].skin;
        for (int f = 0; k && f < b->scene->rigs[k->rig].field_count; f++) {
            const scene_rig *rig = &b->scene->rigs[k->rig];
            if (field_over(b, rig, k, f)) {
                fprintf(to,
                        "FAILED: field %s is off by %.3g, its channel's tolerance is less: raise "
                        "it; weights are stored in 256 parts\n",
                        b->scene->channels[rig->fields[f].channel].name, field_error(rig, k, f));
            }
        }
    }
}

/* ---- JSON ------------------------------------------------------------------------------------- */

static void json_handles(const scene_rig *rig, const skin *k, bytes *out)
{
    put_text(out, "\"handles\": [");
    for (int i = 0; i < k->handle_count; i++) {
        const bounded_report *r = &k->handle[i].report;
        put_text(out, "%s{", i > 0 ? ", " : "");
        json_name(out, "bone", rig->bones[k->handle[i].bone].name);
        put_text(out,
                 "\"energy\": %.9g, \"stationarity\": %.3e, \"dual\": %.3e, \"bounds\": %.3e, "
                 "\"low\": %d, \"high\": %d, \"factors\": %d}",
                 r->energy, r->stationarity, r->dual, r->bounds, r->low, r->high, r->factors);
    }
    put_text(out, "]");
}

void certificate_json_skins(const build *b, bytes *out)
{
    int rows = 0;
    put_text(out, "\"rigs\": [");
    for (int i = 0; b->shapes && i < b->shapes->count; i++) {
        const skin *k = b->shapes->mesh[i].skin;
        int count[INFLUENCES_MAX + 1];
        if (k == NULL) {
            continue;
        }
        const scene_rig *rig = &b->scene->rigs[k->rig];
        count_influences(k, count);
        put_text(out, "%s\n    {", rows++ > 0 ? "," : "");
        json_name(out, "name", rig->name);
        put_text(out,
                 "\"bones\": %d, \"dimension\": %d, \"domain_vertices\": %d, "
                 "\"domain_elements\": %d, \"wrapped\": %s, \"far\": %.6g, \"pruned\": %.6g, "
                 "\"poses\": %d, \"bytes\": %zu, \"influences\": [",
                 k->bone_count, k->dimension, k->domain_vertices, k->domain_elements,
                 k->wrapped ? "true" : "false", k->far, k->pruned, k->poses.count,
                 skin_bytes(k, rig));
        for (int n = 1; n <= INFLUENCES_MAX; n++) {
            put_text(out, "%s%d", n > 1 ? ", " : "", count[n]);
        }
        put_text(out, "], ");
        json_handles(rig, k, out);
        put_text(out, "}");
    }
    put_text(out, "%s]", rows > 0 ? "\n  " : "");
}

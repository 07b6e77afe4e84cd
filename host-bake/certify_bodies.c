/* What the certificate says of elastic bodies: what they are, how they swing, what their motion
 * costs.
 * Source: Schulz 2013, (2.11), (2.20); the comparison with frames is ours.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "bodies.h"
#include "certify_parts.h"

#include <math.h>

/* Frequencies that a line holds. */
#define SHOWN 8

static const char *const KIND[] = {"solid", "shell", "chain"};
static const char *const ELEMENT[] = {"tetrahedra", "triangles", "links"};
static const char *const DYNAMICS[] = {"one-point", "blend", "couple", "spline"};

/* Bytes of the same motion as positions of 16 bits, 30 times a second, of the meshes of a body. */
static double frame_bytes(const build *b, const body_report *r)
{
    const scene_body *body = &b->scene->bodies[r->body];
    double total = 0;
    for (int i = 0; i < b->shapes->count; i++) {
        const shape_mesh *m = &b->shapes->mesh[i];
        int mine = m->index == body->mesh;
        for (int k = 0; k < body->attached_count; k++) {
            mine |= m->index == body->attached[k];
        }
        for (int k = 0; mine && k < m->mesh.frames_count; k++) {
            const mesh_frames *f = &m->mesh.frames[k];
            total += 6.0 * m->mesh.vertex_count * ceil(30 * f->time[f->count - 1]);
        }
    }
    return total;
}

static void print_modes(const body_report *r, FILE *to)
{
    fprintf(to, "  modes    ");
    for (int i = 0; i < r->mode_count && i < SHOWN; i++) {
        fprintf(to, " %.4g", r->hertz[i]);
    }
    fprintf(to, "%s Hz; %d rigid; residual %.1e\n", r->mode_count > SHOWN ? " ..." : "", r->rigid,
            r->residual);
}

static void print_motion(const build *b, const body_motion_report *m, FILE *to)
{
    const scene_clip *clip = &b->scene->clips[m->clip];
    const scene_action *a = &clip->actions[m->action];
    fprintf(to, "  %-9s %s, %d coordinates, E %.4g", clip->name, DYNAMICS[a->dynamics],
            m->dimension, m->energy);
    if (m->cubic >= 0) {
        fprintf(to, " (cubic spline %.4g)", m->cubic);
    }
    if (m->missed >= 0) {
        fprintf(to, ", partial poses missed by %.3g", m->missed);
    }
    fputc('\n', to);
}

void certificate_print_bodies(const build *b, FILE *to)
{
    const bodies *all = b->shapes ? b->shapes->bodies : NULL;
    for (int i = 0; all && i < all->count; i++) {
        const body_report *r = &all->report[i];
        const scene_body *body = &b->scene->bodies[r->body];
        double frames = frame_bytes(b, r);
        fprintf(to, "body %s: %s of %d vertices, %d %s, %d coordinates, %.4g kg%s\n", body->name,
                KIND[body->kind], r->vertices, r->elements, ELEMENT[body->kind], r->coordinates,
                r->mass, r->waves ? "; its channels are wiggly splines" : "");
        print_modes(r, to);
        if (r->far > 0) {
            fprintf(to, "  attached  up to %.3g outside of the body\n", r->far);
        }
        for (int k = 0; k < r->motion_count; k++) {
            print_motion(b, &r->motion[k], to);
        }
        if (frames > 0) {
            fprintf(to, "  as frames of 16 bits, 30 a second: %.0f bytes\n", frames);
        }
    }
}

void certificate_json_bodies(const build *b, bytes *out)
{
    const bodies *all = b->shapes ? b->shapes->bodies : NULL;
    put_text(out, "\"bodies\": [");
    for (int i = 0; all && i < all->count; i++) {
        const body_report *r = &all->report[i];
        put_text(out, "%s\n    {", i > 0 ? "," : "");
        json_name(out, "body", b->scene->bodies[r->body].name);
        put_text(out,
                 "\"kind\": \"%s\", \"vertices\": %d, \"elements\": %d, \"coordinates\": %d, "
                 "\"mass_kg\": %.9g, \"rigid\": %d, \"residual\": %.3e, \"waves\": %s, "
                 "\"frame_bytes\": %.0f,\n     \"hertz\": [",
                 KIND[b->scene->bodies[r->body].kind], r->vertices, r->elements, r->coordinates,
                 r->mass, r->rigid, r->residual, r->waves ? "true" : "false", frame_bytes(b, r));
        for (int k = 0; k < r->mode_count; k++) {
            put_text(out, "%s%.9g", k > 0 ? ", " : "", r->hertz[k]);
        }
        put_text(out, "],\n     \"motions\": [");
        for (int k = 0; k < r->motion_count; k++) {
            const body_motion_report *m = &r->motion[k];
            put_text(out, "%s{", k > 0 ? ", " : "");
            json_name(out, "clip", b->scene->clips[m->clip].name);
            put_text(out,
                     "\"coordinates\": %d, \"energy\": %.9g, \"cubic_energy\": %.9g, \"missed\": "
                     "%.9g}",
                     m->dimension, m->energy, m->cubic, m->missed);
        }
        put_text(out, "]}");
    }
    put_text(out, "\n  ]");
}

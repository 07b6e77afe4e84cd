/* The certificate's meshes for people and as JSON, and what a target has room for.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify_parts.h"
#include "shapes.h"
#include "skins.h"

#include <math.h>

/* wg_picture on a 32-bit processor, asserted by tests/fw_size_picture.c. */
#define PICTURE_BYTES 232

/* wg_picture_skins, and a wg_bone. */
#define SKINS_BYTES 84
#define BONE_BYTES  64

/* A tolerance over what bases leave: their share of it is less than all, curves take some. */
#define ROOM 1.2

/* Rest, each weight and the affine part's products are rounded to about a step of the coordinates:
 * that many together at the worst vertex. */
#define FEW_STEPS 4

size_t certify_picture_ram(const build *b)
{
    size_t vertices = 0, bases = 0, shaded = 0, bare = 0, bones = 0;
    for (int i = 0; b->shapes && i < b->shapes->count; i++) {
        const shape_mesh *m = &b->shapes->mesh[i];
        vertices += (size_t)m->mesh.vertex_count;
        bases = (size_t)m->form.basis_count > bases ? (size_t)m->form.basis_count : bases;
        bare |= !m->has_normals && m->mesh.picture == NULL;
        bones =
            m->skin && (size_t)m->skin->bone_count > bones ? (size_t)m->skin->bone_count : bones;
    }
    for (int i = 0; i < b->scene->view_count; i++) {
        shaded |= b->scene->views[i].shading == (int)WG_SHADING_SMOOTH;
    }
    return vertices == 0
               ? 0
               : PICTURE_BYTES + (vertices + 1) * (6 + shaded + 6 * (shaded & bare)) +
                     2 * (bases + 1) + (bones > 0 ? SKINS_BYTES + BONE_BYTES * (bones + 1) : 0);
}

/* ---- for people ------------------------------------------------------------------------------- */

static const char *clip_of(const build *b, const certificate_mesh *r)
{
    return r->clip < 0 ? "(shapes)" : b->scene->clips[r->clip].name;
}

/* Where it is worst, as a person would look for it. */
#define PLACE_BYTES 160

static const char *place_of(const build *b, const certificate_mesh *r, char text[PLACE_BYTES])
{
    const shape_form *form = &b->shapes->mesh[r->mesh].form;
    if (r->largest <= 0) {
        snprintf(text, PLACE_BYTES, "exact");
    } else if (r->clip == CERTIFY_RANDOM) {
        snprintf(text, PLACE_BYTES, "in a random pose, vertex %d", r->vertex);
    } else if (r->clip >= 0) {
        snprintf(text, PLACE_BYTES, "in %.64s at %.3f s, frame %d, vertex %d",
                 b->scene->clips[r->clip].name, r->when, r->frame, r->vertex);
    } else if (r->frame >= 0 && r->frame < form->basis_count) {
        snprintf(text, PLACE_BYTES, "with %.64s at 1, vertex %d",
                 b->scene->channels[form->basis[r->frame].channel].name, r->vertex);
    } else {
        snprintf(text, PLACE_BYTES, "%s, vertex %d",
                 r->frame < 0 && form->basis_count > 0 ? "with all shapes at 1" : "at rest",
                 r->vertex);
    }
    return text;
}

static void print_levels(const certificate_mesh *r, FILE *to)
{
    for (int k = 0; r->level && k <= r->bases; k++) {
        /* every one of the first, then fewer */
        if (k > 4 && k < r->bases && k % (r->bases > 20 ? 8 : 4) != 0) {
            continue;
        }
        fprintf(to, "    %3d bases %9.3g %9.3g %8zu bytes\n", k, r->level[k].largest,
                r->level[k].rms, r->level[k].bytes);
    }
}

void certificate_print_meshes(const build *b, const certificate *c, FILE *to)
{
    static const char *const AFFINE[] = {"not moved as a whole", "moved as a whole",
                                         "turned as a whole"};
    if (c->mesh_count > 0) {
        fputs("meshes (posed against loaded, every vertex of every frame; lengths in the scene's "
              "unit)\n"
              "  mesh            vertices triangles  bases  bits   largest       rms tolerance\n",
              to);
    }
    for (int i = 0; i < c->mesh_count; i++) {
        const certificate_mesh *r = &c->mesh[i];
        char place[PLACE_BYTES];
        fprintf(to, "  %-14s %9d %9d %6d %5d %9.3g %9.3g %9.3g %s%s\n",
                b->scene->meshes[r->mesh].name, r->vertices, r->triangles, r->bases, r->bits,
                r->largest, r->rms, r->tolerance, place_of(b, r, place),
                r->largest > r->tolerance ? "  OVER" : "");
        fprintf(to,
                "    %s; at most %d bases at work; bytes: rest %zu, bases %zu, weights %zu, "
                "whole %zu, normals %zu, triangles %zu\n",
                AFFINE[r->affine], r->at_work, r->rest_bytes, r->basis_bytes, r->weight_bytes,
                r->affine_bytes, r->normal_bytes, r->triangle_bytes);
        if (b->shapes->mesh[i].frame_count > 0) {
            print_levels(r, to);
        }
    }
}

/* How many bases of the mesh that has most bytes would fit, the others being as they are. */
static void advise_flash(const build *b, const certificate *c, FILE *to)
{
    int most = -1, k;
    for (int i = 0; i < c->mesh_count; i++) {
        if (c->mesh[i].level && b->shapes->mesh[i].frame_count > 0 &&
            (most < 0 || c->mesh[i].basis_bytes > c->mesh[most].basis_bytes)) {
            most = i;
        }
    }
    if (most < 0) {
        fputs("make the meshes or the clips smaller\n", to);
        return;
    }
    const certificate_mesh *r = &c->mesh[most];
    for (k = r->bases; k >= 0; k--) {
        double size =
            (double)c->file_bytes + (double)r->level[k].bytes - (double)r->level[r->bases].bytes;
        if (size <= b->scene->flash_bytes) {
            break;
        }
    }
    if (k < 0) {
        fprintf(to,
                "without any bases of mesh %s it would still be too large: use a mesh with "
                "fewer vertices, or fewer clips\n",
                b->scene->meshes[r->mesh].name);
        return;
    }
    fprintf(to,
            "the first %d of %d bases of mesh %s would fit, and be off by up to %.3g: set its "
            "tolerance to %.3g, or leave out clips\n",
            k, r->bases, b->scene->meshes[r->mesh].name, r->level[k].largest,
            ROOM * r->level[k].largest);
}

void certificate_print_target(const build *b, const certificate *c, FILE *to)
{
    const scene *s = b->scene;
    if (c->over_flash) {
        fprintf(to, "FAILED: the clip takes %zu bytes, the target has %.0f of flash; ",
                c->file_bytes, s->flash_bytes);
        advise_flash(b, c, to);
    }
    if (c->over_ram) {
        size_t total = c->ram_bytes + c->picture_ram, vertices = 0;
        for (int i = 0; i < c->mesh_count; i++) {
            vertices += (size_t)c->mesh[i].vertices;
        }
        double each = c->picture_ram > 0 ? 7 : 1, over = (double)total - s->ram_bytes;
        fprintf(to,
                "FAILED: playing takes %zu bytes of RAM, without a band of pixels; the target "
                "has %.0f",
                total, s->ram_bytes);
        if ((double)vertices * each > over) {
            fprintf(to, ": meshes of %.0f vertices instead of %zu would fit",
                    (double)vertices - over / each - 1, vertices);
        }
        fputc('\n', to);
    }
}

void certificate_print_mesh_failures(const build *b, const certificate *c, FILE *to)
{
    for (int i = 0; i < c->mesh_count; i++) {
        const certificate_mesh *r = &c->mesh[i];
        const scene_mesh *m = &b->scene->meshes[r->mesh];
        double step = ldexp(1, -b->shapes->mesh[i].form.frac);
        char place[PLACE_BYTES];
        if (r->largest <= r->tolerance) {
            continue;
        }
        fprintf(to, "FAILED: mesh %s is off by %.3g %s", m->name, r->largest,
                place_of(b, r, place));
        if (r->bases > 0) {
            fprintf(to, ", with %d bases of %d bits", r->bases, r->bits);
        }
        fprintf(to, "; the tolerance is %.3g: ", r->tolerance);
        if (b->shapes->mesh[i].skin) {
            const scene_rig *rig = &b->scene->rigs[b->shapes->mesh[i].skin->rig];
            fprintf(to,
                    rig->influences < (int)WG_INFLUENCES_MAX
                        ? "allow more than %d `influences`, or raise it\n"
                        : "%d `influences` are all there are: raise it\n",
                    rig->influences);
            continue;
        }
        if (r->tolerance < FEW_STEPS * step) {
            fprintf(to, "coordinates are stored in steps of %.3g here: raise it to %.3g\n", step,
                    FEW_STEPS * step);
            continue;
        }
        fputs(m->bases > 0 && r->bases >= m->bases ? "allow more `bases`, or raise it\n"
              : r->bases >= (int)WG_BASES_MAX
                  ? "no shape has more bases: raise it, or split the mesh's motions\n"
              : r->bits == 8 ? "set `bits: 16`, or raise it\n"
                             : "raise it\n",
              to);
    }
}

/* ---- JSON ------------------------------------------------------------------------------------- */

static void add_levels(const certificate_mesh *r, bytes *out)
{
    put_text(out, "\"levels\": [");
    for (int k = 0; r->level && k <= r->bases; k++) {
        put_text(out,
                 "%s\n      {\"bases\": %d, \"error_max\": %.9g, \"error_rms\": %.9g, \"bytes\": "
                 "%zu}",
                 k > 0 ? "," : "", k, r->level[k].largest, r->level[k].rms, r->level[k].bytes);
    }
    put_text(out, "]}");
}

void certificate_json_meshes(const build *b, const certificate *c, bytes *out)
{
    static const char *const AFFINE[] = {"none", "affine", "rotation"};
    put_text(out, "\"picture_ram_bytes\": %zu,\n  \"meshes\": [", c->picture_ram);
    for (int i = 0; i < c->mesh_count; i++) {
        const certificate_mesh *r = &c->mesh[i];
        put_text(out, "%s\n    {", i > 0 ? "," : "");
        json_name(out, "mesh", b->scene->meshes[r->mesh].name);
        json_name(out, "clip", clip_of(b, r));
        put_text(out,
                 "\"vertices\": %d, \"triangles\": %d, \"bases\": %d, \"bits\": %d, \"whole\": "
                 "\"%s\", \"bases_at_work\": %d,\n     ",
                 r->vertices, r->triangles, r->bases, r->bits, AFFINE[r->affine], r->at_work);
        put_text(out,
                 "\"error_max\": %.9g, \"error_rms\": %.9g, \"tolerance\": %.9g, \"error_at_s\": "
                 "%.6f, \"frame\": %d, \"vertex\": %d,\n     ",
                 r->largest, r->rms, r->tolerance, r->when, r->frame, r->vertex);
        put_text(out,
                 "\"bytes\": {\"rest\": %zu, \"bases\": %zu, \"weights\": %zu, \"whole\": %zu, "
                 "\"normals\": %zu, \"triangles\": %zu},\n     ",
                 r->rest_bytes, r->basis_bytes, r->weight_bytes, r->affine_bytes, r->normal_bytes,
                 r->triangle_bytes);
        add_levels(r, out);
    }
    put_text(out, "\n  ]");
}

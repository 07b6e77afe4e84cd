/* Meshes of a scene, from their files to channels; and the whole bake around it.
 * Source: own, on Alexa 2002, chapter 7.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "shape_parts.h"

#include "bodies.h"
#include "certify_shapes.h"
#include "skins.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <stdio.h>
#include <unistd.h>

/* Of the tolerance. What is left of it, and more where the worst places of bases and curves are not
 * the same, is for the integers. A repetition shrinks both. */
static const shape_aim first_aim = {0.92, 0.3};

/* Bakes before giving up: each asks a mesh that misses its tolerance for less. */
#define ROUNDS 5

static int decompose(const scene *s, shape_mesh *m, bake_error *error)
{
    if (m->given) {
        if (shape_solve_given(s, m, error) < 0) {
            return -1;
        }
    } else if (m->mesh.frames_count == 0) {
        shape_solve_shapes(s, m);
    } else if (shape_solve_frames(s, m, error) < 0) {
        return -1;
    }
    shape_solve_normals(s, m);
    return 0;
}

/* Arrays as large as all frames that are there at the same time: frames, normalised, residual, what
 * LAPACK is given and gives, what a choice leaves; measured: 5.4. */
#define COPIES 6

/* The machine has the memory for it, or it would be stopped without a message. */
static int check_memory(const scene *s, const shape_mesh *m, bake_error *error)
{
    const scene_mesh *from = &s->meshes[m->index];
    double frames = 0, gigabyte = 1 << 30;
    double memory = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE) / gigabyte;
    for (int i = 0; i < m->mesh.frames_count; i++) {
        frames += m->mesh.frames[i].count;
    }
    double need = COPIES * 3 * sizeof(double) * frames * m->mesh.vertex_count / gigabyte;
    return need <= memory
               ? 0
               : bake_fail(error,
                           "%s:%d: mesh %s: %.0f frames of %d vertices take %.1f GB to decompose, "
                           "this machine has %.1f: name fewer `frames`, or lower `rate`",
                           s->path, from->line, from->name, frames, m->mesh.vertex_count, need,
                           memory);
}

/* What a decomposition leaves behind, for the next one. */
static void forget(shape_mesh *m)
{
    shape_form_free(&m->form);
    shape_form_free(&m->normals);
    free(m->turn);
    m->turn = NULL;
    m->rotated = m->has_normals = 0;
}

static void progress(int verbose, const shape_mesh *m, const scene *s)
{
    if (verbose && isatty(2)) {
        fprintf(stderr, "\rmesh %s\033[K", s->meshes[m->index].name);
    }
}

/* A mesh without a file is a chain's, which draws it. */
static int load_meshes(const scene *s, int verbose, shapes *out, bake_error *error)
{
    int err = 0;
    for (int i = 0; i < s->mesh_count && err == 0; i++) {
        shape_mesh *m = &out->mesh[i];
        m->index = i;
        m->aim = first_aim;
        m->form.affine = m->normals.affine = -1;
        progress(verbose, m, s);
        err = s->meshes[i].file ? mesh_load(s, i, &m->mesh, error) : 0;
        out->count += err == 0;
    }
    return err;
}

static int load(scene *s, int verbose, shapes *out, bake_error *error)
{
    memset(out, 0, sizeof *out);
    if (skins_prepare(s, error) < 0) {
        return -1;
    }
    out->channel_first = s->channel_count;
    out->mesh = bake_alloc((size_t)s->mesh_count + 1, sizeof *out->mesh);
    out->bodies = bake_alloc(1, sizeof *out->bodies);
    bodies_want(s);
    int err = load_meshes(s, verbose, out, error);
    if (err == 0) {
        err = bodies_make(s, out, verbose, out->bodies, error);
    }
    for (int i = 0; i < out->count && err == 0; i++) {
        progress(verbose, &out->mesh[i], s);
        err = check_memory(s, &out->mesh[i], error) < 0 ? -1 : decompose(s, &out->mesh[i], error);
        if (err == 0) {
            err = skin_make(s, &out->mesh[i], verbose, error);
        }
    }
    if (verbose && isatty(2) && s->mesh_count > 0) {
        fprintf(stderr, "\r\033[K");
    }
    if (err < 0) {
        shapes_free(out);
    }
    return err;
}

int shapes_make(scene *s, shapes *out, int verbose, bake_error *error)
{
    if (load(s, verbose, out, error) < 0) {
        return -1;
    }
    shape_fit_views(s, out);
    if (shapes_attach(s, out, error) < 0) {
        shapes_free(out);
        return -1;
    }
    return 0;
}

void shapes_free(shapes *sh)
{
    for (int i = 0; i < sh->count; i++) {
        forget(&sh->mesh[i]);
        free(sh->mesh[i].frame);
        free(sh->mesh[i].piece);
        free(sh->mesh[i].given_basis);
        free(sh->mesh[i].given_weight);
        free(sh->mesh[i].shown);
        skin_free(sh->mesh[i].skin);
        mesh_free(&sh->mesh[i].mesh);
    }
    if (sh->bodies) {
        bodies_free(sh->bodies);
    }
    free(sh->bodies);
    free(sh->mesh);
    memset(sh, 0, sizeof *sh);
}

/* Less for the curves, by what they took of the room that the bases left; from the second time on less
 * for the bases too: by as much as the finished file was too far off, and a little more. 0: the mesh is
 * good, or there are no bases to be had. */
static int tighten(shape_mesh *m, const certificate_mesh *row)
{
    double ratio = 0.98 * row->tolerance / row->largest;
    if (row->largest <= row->tolerance || m->frame_count == 0 ||
        m->left > m->aim.bases * m->tolerance) {
        return 0;
    }
    double room = 0.98 - m->left / m->tolerance, took = row->largest / m->tolerance - 0.98 + room;
    if (m->tries > 0) {
        m->aim.bases *= ratio < 0.5 ? 0.5 : ratio;
        m->stale = 1;
    }
    m->aim.curves *= m->tries > 0 ? 0.5 : fmax(0.5, fmin(0.9, room / took));
    m->tries++;
    return 1;
}

/* One bake and its measurement. 1: some mesh should be tried again. */
static int try_bake(scene *s, int verbose, shapes *sh, build *b, bake_error *error)
{
    int again = 0;
    if (build_make_shapes(s, sh, verbose, b, error) < 0) {
        return -1;
    }
    wg_file file;
    if (wg_open(&file, b->file.at, (uint32_t)b->file.count) < 0 || wg_open_shapes(&file) < 0 ||
        wg_open_skins(&file) < 0) {
        build_free(b);
        return bake_fail(error, "%s: the player refuses the finished file: the baker has a fault",
                         s->path);
    }
    for (int i = 0; i < sh->count; i++) {
        certificate_mesh row;
        certify_mesh(b, &file, i, &row);
        if (tighten(&sh->mesh[i], &row)) {
            again = 1;
        }
        certificate_mesh_free(&row);
    }
    return again;
}

/* The scene has its made channels and their curves again. */
static int remake(scene *s, shapes *sh, bake_error *error)
{
    int err = 0;
    shapes_detach(s, sh);
    for (int i = 0; i < sh->count && err == 0; i++) {
        if (sh->mesh[i].stale) {
            forget(&sh->mesh[i]);
            err = decompose(s, &sh->mesh[i], error);
            sh->mesh[i].stale = 0;
        }
    }
    return err == 0 ? shapes_attach(s, sh, error) : -1;
}

int shapes_bake(scene *s, int verbose, shapes *out, build *b, bake_error *error)
{
    int again = 1;
    if (shapes_make(s, out, verbose, error) < 0) {
        return -1;
    }
    for (int round = 0; round < ROUNDS && again > 0; round++) {
        if (round > 0) {
            build_free(b);
            again = remake(s, out, error);
        }
        if (again >= 0) {
            again = try_bake(s, verbose, out, b, error);
        }
    }
    if (again < 0) {
        shapes_free(out);
        return -1;
    }
    return 0;
}

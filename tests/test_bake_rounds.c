/* A bake that misses a mesh's tolerance starts again with smaller shares, and says so when that does
 * not help. The model is that of examples/faerie: 17 frames of a dance, no two of them alike.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify.h"
#include "check.h"
#include "shapes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MODEL   "/usr/share/assimp/models/MD2/faerie.md2"
#define SCRATCH "build/rounds_test.yaml"

static scene s;
static shapes sh;
static build b;
static bake_error error;

static void bake(double tolerance)
{
    FILE *file = fopen(SCRATCH, "w");
    if (file == NULL) {
        printf("%s: cannot be written\n", SCRATCH);
        exit(1);
    }
    fprintf(file,
            "channels: [{name: a}]\n"
            "meshes: [{name: thing, file: %s, tolerance: %g}]\n"
            "clips: [{name: c, meshes: [{mesh: thing, frames: [95, 111], rate: 9 Hz}]}]\n",
            MODEL, tolerance);
    fclose(file);
    if (scene_load(SCRATCH, &s, &error) < 0 || shapes_bake(&s, 0, &sh, &b, &error) < 0) {
        printf("%s\n", error.text);
        exit(1);
    }
    remove(SCRATCH);
}

/* The certificate of what was baked. */
static certificate judge(void)
{
    certificate c;
    wg_file file;
    CHECK_EQ(wg_open(&file, b.file.at, (uint32_t)b.file.count), 0);
    CHECK_EQ(certify(&b, &file, b.file.count, &c, &error), 0);
    return c;
}

static void drop(certificate *c)
{
    certificate_free(c);
    build_free(&b);
    shapes_free(&sh);
    scene_free(&s);
}

/* About four steps of the coordinates. Then what is rounded takes more than bases and curves leave at
 * first. */
static void shares_shrink_until_the_player_shows_it_within_the_tolerance(void)
{
    const double tolerance = 0.004;
    bake(tolerance);
    const shape_mesh *m = &sh.mesh[0];
    CHECK(ldexp(tolerance, m->form.frac) < 5);
    CHECK(m->tries > 0);
    CHECK(m->left <= m->aim.bases * tolerance);
    certificate c = judge();
    CHECK_EQ(c.mesh_count, 1);
    CHECK(c.mesh[0].largest <= tolerance && c.mesh[0].largest > 0);
    CHECK_EQ(c.failed, 0);
    drop(&c);
}

/* A hundredth of a step: no share is small enough. Nothing claims otherwise. */
static void a_tolerance_below_the_integers_is_missed_and_said_so(void)
{
    bake(2e-5);
    certificate c = judge();
    CHECK(c.mesh[0].largest > 2e-5);
    CHECK(c.failed > 0);
    CHECK(c.mesh[0].largest < 4.0 / 512); /* but no farther off than a few steps */
    drop(&c);
}

/* What is far coarser than the model takes no bases, one round, and no less time: 16 steps of 1/9 s,
 * to half a tick. */
static void a_tolerance_above_the_model_takes_no_bases(void)
{
    bake(500);
    certificate c = judge();
    CHECK_EQ(c.mesh[0].bases, 0);
    CHECK_EQ(sh.mesh[0].tries, 0);
    CHECK_NEAR((double)b.clip[0].ticks / b.clip[0].rate, 16.0 / 9, 0.5 / b.clip[0].rate);
    CHECK_EQ(c.failed, 0);
    drop(&c);
}

int main(void)
{
    TEST(shares_shrink_until_the_player_shows_it_within_the_tolerance);
    TEST(a_tolerance_below_the_integers_is_missed_and_said_so);
    TEST(a_tolerance_above_the_model_takes_no_bases);
    return check_done();
}

/* Rigs that files bring along: bones, weights and posed vertices against an independent reader of
 * glTF, and against Assimp's own matrices; what the scene adds; damaged files.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "rig_file.h"
#include "author.h"
#include "check.h"
#include "rig.h"
#include "rig_nodes.h"
#include "rig_take.h"

#include <assimp/cimport.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MODELS "/usr/share/assimp/models/" /* Debian package assimp-testmodels */
#define ORACLE "/usr/bin/python3 -B tests/reference/rig_oracle.py "

static const char scratch[] = "build/rig_scene.yaml";
static const char made[] = "build/rig_made.gltf", posed[] = "build/rig_posed.gltf";
static const char damaged[] = "build/rig_damaged.gltf";

static const char *clip_fields = "";
static scene s;
static mesh m;
static double *w, *values;
static rig_bone *now;
static bake_error error;

static void write_text(const char *path, const char *text, size_t size)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL || fwrite(text, 1, size, file) != size) {
        printf("%s: cannot be written\n", path);
        exit(1);
    }
    fclose(file);
}

static void drop(void)
{
    free(w);
    free(values);
    free(now);
    w = values = NULL;
    now = NULL;
    mesh_free(&m);
    scene_free(&s);
}

/* A scene with one mesh, its rig from the same file, and a clip of all its animation. 0, or -1 with
 * a message; drop() in any case. */
static int load(const char *path, const char *fields, const char *bones)
{
    char text[4096], here[512];
    if (realpath(path, here) == NULL)
        exit(1);
    int size =
        snprintf(text, sizeof text,
                 "channels: [{name: glow}]\nsources: [{name: motion, file: %s}]\n"
                 "meshes: [{name: body, file: %s%s}]\nrigs:\n"
                 "- {name: man, mesh: body, file: %s, weights: file%s}\n"
                 "clips:\n- name: go\n  rigs: [{rig: man, source: motion, travel: true}]\n%s",
                 here, here, fields, here, bones, clip_fields);
    write_text(scratch, text, (size_t)size);
    error.text[0] = '\0';
    m = (mesh){0};
    if (scene_load(scratch, &s, &error)) {
        printf("%s\n", error.text);
        exit(1);
    }
    int err = rig_file_bones(&s, 0, &error);
    err = err || rig_takes(&s, &error) || mesh_load(&s, 0, &m, &error) ? -1 : 0;
    size_t bone_count = (size_t)s.rigs[0].bone_count;
    now = bake_alloc(bone_count + 1, sizeof *now);
    values = bake_alloc((size_t)s.channel_count, sizeof *values);
    w = bake_alloc((size_t)m.vertex_count * bone_count + 1, sizeof *w);
    return err || rig_file_weights(&s, 0, &m, w, &error) ? -1 : 0;
}

static void must_load(const char *path, const char *fields, const char *bones)
{
    int err = load(path, fields, bones);
    if (err)
        printf("%s\n", error.text);
    CHECK_EQ(err, 0);
}

static int bone_of(const char *name)
{
    for (int i = 0; i < s.rigs[0].bone_count; i++)
        if (strcmp(s.rigs[0].bones[i].name, name) == 0)
            return i;
    return -1;
}

/* The cubic through four samples around a time, or as many as there are between two corners. */
static double value_at(const capture *c, double time)
{
    int i = 1, first, last;
    double sum = 0;
    while (i < c->count - 1 && c->time[i] < time - 1e-9)
        i++;
    first = i - 1 > 0 && !c->kink[i - 1] ? i - 2 : i - 1;
    last = i < c->count - 1 && !c->kink[i] ? i + 1 : i;
    for (int k = first; k <= last; k++) {
        double part = c->value[k];
        for (int j = first; j <= last; j++)
            part *= j != k ? (time - c->time[j]) / (c->time[k] - c->time[j]) : 1;
        sum += part;
    }
    return sum;
}

static author_clip *authored; /* NULL: the samples */

static void pose(double time)
{
    for (int k = 0; k < s.channel_count; k++)
        values[k] = s.channels[k].rest;
    for (int k = 0; k < s.clips[0].curve_count; k++) {
        const scene_curve *c = &s.clips[0].curves[k];
        double out[4];
        if (authored != NULL)
            bake_curve_eval(&authored->curve[k], fmin(time, 5.5), out);
        values[c->channel] = authored != NULL ? out[0] : value_at(c->samples, time);
    }
    rig_pose(&s.rigs[0], values, now);
}

static void skin(const double rest[3], const double *weight, double out[3])
{
    rig_skin(&s.rigs[0], now, weight, NULL, rest, out);
}

static double weight_sums(void)
{
    double worst = 0;
    for (int v = 0; v < m.vertex_count; v++) {
        double sum = 0;
        for (int b = 0; b < s.rigs[0].bone_count; b++)
            sum += w[b * m.vertex_count + v];
        worst = fmax(worst, fabs(sum - 1));
    }
    return worst;
}

/* ---- against the oracle ---------------------------------------------------------------------- */

typedef struct {
    int vertices, joints, *bone; /* bone: of each joint */
    double *rest, *weight;       /* vertices x 3, vertices x joints */
    double axes[3][3];           /* from the file to the scene */
    double worst_place, worst_at, worst_weight;
} told;

static void turn(const told *t, const double in[3], double out[3])
{
    for (int r = 0; r < 3; r++)
        out[r] = t->axes[r][0] * in[0] + t->axes[r][1] * in[1] + t->axes[r][2] * in[2];
}

static void read_told(FILE *from, told *t)
{
    char name[256];
    CHECK_EQ(fscanf(from, "%d %d", &t->vertices, &t->joints), 2);
    t->bone = bake_alloc((size_t)t->joints, sizeof *t->bone);
    t->rest = bake_alloc(3 * (size_t)t->vertices, sizeof *t->rest);
    t->weight = bake_alloc((size_t)t->joints * (size_t)t->vertices, sizeof *t->weight);
    for (int j = 0; j < t->joints; j++) {
        CHECK_EQ(fscanf(from, "%255s", name), 1);
        t->bone[j] = -1;
        for (int i = 0; i < s.rigs[0].bone_count; i++)
            if (strcmp(s.rigs[0].bones[i].node, name) == 0)
                t->bone[j] = i;
        CHECK(t->bone[j] >= 0);
    }
    for (int v = 0; v < t->vertices; v++) {
        double raw[3] = {0};
        for (int k = 0; k < 3; k++)
            CHECK_EQ(fscanf(from, "%lf", &raw[k]), 1);
        turn(t, raw, t->rest + 3 * v);
        for (int j = 0; j < t->joints; j++)
            CHECK_EQ(fscanf(from, "%lf", &t->weight[v * t->joints + j]), 1);
    }
}

/* The oracle's vertex at a place. */
static int find_told(told *t, const double at[3])
{
    int best = 0;
    double least = HUGE_VAL;
    for (int v = 0; v < t->vertices; v++) {
        double apart = 0;
        for (int k = 0; k < 3; k++)
            apart = fmax(apart, fabs(t->rest[3 * v + k] - at[k]));
        if (apart < least) {
            least = apart;
            best = v;
        }
    }
    t->worst_place = fmax(t->worst_place, least);
    return best;
}

static void compare_weights(told *t, int *found)
{
    for (int v = 0; v < m.vertex_count; v++) {
        found[v] = find_told(t, m.rest + 3 * v);
        for (int j = 0; j < t->joints; j++)
            t->worst_weight = fmax(t->worst_weight, fabs(w[t->bone[j] * m.vertex_count + v] -
                                                         t->weight[found[v] * t->joints + j]));
    }
}

static void compare_pose(FILE *from, told *t, const int *found, double time)
{
    double *want = bake_alloc(3 * (size_t)t->vertices, sizeof *want);
    double weight[256], got[3], raw[3] = {0};
    for (int v = 0; v < t->vertices; v++) {
        for (int k = 0; k < 3; k++)
            CHECK_EQ(fscanf(from, "%lf", &raw[k]), 1);
        turn(t, raw, want + 3 * v);
    }
    pose(time);
    for (int v = 0; v < m.vertex_count; v++) {
        for (int b = 0; b < s.rigs[0].bone_count; b++)
            weight[b] = w[b * m.vertex_count + v];
        skin(m.rest + 3 * v, weight, got);
        for (int k = 0; k < 3; k++)
            t->worst_at = fmax(t->worst_at, fabs(got[k] - want[3 * found[v] + k]));
    }
    free(want);
}

/* Poses of the loaded file at 0.1 s steps; `axes` as the mesh's up and scale. */
static told compare(const char *path, double last, double scale, int z_up)
{
    char command[4000];
    int used = snprintf(command, sizeof command, ORACLE "gltf-skin %s", path);
    for (double t = 0; t <= last; t += 0.1)
        used += snprintf(command + used, sizeof command - (size_t)used, " %.9g", t);
    told t = {.axes = {{scale, 0, 0},
                       {0, z_up ? 0 : scale, z_up ? scale : 0},
                       {0, z_up ? -scale : 0, z_up ? 0 : scale}}};
    FILE *oracle = popen(command, "r");
    read_told(oracle, &t);
    int *found = bake_alloc((size_t)m.vertex_count, sizeof *found);
    compare_weights(&t, found);
    for (double time = 0; time <= last; time += 0.1)
        compare_pose(oracle, &t, found, time);
    CHECK_EQ(pclose(oracle), 0);
    free(found);
    free(t.bone);
    free(t.rest);
    free(t.weight);
    printf("%s: %d vertices, %d bones: places at rest off by %.1e, weights %.1e, posed vertices "
           "%.1e; weights sum to 1 +- %.1e\n",
           path, m.vertex_count, s.rigs[0].bone_count, t.worst_place, t.worst_weight, t.worst_at,
           weight_sums());
    CHECK_NEAR(weight_sums(), 0, 1e-12); /* divided by their sum in doubles */
    return t;
}

/* All within 4 of the origin. Assimp's matrices are float32, 5 nodes deep: 5 roundings of 2^-24 x 4
 * in places, and what a rotation of 5 x 2^-23 moves at a distance of 2: 3e-6 in all. Between two
 * samples of an arc, 2 degrees apart, the test's parabola at its ends misses 0.035^3 / 16 of a
 * radius of 0.4: 1e-6. */
static const double float_tolerance = 4e-6;

static void simple_skin_moves_as_gltf_says(void)
{
    const char *path = MODELS "glTF2/simple_skin/simple_skin.gltf";
    must_load(path, "", "");
    told t = compare(path, 5.5, 1, 0);
    CHECK_NEAR(t.worst_at, 0, float_tolerance);
    CHECK_NEAR(t.worst_weight, 0, 1e-7); /* float32 */
    CHECK_EQ(t.vertices, m.vertex_count);
    drop();
}

/* The curves that a clip gets: its keys stand half a second apart and twice have the same value.
 * The splines end with a second derivative 0 at the keys: with the half angle's steps h of 1 degree
 * they miss 0.064 h^2 of a quaternion, twice that of a rotation, 4e-5 at a reach of 1.1. All times
 * are whole milliseconds. */
static void simple_skin_does_so_between_its_keys(void)
{
    author_clip clip;
    const char *path = MODELS "glTF2/simple_skin/simple_skin.gltf";
    must_load(path, "", "");
    CHECK_EQ(author_clip_make(&s, 0, &clip, &error), 0);
    CHECK_EQ(clip.rate, 1000);
    authored = &clip;
    told t = compare(path, 5.5, 1, 0);
    authored = NULL;
    author_clip_free(&clip);
    CHECK_NEAR(t.worst_at, 0, 4.5e-5);
    drop();
}

/* Axes of joints, a node between them, units of centimetres, z up below, an eye without weights. */
static void a_file_of_many_axes_moves_as_gltf_says(void)
{
    CHECK_EQ(system(ORACLE "gltf-make build/rig_made.gltf"), 0);
    must_load(made, "", "");
    told t = compare(made, 2.4, 1, 0);
    CHECK_EQ(t.vertices, m.vertex_count);
    CHECK_NEAR(t.worst_place, 0, float_tolerance);
    CHECK_NEAR(t.worst_at, 0, float_tolerance);
    CHECK_NEAR(t.worst_weight, 0, 2e-7); /* divided by a sum of four float32 */
    drop();
    must_load(made, ", up: z, scale: 10", "");
    t = compare(made, 2.4, 10, 1);
    CHECK_NEAR(t.worst_at, 0, 10 * float_tolerance);
    drop();
}

/* The nodes stand otherwise in the file than when the mesh was bound. */
static void a_posed_file_is_bound_where_its_mesh_is(void)
{
    CHECK_EQ(system(ORACLE "gltf-make build/rig_posed.gltf posed"), 0);
    must_load(posed, "", "");
    told t = compare(posed, 2.4, 1, 0);
    CHECK_NEAR(t.worst_at, 0, float_tolerance);
    CHECK_NEAR(t.worst_weight, 0, 2e-7);
    drop();
}

static void bones_are_the_nodes_that_vertices_follow(void)
{
    must_load(made, "", "");
    const scene_rig *rig = &s.rigs[0];
    CHECK_EQ(rig->bone_count, 7);
    int hips = bone_of("mixamorig_Hips"), helper = bone_of("helper"), spine = bone_of("Spine");
    CHECK(hips == 0 && rig->bones[0].parent == -1);
    CHECK(helper > 0 && rig->bones[helper].weightless && rig->bones[helper].parent == spine);
    CHECK(bone_of("b1st") > 0 && bone_of("Arm_L") > 0 && bone_of("Arm_L_2") > 0);
    CHECK(strcmp(rig->bones[bone_of("b1st")].node, "1st") == 0);
    for (int k = 0; k < 3; k++) {
        CHECK_NEAR(rig->bones[hips].to[k], rig->bones[spine].from[k], 0);
        CHECK_NEAR(rig->bones[spine].to[k], rig->bones[helper].from[k], 0);
        const scene_bone *end = &rig->bones[bone_of("Arm_L_2")], *arm = &rig->bones[end->parent];
        CHECK_NEAR(end->to[k] - end->from[k], 0.5 * (arm->to[k] - arm->from[k]), 1e-12);
    }
    CHECK_NEAR(rig->bones[spine].along, 1, 0);
    drop();
}

/* Assimp 5.2.5 takes bytes for floats there. */
static void weights_that_are_read_wrong_are_refused(void)
{
    CHECK_EQ(system(ORACLE "gltf-make build/rig_posed.gltf bytes"), 0);
    CHECK_EQ(load(posed, "", ""), -1);
    CHECK(strstr(error.text, "weights that sum to nonsense for vertex") != NULL &&
          strstr(error.text, "export them as floats") != NULL);
    drop();
}

/* simple_skin.gltf ends as it begins. */
static void a_capture_that_closes_loops_smoothly(void)
{
    static const char *const fields[] = {"", "  end: loop\n", "  end: loop\n  duration: 5\n"};
    for (int i = 0; i < 3; i++) {
        clip_fields = fields[i];
        must_load(MODELS "glTF2/simple_skin/simple_skin.gltf", "", "");
        for (int k = 0; k < s.clips[0].curve_count; k++) {
            const scene_curve *c = &s.clips[0].curves[k];
            CHECK_EQ(c->end[0], i == 1 ? BAKE_END_PERIODIC : BAKE_END_ACCELERATION);
            CHECK_EQ(c->end[1], c->end[0]);
            CHECK_NEAR(c->samples->value[c->samples->count - 1], c->samples->value[0],
                       i == 1 ? 0 : 1e-6);
        }
        drop();
    }
    clip_fields = "";
}

/* ---- against Assimp's own matrices ----------------------------------------------------------- */

/* G(t) offset of one bone of one mesh against what the rig does to four points. FBX and X files
 * bring lengths that do not change, so the whole bone moves as its node does. */
static double compare_node(const rig_nodes *n, int bone, double time, double scale)
{
    const scene_bone *b = &s.rigs[0].bones[bone];
    affine there, back, moved;
    double worst = 0, weight[256] = {0};
    int node = rig_nodes_find(n, b->node);
    rig_nodes_pose(n, node, time, &there);
    if (affine_inverse(&n->node[node].bind, &back))
        return HUGE_VAL;
    moved = affine_product(&there, &back);
    weight[bone] = 1;
    for (int corner = 0; corner < 4; corner++) {
        double p[3], got[3];
        for (int k = 0; k < 3; k++)
            p[k] = b->from[k] + (corner == k + 1 ? scale : 0);
        skin(p, weight, got);
        for (int k = 0; k < 3; k++) {
            double want = moved.at[k][3];
            for (int c = 0; c < 3; c++)
                want += moved.at[k][c] * p[c];
            worst = fmax(worst, fabs(got[k] - want));
        }
    }
    return worst;
}

static void bones_of_other_formats_move_as_their_nodes(void)
{
    static const struct {
        const char *path;
        double size, step; /* of the file's keys [s] */
        int steps;
    } files[] = {{MODELS "FBX/huesitos.fbx", 500, 0.04, 39},
                 {MODELS "X/Testwuson.X", 2, 1.0 / 30, 29}};
    for (int i = 0; i < 2; i++) {
        must_load(files[i].path, "", "");
        const struct aiScene *file = rig_nodes_open(files[i].path);
        rig_nodes n;
        affine world = affine_identity();
        rig_nodes_make(file, &world, &n);
        CHECK(rig_nodes_animate(&n, file->mAnimations[0]) == NULL);
        double worst = 0;
        for (int k = 0; k <= files[i].steps; k++)
            for (int b = 0; b < s.rigs[0].bone_count; b++) {
                pose(k * files[i].step);
                worst = fmax(worst, compare_node(&n, b, k * files[i].step, 0.1 * files[i].size));
            }
        printf("%s: %d bones: off by %.1e, weights sum to 1 +- %.1e\n", files[i].path,
               s.rigs[0].bone_count, worst, weight_sums());
        CHECK_NEAR(worst, 0, 1e-5 * files[i].size);
        rig_nodes_free(&n);
        aiReleaseImport(file);
        drop();
    }
}

/* ---- what the scene adds --------------------------------------------------------------------- */

static void the_scene_adds_to_bones_of_the_file(void)
{
    must_load(
        made, "",
        ", bones: [{name: Spine, depth: 2, value: glow}, {name: hat, parent: Spine, to: [9, 9, "
        "9], from: [8, 8, 8]}, {name: Arm_L_2, node: 1st}]");
    const scene_rig *rig = &s.rigs[0];
    int spine = bone_of("Spine"), hat = bone_of("hat"), arm = bone_of("Arm_L_2");
    CHECK_EQ(rig->bone_count, 8);
    CHECK(rig->bones[spine].depth == 2 && rig->bones[spine].value == 0);
    CHECK(rig->bones[spine].parent == 0 && strcmp(rig->bones[spine].node, "Spine") == 0);
    CHECK_EQ(hat, 7);
    CHECK_EQ(rig->bones[hat].parent, spine);
    CHECK(strcmp(rig->bones[arm].node, "1st") == 0 && rig->bones[arm].parent >= 0);
    CHECK(rig->bones[hat].from[0] == 8);
    CHECK_NEAR(weight_sums(), 0, 1e-12);
    drop();
}

static void refuse(const char *path, const char *bones, const char *words)
{
    CHECK_EQ(load(path, "", bones), -1);
    if (strstr(error.text, "rig_scene.yaml:") == NULL || strstr(error.text, words) == NULL) {
        check_ok = 0;
        printf("expected %s\n     got %s\n", words, error.text);
    }
    drop();
}

static void messages_say_what_is_wrong(void)
{
    refuse(made, ", bones: [{name: Spline}]", "no bone 'Spline', and a bone of the scene's own");
    refuse(made, ", bones: [{name: helper}, {name: Spine, parent: helper}]", "remove 'parent'");
    refuse("tests/scenes/house.obj", "", "has no bones");
    refuse(made, ", bones: [{name: Spine, node: Spline}]", "has no node 'Spline'; did you mean");
    refuse(MODELS "glTF2/MissingBin/BoxTextured.gltf", "", "cannot be read");
}

/* Another mesh than the file's: the first vertex that it does not have is named. */
static void weights_of_another_file_are_refused(void)
{
    must_load(made, "", "");
    m.rest[3 * 5] += 1e-3;
    CHECK_EQ(rig_file_weights(&s, 0, &m, w, &error), -1);
    CHECK(strstr(error.text, "does not have vertex 5 of the mesh 'body', at (") != NULL);
    m.rest[3 * 5] -= 1e-3;
    CHECK_EQ(rig_file_weights(&s, 0, &m, w, &error), 0);
    drop();
}

static void try_damaged(void)
{
    int err = load(damaged, "", "");
    CHECK(err == 0 || (err == -1 && strstr(error.text, "rig_scene.yaml:") != NULL));
    for (int i = 0; err == 0 && i < m.vertex_count * s.rigs[0].bone_count; i++)
        if (!(w[i] >= 0 && w[i] <= 1 + 1e-9))
            CHECK(!"a weight is none");
    drop();
}

/* Letters of the JSON and of the base64 in it (floats become NaN, indices too large), and ends. */
static void damaged_files_are_told_and_crash_nothing(void)
{
    static char text[1 << 17];
    FILE *file = fopen(made, "rb");
    size_t size = fread(text, 1, sizeof text, file);
    fclose(file);
    for (size_t i = 1; i < 12; i++) {
        write_text(damaged, text, size * i / 12);
        try_damaged();
    }
    unsigned random = 7;
    for (int i = 0; i < 70; i++) {
        char kept[8];
        random = random * 1664525u + 1013904223u;
        size_t at = (random >> 8) % (size - 8);
        memcpy(kept, text + at, 8);
        for (int k = 0; k < 8; k++)
            if (kept[k] != '"' && kept[k] != ',')
                text[at + (size_t)k] = i % 2 ? '/' : '9';
        write_text(damaged, text, size);
        try_damaged();
        memcpy(text + at, kept, 8);
    }
}

int main(void)
{
    TEST(simple_skin_moves_as_gltf_says);
    TEST(simple_skin_does_so_between_its_keys);
    TEST(a_file_of_many_axes_moves_as_gltf_says);
    TEST(a_posed_file_is_bound_where_its_mesh_is);
    TEST(weights_that_are_read_wrong_are_refused);
    TEST(bones_are_the_nodes_that_vertices_follow);
    TEST(a_capture_that_closes_loops_smoothly);
    TEST(bones_of_other_formats_move_as_their_nodes);
    TEST(the_scene_adds_to_bones_of_the_file);
    TEST(messages_say_what_is_wrong);
    TEST(weights_of_another_file_are_refused);
    TEST(damaged_files_are_told_and_crash_nothing);
    return check_done();
}

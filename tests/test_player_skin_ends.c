/* Skins whose vertices lie somewhere along their bones: stretch and twist, against a model in doubles
 * (skin_model.h) and against what must hold without one. Bounds: skin_fixture.h.
 * SPDX-License-Identifier: MIT */
#include "skin_fixture.h"

static const double X[3] = {1, 0, 0}, Z[3] = {0, 0, 1};

/* ---- ends --------------------------------------------------------------------------------------- */

static void ends_stretch_and_twist_as_the_model(void)
{
    for (int method = 0; method < 2; method++) {
        for (int influences = 1; influences <= 8; influences++) {
            rig r = {.method = method, .ends = 1};
            rig_random(&r, 4, 1);
            for (int i = 0; i < r.bones; i++) {
                rig_joints(&r, i, 1, 90);
                rig_stretch(&r, i, skin_random(0, 2), skin_random(-400, 400),
                            skin_random(-400, 400));
            }
            rig_vertices(&r, 40, influences, 8000);
            double twist = 8 * PI * ldexp(1, -20) * 4 * 45000;
            skin_compare(&r, twist + (method ? bound_dual(45000, 8) : bound_ends(45000, 8)));
        }
    }
}

/* T2 of the thesis's reading: with nothing stretched and nothing twisted, ends do not matter. */
static void ends_without_stretch_and_twist_are_plain_skinning(void)
{
    rig r = {.method = WG_SKIN_LINEAR, .ends = 1}, plain;
    skin_fixture with, without;
    rig_random(&r, 5, 1);
    for (int i = 0; i < r.bones; i++) {
        rig_joints(&r, i, 3, 120);
    }
    rig_vertices(&r, 60, 4, 8000);
    plain = r;
    plain.ends = 0;
    for (int i = 0; i < r.vertices * r.influences; i++) {
        plain.data[2 * i] = r.data[3 * i];
        plain.data[2 * i + 1] = r.data[3 * i + 1];
    }
    skin_open(&with, &r);
    skin_open(&without, &plain);
    skin_pose(&with, NULL);
    skin_pose(&without, NULL);
    for (int i = 0; i < 3 * r.vertices; i++) { /* see bound_ends: what ends add */
        CHECK_NEAR(with.xyz[i] / 256.0, without.xyz[i] / 256.0,
                   36000 * 4 * ldexp(1, -15) + 2 * sqrt(3));
    }
    skin_close(&with);
    skin_close(&without);
}

/* T3: the ends of a bone go where its ends go. */
static void ends_of_a_bone_follow_it(void)
{
    for (int method = 0; method < 2; method++) {
        rig r = {.method = method, .ends = 1, .vertices = 2, .influences = 1};
        const int16_t rest[6] = {100, 200, 300, 2100, 200, 300};
        const uint8_t data[6] = {0, 255, 0, 0, 255, 255};
        skin_fixture f;
        rig_bone *b = rig_add_bone(&r, -1, 100, 200, 300);
        double start[3], end[3], turned[9], way[3] = {2000 * 1.5, 0, 0};
        b->length = 2000;
        rig_turn(&r, b, Z, 30);
        rig_axis(rig_add_joint(b, WG_JOINT_MOVE, rig_channel(&r, 16, 50)), 0, 0, 1);
        rig_stretch(&r, 0, 1.5, 500, -300);
        memcpy(r.rest, rest, sizeof rest);
        memcpy(r.data, data, sizeof data);
        skin_open(&f, &r);
        skin_pose(&f, NULL);
        model_turn(Z, 30, turned);
        model_apply(turned, way, way);
        skin_vertex(&f, 0, start);
        skin_vertex(&f, 1, end);
        double tolerance = method ? bound_dual(3000, 2) : bound_ends(3000, 2);
        for (int c = 0; c < 3; c++) {
            double a = rest[c] + (c == 2 ? 50 * 16 : 0);
            CHECK_NEAR(start[c], a, tolerance);
            CHECK_NEAR(end[c], a + way[c], tolerance);
        }
        skin_close(&f);
    }
}

/* T6: a section at e turns by the part e of the twist, however far that is. */
static void sections_turn_in_proportion(void)
{
    static const double TWISTS[] = {90, 315, 360, 1000};
    for (int method = 0; method < 2; method++) {
        for (unsigned t = 0; t < sizeof TWISTS / sizeof *TWISTS; t++) {
            rig r = {.method = method, .ends = 1, .influences = 1};
            skin_fixture f;
            rig_bone *b = rig_add_bone(&r, -1, 0, 0, 0);
            b->length = 8000;
            rig_stretch(&r, 0, 1, 45, 45 + TWISTS[t]);
            for (int e = 0; e < 256; e++) {
                const int16_t rest[3] = {(int16_t)(31 * e), 3000, 0};
                const uint8_t data[3] = {0, 255, (uint8_t)e};
                memcpy(r.rest + 3 * e, rest, sizeof rest);
                memcpy(r.data + 3 * e, data, sizeof data);
            }
            r.vertices = 256;
            skin_open(&f, &r);
            skin_pose(&f, NULL);
            for (int e = 0; e < 256; e++) {
                double got[3], want = (45 + TWISTS[t] * model_e(e)) * PI / 180;
                skin_vertex(&f, e, got);
                double angle = remainder(atan2(got[2], got[1]) - want, 2 * PI);
                /* across a radius of 3000: rounding of bound_ends, and the rate's */
                CHECK_NEAR(angle, 0, 3.5 / 3000 + TWISTS[t] * 2e-8 + 1e-5);
                CHECK_NEAR(got[0], 31 * e, 3.5);
            }
            skin_close(&f);
        }
    }
}

/* T7: halfway between two bones that are twisted by 180 degrees against each other, LINEAR collapses
 * and DUAL keeps the radius. */
static void twisted_elbow_keeps_its_radius_with_dual_quaternions(void)
{
    for (int method = 0; method < 2; method++) {
        rig r = {.method = method, .vertices = 16, .influences = 2};
        skin_fixture f;
        rig_bone *b = rig_add_bone(&r, -1, -2000, 0, 0);
        b->length = 2000;
        rig_turn(&r, rig_add_bone(&r, -1, 0, 0, 0), X, 179);
        for (int v = 0; v < 16; v++) {
            const uint8_t data[4] = {0, 127, 1, 128};
            r.rest[3 * v + 1] = (int16_t)lrint(1000 * cos(v * PI / 8));
            r.rest[3 * v + 2] = (int16_t)lrint(1000 * sin(v * PI / 8));
            memcpy(r.data + 4 * v, data, sizeof data);
        }
        skin_open(&f, &r);
        skin_pose(&f, NULL);
        for (int v = 0; v < 16; v++) {
            double got[3];
            skin_vertex(&f, v, got);
            double radius = hypot(got[1], got[2]);
            CHECK(method == WG_SKIN_DUAL ? radius >= 950 && radius < 1001 : radius < 20);
            CHECK_NEAR(got[0], 0, bound(3000, 1));
        }
        skin_close(&f);
    }
}

int main(void)
{
    TEST(ends_stretch_and_twist_as_the_model);
    TEST(ends_without_stretch_and_twist_are_plain_skinning);
    TEST(ends_of_a_bone_follow_it);
    TEST(sections_turn_in_proportion);
    TEST(twisted_elbow_keeps_its_radius_with_dual_quaternions);
    return check_done();
}

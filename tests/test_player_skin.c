/* Skins against a model in doubles (skin_model.h), and against what must hold without one: bones,
 * cameras, values. Bounds: skin_fixture.h.
 * SPDX-License-Identifier: MIT */
#include "skin_fixture.h"

static const double X[3] = {1, 0, 0}, Y[3] = {0, 1, 0}, Z[3] = {0, 0, 1};

/* ---- rest -------------------------------------------------------------------------------------- */

static void rest_is_exact(int method, int influences)
{
    rig r = {.method = method, .origin = {100, -200, 70000}};
    skin_fixture f;
    rig_random(&r, 5, 1);
    for (int i = 0; i < r.bones; i++) {
        for (int c = 0; c < 3; c++) {
            r.bone[i].origin[c] += r.origin[c] + floor(skin_random(0, 256)) / 256;
        }
        rig_joints(&r, i, 7, 0);
    }
    rig_vertices(&r, 60, influences, 32767);
    skin_open(&f, &r);
    skin_pose(&f, NULL);
    for (int i = 0; i < 3 * r.vertices; i++) {
        int32_t want = (r.rest[i] + r.origin[i % 3]) * 256;
        CHECK_NEAR(f.xyz[i], want, method == WG_SKIN_DUAL ? bound_dual(0, 5) * 256 : 0);
    }
    skin_close(&f);
}

static void rest_pose_is_exact_to_the_bit(void)
{
    for (int influences = 1; influences <= 8; influences++) {
        rest_is_exact(WG_SKIN_LINEAR, influences);
        rest_is_exact(WG_SKIN_SHIFT, influences);
        rest_is_exact(WG_SKIN_DUAL, influences);
    }
}

/* ---- joints and chains -------------------------------------------------------------------------- */

/* Vertices within 8000 of the origin, bones within 3000: D < 3 11000, and what moves add. */
static void joints_turn_and_move_as_the_model(void)
{
    for (int kinds = 1; kinds < 8; kinds++) {
        for (int method = 0; method < 3; method++) {
            rig r = {.method = method};
            rig_random(&r, 4, 0);
            for (int i = 0; i < r.bones; i++) {
                rig_joints(&r, i, kinds, 180);
            }
            rig_vertices(&r, 40, 1 + kinds % 4, 8000);
            skin_compare(&r, method == WG_SKIN_DUAL ? bound_dual(36000, 2) : bound(36000, 2));
        }
    }
}

static void turns_of_more_than_a_circle_are_the_rest_of_them(void)
{
    static const double DEGREES[] = {181, 270, 359.5, 361, 725, -1000, 12345.678};
    for (unsigned i = 0; i < sizeof DEGREES / sizeof *DEGREES; i++) {
        for (int method = 0; method < 2; method++) {
            rig r = {.method = method};
            const double axis[3] = {2, -1, 3};
            rig_turn(&r, rig_add_bone(&r, -1, 200, 100, -50), axis, DEGREES[i]);
            rig_turn(&r, rig_add_bone(&r, 0, 900, -100, 300), Y, -DEGREES[i]);
            rig_vertices(&r, 30, 1, 8000);
            skin_compare(&r, method ? bound_dual(30000, 2) : bound(30000, 2));
        }
    }
}

/* 20 bones of 400: bone 19 lies 7600 from the root, so that a vertex is within 7600 + 8000 of each. */
static void chains_of_twenty_bones_add_up(void)
{
    for (int method = 0; method < 2; method++) {
        for (int turned = 0; turned < 2; turned++) {
            rig r = {.method = method};
            for (int i = 0; i < 20; i++) {
                rig_bone *b = rig_add_bone(&r, i - 1, 400 * i - 4000, 0, 0);
                b->length = 400;
                b->along = 255;
                rig_turn(&r, b, turned ? Z : Y, turned ? 13 : -7.5);
            }
            rig_vertices(&r, 80, 3, 4000);
            skin_compare(&r, method ? bound_dual(31200, 20) : bound(31200, 20));
        }
    }
}

/* Quaternions that are shorter and longer than 1 neither fade nor overflow: 24 of them. */
static void chains_of_quaternions_keep_their_length(void)
{
    for (int length = 0; length < 2; length++) {
        rig r = {.method = WG_SKIN_DUAL};
        double q[4], axis[3];
        for (int i = 0; i < 8; i++) {
            double size = length ? 1.99 : 0.4;
            rig_bone *b = rig_add_bone(&r, i - 1, 300 * i, 0, 0);
            rig_direction(axis);
            q[0] = size * cos(0.2);
            for (int c = 0; c < 3; c++) {
                q[c + 1] = size * sin(0.2) * axis[c];
            }
            int first = rig_channel(&r, 24, q[0]);
            for (int c = 1; c < 4; c++) {
                rig_channel(&r, 24, q[c]);
            }
            for (int n = 0; n < 3; n++) {
                rig_add_joint(b, WG_JOINT_QUATERNION, first);
            }
        }
        rig_vertices(&r, 50, 1, 4000);
        skin_compare(&r, bound_dual(20000, 24));
    }
}

/* Parents that stretch and twist carry their children along. */
static void children_sit_on_a_stretched_and_twisted_parent(void)
{
    for (int along = 0; along < 256; along += 51) {
        for (int method = 0; method < 2; method++) {
            rig r = {.method = method};
            rig_random(&r, 3, 0);
            r.bone[1].parent = 0;
            r.bone[2].parent = 1;
            r.bone[1].along = r.bone[2].along = along;
            rig_joints(&r, 0, 1, 180);
            rig_stretch(&r, 0, 1.7, 90, 400);
            rig_stretch(&r, 1, 0.3, -700, 30);
            rig_vertices(&r, 30, 2, 8000);
            double twist = 8 * PI * ldexp(1, -20) * 36000; /* rates, see bound_ends */
            skin_compare(&r, twist + (method ? bound_dual(36000, 4) : bound(36000, 4)));
        }
    }
}

/* ---- FOLLOW ------------------------------------------------------------------------------------- */

/* Points that move, one in their middle that turns with them. The root of a length is 2^-14 off, so
 * a quaternion's scalar part by 2^-14 of 1 + cos, less than 2^-12 of what it is for turns of up to
 * 120 degrees; an entry by 8 times that times the sine of half the angle at most. */
static void follow(rig *r, int points, int flat)
{
    rig_bone *b = rig_add_bone(r, -1, 0, 0, 0);
    rig_joint *j = rig_add_joint(b, WG_JOINT_FOLLOW, 0);
    j->count = points;
    for (int i = 0; i < points; i++) {
        double at[3] = {0, 0, 0}, to[3];
        at[i % (flat ? 2 : 3)] = i % 2 ? -700 : 900;
        at[(i + 1) % 2] += 123 * i;
        b = rig_add_bone(r, -1, at[0], at[1], at[2]);
        rig_direction(to);
        for (int c = 0; c < (flat ? 2 : 3); c++) {
            const double *axis = c == 0 ? X : c == 1 ? Y : Z;
            rig_axis(rig_add_joint(b, WG_JOINT_MOVE, rig_channel(r, 16, to[c] * 30)), axis[0],
                     axis[1], axis[2]);
        }
        j->list[i] = (uint8_t)(i + 1);
    }
}

static void following_bones_turn_by_the_mean(void)
{
    for (int points = 1; points <= 8; points++) {
        for (int flat = 0; flat < 2; flat++) {
            rig r = {.method = points % 2};
            follow(&r, points, flat);
            rig_vertices(&r, 30, 1, 4000);
            skin_compare(&r, bound(12000, 2) + 12000 * 8 * ldexp(1, -12) / 4);
        }
    }
}

/* A point that has not moved, or lies where the bone is, and none at all: no turn. */
static void following_points_that_rest_turns_nothing(void)
{
    rig r = {.method = WG_SKIN_LINEAR};
    skin_fixture f;
    follow(&r, 3, 0);
    for (int i = 0; i < r.channels; i++) {
        r.value[i] = 0;
    }
    memset(r.bone[2].origin, 0, sizeof r.bone[2].origin);
    rig_vertices(&r, 30, 3, 4000);
    skin_open(&f, &r);
    skin_pose(&f, NULL);
    for (int i = 0; i < 3 * r.vertices; i++) {
        CHECK_EQ(f.xyz[i], r.rest[i] * 256);
    }
    skin_close(&f);
}

/* ---- whole rigs --------------------------------------------------------------------------------- */

/* P3: one rigid motion of all bones is that motion, whatever the weights. */
static void one_motion_of_all_bones_is_that_motion(void)
{
    for (int method = 0; method < 3; method++) {
        for (int ends = 0; ends < (method == WG_SKIN_SHIFT ? 1 : 2); ends++) {
            rig r = {.method = method, .ends = ends};
            const double axis[3] = {1, 2, -2};
            rig_turn(&r, rig_add_bone(&r, -1, 0, 0, 0), axis, method == WG_SKIN_SHIFT ? 0 : 77);
            rig_axis(rig_add_joint(&r.bone[0], WG_JOINT_MOVE, rig_channel(&r, 16, 111)), 0, 1, 0);
            for (int i = 1; i < 6; i++) {
                rig_add_bone(&r, i - 1, rig_place(2000), rig_place(2000), rig_place(2000));
            }
            rig_vertices(&r, 50, 5, 8000);
            rig one = r;
            one.influences = 1;
            for (int v = 0; v < r.vertices; v++) {
                const uint8_t data[3] = {0, 255, 0};
                memcpy(one.data + v * (2 + ends), data, 3);
            }
            skin_fixture f;
            model_bone bones[RIG_BONES];
            double tolerance = method == WG_SKIN_DUAL ? bound_dual(30000, 1)
                               : ends                 ? bound_ends(30000, 1)
                                                      : bound(30000, 1);
            skin_open(&f, &r);
            skin_pose(&f, NULL);
            model_bones(&one, bones);
            for (int v = 0; v < r.vertices; v++) {
                double want[3], got[3];
                model_vertex(&one, bones, v, want);
                skin_vertex(&f, v, got);
                for (int c = 0; c < 3; c++) {
                    CHECK_NEAR(got[c], want[c], tolerance + 6.0 / 256 * 6);
                }
            }
            skin_close(&f);
        }
    }
}

/* T4: turning and moving the root turns and moves every vertex. */
static void motion_of_the_root_moves_everything_with_it(void)
{
    for (int method = 0; method < 2; method++) {
        rig r = {.method = method, .ends = 1};
        skin_fixture f;
        double before[RIG_VERTICES][3], turned[9];
        rig_add_bone(&r, -1, 0, 0, 0);
        rig_turn(&r, &r.bone[0], Y, 0);
        for (int i = 1; i < 6; i++) {
            rig_add_bone(&r, (i - 1) / 2, rig_place(2000), rig_place(2000), rig_place(2000))
                ->length = 1000;
            rig_joints(&r, i, 1, 100);
            rig_stretch(&r, i, 1.3, -50, 200);
        }
        rig_vertices(&r, 50, 4, 6000);
        skin_open(&f, &r);
        skin_pose(&f, NULL);
        for (int v = 0; v < r.vertices; v++) {
            skin_vertex(&f, v, before[v]);
        }
        f.values[0] = skin_q(-100, r.frac[0]);
        skin_pose(&f, NULL);
        model_turn(Y, -100, turned);
        for (int v = 0; v < r.vertices; v++) {
            double got[3];
            model_apply(turned, before[v], before[v]);
            skin_vertex(&f, v, got);
            double tolerance = method ? bound_dual(30000, 8) : bound_ends(30000, 8);
            for (int c = 0; c < 3; c++) { /* both poses are rounded */
                CHECK_NEAR(got[c], before[v][c], 2 * tolerance);
            }
        }
        skin_close(&f);
    }
}

static void ranges_give_the_same_bits(void)
{
    for (int kind = 0; kind < 5; kind++) {
        rig r = {.method = kind / 2, .ends = kind % 2};
        skin_fixture f;
        rig_random(&r, 6, 1);
        for (int i = 0; i < r.bones; i++) {
            rig_joints(&r, i, 1, 180);
            rig_stretch(&r, i, 1.5, 30, 300);
        }
        rig_vertices(&r, 100, 3, 8000);
        skin_open(&f, &r);
        skin_pose(&f, NULL);
        for (int first = 0; first < 100; first += 13) {
            for (int count = 1; first + count <= 100; count += 17) {
                int32_t some[300];
                wg_skin_vertices(&f.skin, &f.pose, (uint16_t)first, (uint16_t)count, some);
                CHECK(memcmp(some, f.xyz + 3 * first, 12u * (unsigned)count) == 0);
            }
        }
        skin_close(&f);
    }
}

/* The camera: turn (y - centre) of what is seen without one. Its matrix multiplies the bones': once
 * more an entry's rounding. */
static void camera_sees_what_is_there(void)
{
    for (int kind = 0; kind < 5; kind++) {
        rig r = {.method = kind / 2, .ends = kind % 2};
        skin_fixture f;
        int32_t plain[3 * RIG_VERTICES];
        wg_rigid camera = {{0}, {16000, -4800, 1232}, 4 + RIG_FRAC};
        const double axis[3] = {2.0 / 3, -1.0 / 3, 2.0 / 3};
        double turned[9];
        model_turn(axis, 123, turned);
        for (int i = 0; i < 9; i++) {
            camera.turn_q30[i] = skin_q(turned[i], 30);
        }
        rig_random(&r, 5, 1);
        for (int i = 0; i < r.bones; i++) {
            rig_joints(&r, i, 3, 180);
        }
        rig_vertices(&r, 60, 3, 8000);
        skin_open(&f, &r);
        skin_pose(&f, NULL);
        memcpy(plain, f.xyz, sizeof plain);
        skin_pose(&f, &camera);
        for (int v = 0; v < r.vertices; v++) {
            double want[3], got[3];
            for (int c = 0; c < 3; c++) {
                want[c] = plain[3 * v + c] / 256.0 - camera.centre[c] / 16.0;
            }
            model_apply(turned, want, want);
            skin_vertex(&f, v, got);
            double tolerance = r.method != WG_SKIN_LINEAR ? 0.1
                               : r.ends                   ? 2 * bound_ends(40000, 1)
                                                          : 2 * bound(40000, 1);
            for (int c = 0; c < 3; c++) {
                CHECK_NEAR(got[c], want[c], tolerance);
            }
        }
        skin_close(&f);
    }
}

/* ---- values ------------------------------------------------------------------------------------- */

static void brightness_is_the_weighted_mean_of_values(void)
{
    for (int ends = 0; ends < 2; ends++) {
        rig r = {.method = WG_SKIN_LINEAR, .ends = ends};
        skin_fixture f;
        uint8_t got[RIG_VERTICES];
        static const double VALUES[] = {0, 1, 0.5, 2.5, -1, 0.25};
        for (int i = 0; i < 6; i++) {
            rig_bone *b = rig_add_bone(&r, -1, 0, 0, 0);
            b->value = i == 5 ? -1 : rig_channel(&r, 4 * i, VALUES[i]);
        }
        rig_vertices(&r, 90, 5, 1000);
        skin_open(&f, &r);
        wg_skin_brightness(&f.skin, f.values, 0, 90, got);
        for (int v = 0; v < 90; v++) {
            double sum = 0;
            uint8_t one;
            for (int i = 0; i < 5; i++) {
                const uint8_t *at = r.data + (5 * v + i) * (2 + ends);
                sum += (at[1] + (i == 0)) * (at[0] == 5 ? 0 : VALUES[at[0]]);
            }
            /* parts of 256; each influence rounds down by less than 1/256 of one */
            sum = fmin(fmax(sum, 0), 255);
            CHECK(got[v] <= sum + 1e-9 && got[v] > sum - 1 - 5 / 256.0);
            wg_skin_brightness(&f.skin, f.values, (uint16_t)v, 1, &one);
            CHECK_EQ(one, got[v]);
        }
        skin_close(&f);
    }
}

static void fields_are_weighted_means_in_order(void)
{
    build b = {{{0}}, 2};
    const int16_t rest[3] = {0, 0, 0};
    const build_shape_data shape = {1, 0, WG_ABSENT, {0, 0, 0}, rest};
    const uint16_t from[3] = {0, 1, 2}, again[1] = {3};
    const uint8_t weights[3] = {63, 128, 64}, all[1] = {255};
    int32_t values[5] = {1000, -77 * 16, 1 << 29, 5, 5};
    wg_file file;
    uint32_t size;
    build_channel(&b, 8, 0, 0);
    build_channel(&b, 12, 0, 0);
    build_channel(&b, 30, 0, 0);
    build_channel(&b, 10, 0, 0);
    build_channel(&b, -3, 0, 0);
    build_clip(&b, 1000, 1, WG_END_HOLD);
    build_shape(&b, &shape);
    build_field(&b, 3, 3, from, weights);
    build_field(&b, 4, 1, again, all);
    uint8_t *clip = build_finish(&b, &size);
    CHECK_EQ(wg_open(&file, clip, size), 0);
    CHECK_EQ(wg_open_skins(&file), 0);
    wg_fields_set(&file, values);
    /* 64/256 of 4000, 128/256 of -308 and 64/256 of 512, in 2^-10; then 2^-13 of that, down */
    CHECK_EQ(values[3], 1000 - 154 + 128);
    CHECK_EQ(values[4], 974 >> 13);
    values[0] = 1 << 29;
    values[1] = values[2] = 0;
    wg_fields_set(&file, values);
    CHECK_EQ(values[3], ((1 << 30) - 1) / 4);
    free(clip);
}

int main(void)
{
    TEST(rest_pose_is_exact_to_the_bit);
    TEST(joints_turn_and_move_as_the_model);
    TEST(turns_of_more_than_a_circle_are_the_rest_of_them);
    TEST(chains_of_twenty_bones_add_up);
    TEST(chains_of_quaternions_keep_their_length);
    TEST(children_sit_on_a_stretched_and_twisted_parent);
    TEST(following_bones_turn_by_the_mean);
    TEST(following_points_that_rest_turns_nothing);
    TEST(one_motion_of_all_bones_is_that_motion);
    TEST(motion_of_the_root_moves_everything_with_it);
    TEST(ranges_give_the_same_bits);
    TEST(camera_sees_what_is_there);
    TEST(brightness_is_the_weighted_mean_of_values);
    TEST(fields_are_weighted_means_in_order);
    return check_done();
}

/* What keys, mouse and time do to what wiggly view shows; the window itself is test_view.py's.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "check.h"
#include "clip_samples.h"
#include "viewer.h"

#include <string.h>

#define LOOP_US  2000000u /* clip 0 on layer 0, with an event at 1 s */
#define PONG_US  500000u  /* clip 1 on layer 1, which adds at half its weight */
#define SHORT_US 300000u  /* clip 2: the trigger starts it on layer 2 */

#define DEGREE 256 /* raw units */
#define SIZE   40000

static wg_file file;
static viewer view;

/* Channels 0 to 2: 10 x tick of clips 0 to 2. 3: yaw, 4: pitch, 6: size, 5: the view's rest. */
static uint8_t *open_viewer(void)
{
    static const uint16_t channel[WG_VIEW_CHANNELS] = {3, 4, 5, 5, 5, 5, 5, 6};
    uint32_t size;
    build b = {{{0}}, 1};
    bake_error error;
    for (int i = 0; i < 3; i++) {
        build_channel(&b, 0, 0, 0);
    }
    build_channel(&b, 8, WG_UNIT_DEGREE, 10 * DEGREE);
    build_channel(&b, 8, WG_UNIT_DEGREE, 0);
    build_channel(&b, 8, 0, 0);
    build_channel(&b, 8, 0, SIZE);
    build_clip(&b, 1000, 2000, WG_END_LOOP);
    sample_ramp(&b, 0, 2000, 20000);
    build_event(&b, 1000, 7);
    build_clip(&b, 1000, 500, WG_END_PINGPONG);
    sample_ramp(&b, 1, 500, 5000);
    build_clip(&b, 1000, 300, WG_END_HOLD);
    sample_ramp(&b, 2, 300, 3000);
    build_layer(&b, 0, WG_MODE_OVERRIDE, WG_NONE, 32768);
    build_layer(&b, 1, WG_MODE_ADD, WG_NONE, 16384);
    build_layer(&b, WG_NONE, WG_MODE_OVERRIDE, WG_NONE, 0);
    build_trigger(&b, 7, 2, 2, 0);
    build_view(&b, WG_PERSPECTIVE, WG_SHADING_FLAT, channel);
    uint8_t *clip = build_finish(&b, &size);
    CHECK_EQ(wg_open(&file, clip, size), 0);
    CHECK_EQ(viewer_init(&view, &file, NULL, &error), 0);
    return clip;
}

/* ---- time ------------------------------------------------------------------------------------ */

static void time_passes_at_the_speed_that_is_set(void)
{
    uint8_t *clip = open_viewer();
    viewer_advance(&view, 100000);
    CHECK_EQ(viewer_time(&view), 100000);
    CHECK_EQ(viewer_length(&view), LOOP_US);
    viewer_key(&view, '+');
    viewer_advance(&view, 100000);
    CHECK_EQ(viewer_time(&view), 300000);
    viewer_key(&view, '-');
    viewer_key(&view, '-');
    viewer_key(&view, '-');
    viewer_advance(&view, 100000);
    CHECK_EQ(viewer_time(&view), 325000);
    viewer_key(&view, ' ');
    viewer_advance(&view, 100000);
    CHECK_EQ(viewer_time(&view), 325000);
    viewer_key(&view, ' ');
    viewer_advance(&view, 4);
    CHECK_EQ(viewer_time(&view), 325001);
    free(clip);
}

/* A clock of 32 bits wraps after 71 minutes: in frames of 64 ms, 16 times as fast. */
static void a_long_evening_goes_unnoticed(void)
{
    uint8_t *clip = open_viewer();
    view.speed = VIEWER_SPEED_MOST;
    const uint32_t frames = 6000;
    for (uint32_t i = 0; i < frames; i++) {
        viewer_advance(&view, 64000);
    }
    CHECK((uint64_t)frames * 64000 * 16 > UINT32_MAX);
    CHECK_EQ(viewer_time(&view), (uint64_t)frames * 64000 * 16 % LOOP_US);
    free(clip);
}

static void seeking_goes_where_playing_would(void)
{
    static const uint32_t TIMES[] = {0, 123000, 499000, 500000, 777000, 999000, 1300000, 1999000};
    uint8_t *clip = open_viewer();
    for (size_t i = 0; i < sizeof TIMES / sizeof *TIMES; i++) {
        uint32_t t = TIMES[i], pong = t % (2 * PONG_US);
        viewer_seek(&view, t);
        CHECK(view.paused);
        viewer_advance(&view, 50000);
        CHECK_EQ(viewer_time(&view), t);
        CHECK_NEAR(view.values[0], t / 100.0, 1.5);
        pong = pong <= PONG_US ? pong : 2 * PONG_US - pong;
        CHECK_NEAR(view.values[1], 0.5 * pong / 100.0, 1.5);
    }
    viewer_seek(&view, 2 * LOOP_US + 70000);
    CHECK_EQ(viewer_time(&view), 70000);
    free(clip);
}

static void scrubbing_stays_on_the_bar(void)
{
    uint8_t *clip = open_viewer();
    viewer_scrub(&view, 0.25);
    CHECK_NEAR(viewer_time(&view), 500000, 1);
    viewer_scrub(&view, -3);
    CHECK_EQ(viewer_time(&view), 0);
    viewer_scrub(&view, 7);
    CHECK_EQ(viewer_time(&view), LOOP_US - 1);
    viewer_key(&view, VIEWER_LEFT);
    CHECK_EQ(viewer_time(&view), LOOP_US - 1 - VIEWER_STEP_US);
    viewer_key(&view, VIEWER_RIGHT);
    viewer_key(&view, VIEWER_RIGHT); /* beyond the end of a loop: its beginning */
    CHECK_EQ(viewer_time(&view), 0);
    viewer_key(&view, VIEWER_LEFT);
    CHECK_EQ(viewer_time(&view), 0);
    free(clip);
}

static void triggers_act_while_playing(void)
{
    uint8_t *clip = open_viewer();
    for (int i = 0; i <= 100; i++) { /* the event lies behind it after 51 */
        viewer_advance(&view, i ? 20000 : 0);
    }
    CHECK_NEAR(view.values[2], SHORT_US / 100.0, 1.5);
    free(clip);
}

/* ---- layers ---------------------------------------------------------------------------------- */

static void layers_fade_out_and_back_to_what_they_had(void)
{
    uint8_t *clip = open_viewer();
    viewer_advance(&view, 200000);
    CHECK_NEAR(view.values[1], 0.5 * 2000, 1.5);
    viewer_key(&view, '2');
    viewer_advance(&view, VIEWER_FADE_US / 2);
    CHECK_NEAR(view.values[1], 0.25 * 3250, 3); /* a fade is symmetric: a half of the weight */
    viewer_advance(&view, VIEWER_FADE_US / 2);
    CHECK_EQ(view.values[1], 0);
    viewer_key(&view, ' ');
    viewer_key(&view, '2'); /* at once: nothing would fade while paused */
    viewer_advance(&view, 1);
    /* 0.45 s forwards; weight 1/2 */
    CHECK_NEAR(view.values[1], 0.5 * 4500, 1.5);
    viewer_key(&view, '3'); /* weight 0 in the clip: 1 */
    CHECK_EQ(view.layers[2].fade_to, WG_WEIGHT_ONE);
    viewer_key(&view, '4'); /* there is none */
    free(clip);
}

static void tab_goes_round_the_clips(void)
{
    uint8_t *clip = open_viewer();
    for (int i = 1; i <= 6; i++) {
        viewer_key(&view, '\t');
        CHECK_EQ(view.layers[0].clip, i % 3);
    }
    viewer_key(&view, '1');
    CHECK_EQ(view.layers[0].fade_to, 0);
    viewer_key(&view, '\t'); /* and can be seen */
    CHECK_EQ(view.layers[0].fade_to, WG_WEIGHT_ONE);
    free(clip);
}

/* ---- mouse ----------------------------------------------------------------------------------- */

static void the_mouse_adds_to_the_view(void)
{
    uint8_t *clip = open_viewer();
    viewer_advance(&view, 0);
    CHECK_EQ(view.values[3], 10 * DEGREE);
    viewer_drag(&view, 31, -8);
    viewer_drag(&view, -1, 0);
    viewer_advance(&view, 0);
    CHECK_EQ(view.values[3], 10 * DEGREE - 15 * DEGREE);
    CHECK_EQ(view.values[4], -4 * DEGREE);
    CHECK_EQ(view.values[5], 0);
    viewer_wheel(&view, 3);
    viewer_advance(&view, 0);
    CHECK_NEAR(view.values[6], SIZE / 1.331, 0.5);
    viewer_wheel(&view, -1000); /* there is an end to it */
    viewer_wheel(&view, 1);
    viewer_advance(&view, 0);
    CHECK_NEAR(view.values[6], SIZE * 64 / 1.1, 0.5);
    free(clip);
}

/* A hostile clip may hold any rest; nothing may overflow. */
static void the_mouse_cannot_leave_the_numbers(void)
{
    uint8_t *clip = open_viewer();
    for (int i = 0; i < 100; i++) {
        viewer_drag(&view, -1000000, 1000000);
    }
    viewer_advance(&view, 0);
    CHECK_EQ(view.values[3], 1 << 29);
    CHECK_EQ(view.values[4], 1 << 29);
    free(clip);
}

/* ---- the title ------------------------------------------------------------------------------- */

static void the_title_says_where_it_is(void)
{
    char title[VIEWER_TITLE_BYTES];
    uint8_t *clip = open_viewer();
    view.name = "a.wgl";
    viewer_seek(&view, 1234567);
    viewer_title(&view, title); /* no names, no parts in this clip */
    CHECK_EQ(strcmp(title, "a.wgl |  | 1.235 / 2.000 s | speed 1 | layers 12 | paused"), 0);
    free(clip);
}

int main(void)
{
    TEST(time_passes_at_the_speed_that_is_set);
    TEST(a_long_evening_goes_unnoticed);
    TEST(seeking_goes_where_playing_would);
    TEST(scrubbing_stays_on_the_bar);
    TEST(triggers_act_while_playing);
    TEST(layers_fade_out_and_back_to_what_they_had);
    TEST(tab_goes_round_the_clips);
    TEST(the_mouse_adds_to_the_view);
    TEST(the_mouse_cannot_leave_the_numbers);
    TEST(the_title_says_where_it_is);
    return check_done();
}

/* Events: once each for any ticks and directions, in the order of play; triggers.
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "clip_samples.h"
#include "wiggly.h"

#define RATE   700u /* 10 ticks last 14285.714 us: the duration has a fraction */
#define TICKS  10u
#define EVENTS 6u

static const uint16_t AT[EVENTS] = {0, 0, 3, 7, 7, 9};

typedef struct {
    uint8_t *clip;
    wg_file file;
    wg_layer layer;
    wg_player player;
    int64_t duration;       /* us Q16 */
    int64_t passed[EVENTS]; /* us Q16: the head has passed event i when it is here or beyond */
} stage;

static uint32_t seed = 7;

static uint32_t rnd(uint32_t below)
{
    seed = seed * 1664525u + 1013904223u;
    return (uint32_t)(((uint64_t)seed * below) >> 32);
}

/* Event i has id i. Positions are those of whole microseconds (SPEC 6.2), so an event is behind the
 * head from the first microsecond on whose position is above its tick. */
static void stage_open(stage *s, uint8_t end)
{
    uint32_t size;
    build b = {{{0}}, 0};
    build_channel(&b, 0, 0, 0);
    build_clip(&b, RATE, TICKS, end);
    sample_ramp(&b, 0, TICKS, 100);
    for (uint16_t i = 0; i < EVENTS; i++) {
        build_event(&b, AT[i], i);
    }
    build_layer(&b, 0, 0, WG_NONE, 32768);
    s->clip = build_finish(&b, &size);
    CHECK_EQ(wg_open(&s->file, s->clip, size), 0);
    wg_player_init(&s->player, &s->file, &s->layer, 1);
    wg_player_update(&s->player, 0);
    s->duration = (int64_t)(((uint64_t)TICKS * 1000000u << 16) / RATE);
    for (unsigned i = 0; i < EVENTS; i++) {
        uint32_t us = 0;
        while (wg_clip_position(&s->file, 0, us) <= (uint32_t)AT[i] << 16) {
            us++;
        }
        s->passed[i] = (int64_t)us << 16;
    }
}

static int64_t floor_div(int64_t a, int64_t b)
{
    return a / b - (a % b < 0);
}

/* How often a head that has run to `head` on the endless axis has crossed c, c + period, ...: a
 * crossing is from below c to c or beyond. */
static int64_t crossings(int64_t head, int64_t c, int64_t period)
{
    return floor_div(head - c, period) + 1;
}

/* A closed form of what happens on the endless axis, where the head is the sum of all steps. */
typedef struct {
    int64_t head;
    int64_t count[EVENTS][2]; /* [1]: crossed while clip time decreases */
} model;

static int64_t magnitude(int64_t a)
{
    return a < 0 ? -a : a;
}

static void model_step(const stage *s, model *m, uint8_t end, int64_t step)
{
    int64_t to = m->head + step, d = s->duration;
    if (end == WG_END_HOLD) {
        to = to < 0 ? 0 : to > d ? d : to;
    } else { /* turns beyond WG_WRAPS_MAX are not reported */
        int64_t length = end == WG_END_PINGPONG ? 2 * d : d;
        int64_t turns = floor_div(to, length) - floor_div(m->head, length);
        int64_t beyond = magnitude(turns) - (int64_t)WG_WRAPS_MAX;
        if (beyond > 0) {
            to -= (turns < 0 ? -beyond : beyond) * length;
        }
    }
    for (unsigned i = 0; i < EVENTS; i++) {
        int64_t c = s->passed[i], period = end == WG_END_PINGPONG ? 2 * d : d;
        if (end == WG_END_HOLD) {
            m->count[i][0] = m->head < c && to >= c;
            m->count[i][1] = m->head >= c && to < c;
            continue;
        }
        int64_t n = magnitude(crossings(to, c, period) - crossings(m->head, c, period));
        m->count[i][step < 0] = n;
        m->count[i][step >= 0] = 0;
        if (end == WG_END_PINGPONG) {
            /* the way back: clip time 2D - head falls below c when the head exceeds 2D - c */
            int64_t e = 2 * d - c + 1;
            n = magnitude(crossings(to, e, period) - crossings(m->head, e, period));
            m->count[i][step >= 0] = n;
        }
    }
    m->head = to;
}

/* Takes all events; returns how many. */
static uint32_t take_all(stage *s, int64_t count[EVENTS][2])
{
    wg_event e = {0, 9, 9};
    uint32_t taken = 0;
    memset(count, 0, EVENTS * sizeof *count);
    while (taken < 1000000 && wg_player_event(&s->player, &e)) {
        CHECK(e.id < EVENTS && e.backwards < 2 && e.layer == 0);
        count[e.id][e.backwards]++;
        taken++;
    }
    CHECK(!wg_player_event(&s->player, &e));
    return taken;
}

static const int32_t SPEEDS[] = {65536, -65536, 20000, -99999, 1, -1, 0, 3000000, -3000000};

static void play_randomly(uint8_t end, uint32_t tick_us, unsigned ticks)
{
    stage s;
    model m = {0, {{0}}};
    int64_t got[EVENTS][2];
    stage_open(&s, end);
    for (unsigned i = 0; i < ticks; i++) {
        int32_t speed = SPEEDS[rnd(9)];
        uint32_t dt = rnd(8) ? rnd(tick_us) : 0;
        wg_player_speed(&s.player, 0, speed);
        wg_player_update(&s.player, s.player.now_us + dt);
        model_step(&s, &m, end, (int64_t)dt * speed);
        take_all(&s, got);
        CHECK(memcmp(got, m.count, sizeof got) == 0);
        if (!check_ok) {
            printf("policy %u, tick %u\n", end, i);
            break;
        }
    }
    free(s.clip);
}

static void each_event_once_for_random_ticks_and_directions(void)
{
    for (uint8_t end = 0; end < 3; end++) {
        play_randomly(end, 10, 20000);
        play_randomly(end, 3000, 20000);
        play_randomly(end, 20000, 5000);
        play_randomly(end, 200000, 500);
    }
}

/* Steps of whole ticks and durations: heads land on events and ends exactly. */
static void each_event_once_when_ticks_land_on_it(void)
{
    for (uint8_t end = 0; end < 3; end++) {
        stage s;
        model m = {0, {{0}}};
        int64_t got[EVENTS][2];
        stage_open(&s, end);
        for (unsigned i = 0; i < 20000; i++) {
            int64_t goal = rnd(3) ? s.passed[rnd(EVENTS)] : s.duration * rnd(2);
            int64_t lap = s.duration * rnd(4), axis = (int64_t)s.layer.head;
            int64_t step = (rnd(2) ? goal + lap : -goal - lap) - (rnd(2) ? axis : 0);
            step = (step + (int64_t)rnd(3) - 1) % 0x7fffffff;
            wg_player_speed(&s.player, 0, (int32_t)step); /* a tick of 1 us moves it by `step` */
            wg_player_update(&s.player, s.player.now_us + 1);
            model_step(&s, &m, end, step);
            take_all(&s, got);
            CHECK(memcmp(got, m.count, sizeof got) == 0);
            if (!check_ok) {
                printf("policy %u, step %u\n", end, i);
                break;
            }
        }
        free(s.clip);
    }
}

typedef struct {
    uint16_t id;
    uint8_t backwards;
} mark;

/* Plays `stop` us in ticks of `tick` us from `start` us; returns the number of events in `log`. */
static unsigned log_events(uint8_t end, int32_t speed, uint32_t tick, mark *log)
{
    stage s;
    wg_event e;
    unsigned count = 0;
    stage_open(&s, end);
    wg_player_seek(&s.player, 0, 5000);
    wg_player_speed(&s.player, 0, speed);
    for (uint32_t now = tick; now <= 120000; now += tick) {
        wg_player_update(&s.player, now);
        while (wg_player_event(&s.player, &e) && count < 400) {
            log[count].id = e.id;
            log[count].backwards = e.backwards;
            count++;
        }
    }
    free(s.clip);
    return count;
}

/* With ticks of 1 us the order is that of time; larger ticks must give the same list. */
static void order_of_play_does_not_depend_on_ticks(void)
{
    static const uint32_t TICK[] = {2, 100, 3000, 15000, 60000, 120000};
    static const int32_t SPEED[] = {65536, -65536, 131072, -131072};
    static mark fine[400], coarse[400];
    for (uint8_t end = 0; end < 3; end++) {
        for (unsigned k = 0; k < 4; k++) {
            unsigned want = log_events(end, SPEED[k], 1, fine);
            CHECK(want >= (end == WG_END_HOLD ? 3 : 40));
            for (unsigned i = 0; i < 6; i++) {
                CHECK_EQ(log_events(end, SPEED[k], TICK[i], coarse), want);
                for (unsigned n = 0; n < want; n++) {
                    CHECK_EQ(coarse[n].id, fine[n].id);
                    CHECK_EQ(coarse[n].backwards, fine[n].backwards);
                }
            }
        }
    }
}

static void check_list(stage *s, uint32_t now, const char *want)
{
    char got[64] = "";
    wg_event e;
    size_t n = 0;
    wg_player_update(&s->player, now);
    while (n < 60 && wg_player_event(&s->player, &e)) {
        got[n++] = (char)('0' + e.id);
        if (e.backwards) {
            got[n++] = '-';
        }
    }
    got[n] = 0;
    if (strcmp(got, want) != 0) {
        printf("at %lu: events %s, not %s\n", (unsigned long)now, got, want);
    }
    CHECK(strcmp(got, want) == 0);
}

static void lists_by_hand(void)
{
    stage s;
    stage_open(&s, WG_END_PINGPONG);
    check_list(&s, 0, "");
    check_list(&s, 1, "01");
    check_list(&s, 4000, "");
    check_list(&s, 14000, "2345");
    check_list(&s, 14500, ""); /* turned at 14285.7; event 5 is at 12857.1 */
    check_list(&s, 16000, "5-");
    check_list(&s, 28571, "4-3-2-1-0-"); /* 0.4 us before the start: its position is 0 */
    check_list(&s, 28572, "");
    check_list(&s, 28573, "01");
    check_list(&s, 28571 * 2 + 1, "23455-4-3-2-1-0-");
    free(s.clip);
    stage_open(&s, WG_END_LOOP);
    check_list(&s, 20000, "012345012");
    check_list(&s, 20000, "");
    check_list(&s, 60000, "34501234501234501");
    free(s.clip);
}

static void no_event_after_seek_or_play(void)
{
    stage s;
    for (uint8_t end = 0; end < 3; end++) {
        for (int backwards = 0; backwards < 2; backwards++) {
            stage_open(&s, end);
            wg_player_speed(&s.player, 0, backwards ? -65536 : 65536);
            wg_player_seek(&s.player, 0, 9000);
            check_list(&s, 0, "");
            wg_player_update(&s.player, 60000);
            wg_player_seek(&s.player, 0, 14285);
            check_list(&s, 60000, "");
            wg_player_update(&s.player, 120000);
            wg_player_play(&s.player, 0, 0);
            wg_event e;
            CHECK(!wg_player_event(&s.player, &e));
            check_list(&s, 120000, "");
            free(s.clip);
        }
    }
}

static void paused_and_silent_layers_report_nothing(void)
{
    stage s;
    stage_open(&s, WG_END_LOOP);
    wg_player_pause(&s.player, 0, true);
    check_list(&s, 50000, "");
    wg_player_play(&s.player, 0, WG_NONE);
    check_list(&s, 100000, "");
    free(s.clip);
}

static void unread_events_are_lost_with_the_next_update(void)
{
    stage s;
    stage_open(&s, WG_END_LOOP);
    wg_player_update(&s.player, 5000);
    check_list(&s, 11000, "34");
    wg_player_update(&s.player, 50000); /* three loops later, 7142.9 us into the clip */
    check_list(&s, 51000, "");
    check_list(&s, 54000, "34");
    free(s.clip);
}

static void held_end_reports_nothing_again(void)
{
    stage s;
    stage_open(&s, WG_END_HOLD);
    check_list(&s, 20000, "012345");
    check_list(&s, 30000, "");
    wg_player_speed(&s.player, 0, -65536);
    check_list(&s, 31000, "");
    check_list(&s, 32000, "5-");
    check_list(&s, 60000, "4-3-2-1-0-");
    check_list(&s, 70000, "");
    free(s.clip);
}

/* Its mul is too small to reach the last ticks: a reader need not judge that, but playing must stay
 * sane: at the held end, every event once and then no more. */
static void events_beyond_the_last_position_come_once(void)
{
    stage s;
    for (int backwards = 0; backwards < 2; backwards++) {
        stage_open(&s, WG_END_HOLD);
        uint32_t size = build_get(s.clip + WG_HEADER_LENGTH, 4);
        build_put(s.clip + build_where(s.clip, WG_SECTION_CLIPS, 0), 4, 1);
        build_seal(s.clip, size);
        CHECK_EQ(wg_open(&s.file, s.clip, size), 0);
        check_list(&s, 20000, "012345");
        wg_player_speed(&s.player, 0, backwards ? -65536 : 65536);
        check_list(&s, 20000, "");
        wg_player_pause(&s.player, 0, true);
        check_list(&s, 20001, "");
        free(s.clip);
    }
}

/* ---- triggers -------------------------------------------------------------------------------- */

static void triggers_start_a_layer_when_their_event_is_taken(void)
{
    uint32_t size;
    build b = {{{0}}, 0};
    wg_file file;
    wg_layer layers[3];
    wg_player player;
    wg_event e;
    int32_t values[2];
    build_channel(&b, 0, 0, 0);
    build_channel(&b, 0, 0, 0);
    build_clip(&b, 1000, 100, WG_END_LOOP);
    build_event(&b, 10, 42);
    build_event(&b, 20, 43);
    build_clip(&b, 1000, 50, WG_END_HOLD);
    sample_level(&b, 1, 50, 8000);
    build_layer(&b, 0, WG_MODE_OVERRIDE, WG_NONE, 32768);
    build_layer(&b, WG_NONE, WG_MODE_OVERRIDE, WG_NONE, 5);
    build_layer(&b, WG_NONE, WG_MODE_OVERRIDE, WG_NONE, 5);
    build_trigger(&b, 42, 1, 1, 4);
    build_trigger(&b, 43, 2, 1, 0); /* a layer that a player with two does not have */
    uint8_t *clip = build_finish(&b, &size);
    CHECK_EQ(wg_open(&file, clip, size), 0);
    wg_player_init(&player, &file, layers, 2);
    wg_player_update(&player, 0);
    wg_player_update(&player, 15000);
    CHECK_EQ(layers[1].clip, WG_NONE); /* not yet taken */
    CHECK_EQ(wg_player_event(&player, &e), 1);
    CHECK_EQ(e.id, 42);
    CHECK_EQ(layers[1].clip, 1);
    wg_player_sample(&player, values);
    CHECK_EQ(values[1], 0);
    wg_player_update(&player, 17000);
    wg_player_sample(&player, values);
    CHECK_NEAR(values[1], 4000, 2); /* half of its 4 ms ramp */
    wg_player_update(&player, 19000);
    wg_player_sample(&player, values);
    CHECK_EQ(values[1], 8000);
    CHECK_EQ(wg_player_time(&player, 1), 4000);
    wg_player_update(&player, 25000);
    CHECK_EQ(wg_player_event(&player, &e), 1);
    CHECK_EQ(e.id, 43);
    CHECK_EQ(wg_player_event(&player, &e), 0);
    free(clip);
}

/* A layer that shows something goes on from the weight it has: dropping it would be a jump. */
static void trigger_ramps_from_the_present_weight(void)
{
    uint32_t size;
    build b = {{{0}}, 0};
    wg_file file;
    wg_layer layers[2];
    wg_player player;
    wg_event e;
    int32_t value;
    build_channel(&b, 0, 0, 0);
    build_clip(&b, 1000, 100, WG_END_LOOP);
    build_event(&b, 10, 42);
    build_clip(&b, 1000, 50, WG_END_HOLD);
    sample_level(&b, 0, 50, 8000);
    build_layer(&b, 0, WG_MODE_OVERRIDE, WG_NONE, 32768);
    build_layer(&b, 1, WG_MODE_OVERRIDE, WG_NONE, 16384);
    build_trigger(&b, 42, 1, 1, 4);
    uint8_t *clip = build_finish(&b, &size);
    CHECK_EQ(wg_open(&file, clip, size), 0);
    wg_player_init(&player, &file, layers, 2);
    wg_player_update(&player, 0);
    wg_player_update(&player, 15000);
    CHECK_EQ(wg_player_event(&player, &e), 1);
    CHECK_EQ(wg_player_time(&player, 1), 0);
    wg_player_sample(&player, &value);
    CHECK_EQ(value, 4000);
    wg_player_update(&player, 17000);
    wg_player_sample(&player, &value);
    CHECK_NEAR(value, 6000, 2); /* half of the way from 1/2 to 1 */
    wg_player_update(&player, 19000);
    wg_player_sample(&player, &value);
    CHECK_EQ(value, 8000);
    free(clip);
}

/* A trigger that restarts the layer its own event is on ends that layer's pending events. */
static void self_trigger_does_not_spin(void)
{
    uint32_t size;
    build b = {{{0}}, 0};
    wg_file file;
    wg_layer layer;
    wg_player player;
    wg_event e;
    build_channel(&b, 0, 0, 0);
    build_clip(&b, 1000, 100, WG_END_LOOP);
    build_event(&b, 0, 1);
    build_event(&b, 50, 2);
    build_layer(&b, 0, WG_MODE_OVERRIDE, WG_NONE, 32768);
    build_trigger(&b, 1, 0, 0, 0);
    uint8_t *clip = build_finish(&b, &size);
    CHECK_EQ(wg_open(&file, clip, size), 0);
    wg_player_init(&player, &file, &layer, 1);
    wg_player_update(&player, 0);
    wg_player_update(&player, 70000);
    CHECK_EQ(wg_player_event(&player, &e), 1);
    CHECK_EQ(e.id, 1);
    CHECK_EQ(wg_player_event(&player, &e), 0);
    free(clip);
}

int main(void)
{
    TEST(each_event_once_for_random_ticks_and_directions);
    TEST(each_event_once_when_ticks_land_on_it);
    TEST(order_of_play_does_not_depend_on_ticks);
    TEST(lists_by_hand);
    TEST(no_event_after_seek_or_play);
    TEST(paused_and_silent_layers_report_nothing);
    TEST(unread_events_are_lost_with_the_next_update);
    TEST(held_end_reports_nothing_again);
    TEST(events_beyond_the_last_position_come_once);
    TEST(triggers_start_a_layer_when_their_event_is_taken);
    TEST(trigger_ramps_from_the_present_weight);
    TEST(self_trigger_does_not_spin);
    return check_done();
}

/* The displays' bytes against sequences that the makers of chips, glass and boards publish, and
 * inside their bounds for every rectangle. tests/test_display_emulation.py has panels that take them.
 * SPDX-License-Identifier: MIT */
#include "check.h"
#include "mipi_dcs.h"
#include "sharp.h"
#include "ssd0323.h"
#include "ssd1306.h"

#include <stdlib.h>
#include <string.h>

static const wg_ssd1306 glass_64 = WG_SSD1306_128X64, glass_32 = WG_SSD1306_128X32;
static const wg_dcs st7789 = WG_ST7789_240X240, st7789_135 = WG_ST7789_135X240;
static const wg_dcs ili9341 = WG_ILI9341_240X320;

typedef enum { OLED_64, OLED_32, OLED_16, OLED_GREY, DCS_ST7789, DCS_ILI9341, CHIPS } chip;

static wg_step setup(chip which, uint8_t index)
{
    switch (which) {
    case OLED_64:
        return wg_ssd1306_setup(&glass_64, index);
    case OLED_32:
        return wg_ssd1306_setup(&glass_32, index);
    case OLED_16:
        return wg_ssd0303_setup(index);
    case OLED_GREY:
        return wg_ssd0323_setup(index);
    case DCS_ST7789:
        return wg_dcs_setup(&st7789, index);
    default:
        return wg_dcs_setup(&ili9341, index);
    }
}

/* The step that begins with `command`; count 0 if there is none, or a failed check if two. */
static wg_step step_of(chip which, uint8_t command)
{
    wg_step found = {0, 0, {0}}, step;
    for (uint8_t i = 0; (step = setup(which, i)).count > 0; i++) {
        if (step.bytes[0] == command) {
            CHECK_EQ(found.count, 0);
            found = step;
        }
    }
    return found;
}

/* `published`: a byte count before every command, as the sources have it, 0 at the end. */
static void check_published(chip which, const uint8_t *published)
{
    int commands = 0, steps = 0;
    for (const uint8_t *p = published; *p; p += *p + 1, commands++) {
        wg_step step = step_of(which, p[1]);
        CHECK_EQ(step.count, *p);
        CHECK(memcmp(step.bytes, p + 1, *p) == 0);
        if (!check_ok) {
            printf("command %02x\n", p[1]);
            return;
        }
    }
    while (setup(which, (uint8_t)steps).count > 0) {
        steps++;
    }
    CHECK_EQ(steps, commands);
}

/* SSD1306 data sheet, application note figure 2 (A8, D3, 40, A4, A6, D5, 8D, AF), with the settings
 * of 128 x 64 modules: connector on top (A1, C8), rows wired alternately (DA 12), and precharge,
 * deselect level and contrast for the charge pump, as u8g2 and Adafruit_SSD1306 send them. */
static void ssd1306_setup_is_the_published_one(void)
{
    static const uint8_t published[] = {
        1,    0xae, 2,    0xd5, 0x80, 2,    0xa8, 0x3f, 2,    0xd3, 0x00, 1, 0x40, 2,    0x8d,
        0x14, 2,    0x20, 0x02, 1,    0xa1, 1,    0xc8, 2,    0xda, 0x12, 2, 0x81, 0xcf, 2,
        0xd9, 0xf1, 2,    0xdb, 0x40, 1,    0x2e, 1,    0xa4, 1,    0xa6, 1, 0xaf, 0};
    check_published(OLED_64, published);
    CHECK_EQ(step_of(OLED_32, 0xa8).bytes[1], 31);
    CHECK_EQ(step_of(OLED_32, 0xda).bytes[1], 0x02);
    CHECK_EQ(step_of(OLED_32, 0x81).bytes[1], 0x8f);
}

/* Luminary's driver of the 96 x 16 glass of the LM3S811 evaluation board, without its no-operations
 * (E3) and without addresses. */
static void ssd0303_setup_is_the_published_one(void)
{
    static const uint8_t published[] = {
        1,    0xae, 2,    0x81, 0x2b, 1, 0xa1, 1,    0x40, 2,    0xd3, 0x00, 2,    0xa8,
        0x0f, 1,    0xa4, 1,    0xa6, 1, 0xc8, 2,    0xd5, 0x72, 2,    0xd8, 0x00, 2,
        0xd9, 0x22, 2,    0xda, 0x12, 2, 0xdb, 0x0f, 2,    0xad, 0x8b, 1,    0xaf, 0};
    check_published(OLED_16, published);
}

/* OSRAM AN018, as Luminary's driver of the LM3S6965 evaluation board has it, without addresses and
 * switched off first. */
static void ssd0323_setup_is_the_published_one(void)
{
    static const uint8_t published[] = {
        1,    0xae, 2,    0x81, 50,   1,    0x85, 2,    0xa0, 0x52, 2,    0xa1, 0,    2,
        0xa2, 0x4c, 1,    0xa4, 2,    0xa8, 63,   2,    0xb1, 0x22, 2,    0xb2, 70,   2,
        0xb3, 0xf1, 2,    0xbf, 0x0d, 2,    0xbe, 0x02, 2,    0xbc, 0x10, 9,    0xb8, 0x01,
        0x11, 0x22, 0x32, 0x43, 0x54, 0x65, 0x76, 2,    0xad, 0x03, 1,    0xaf, 0};
    check_published(OLED_GREY, published);
}

/* ST7789V data sheet 9.1: 01, 11, 3A 55 (16 bits), 36, 21 for IPS glass, 13, 29. */
static void dcs_setup_is_the_published_one(void)
{
    static const uint8_t published[] = {1, 0x01, 1,    0x11, 2,    0x3a, 0x55, 2, 0x36,
                                        0, 1,    0x21, 1,    0x13, 1,    0x29, 0};
    check_published(DCS_ST7789, published);
    CHECK_EQ(step_of(DCS_ILI9341, 0x36).bytes[1], 0x48); /* Adafruit_ILI9341: MX | BGR */
    CHECK_EQ(step_of(DCS_ILI9341, 0x20).count, 1);
    for (chip which = DCS_ST7789; which <= DCS_ILI9341; which++) {
        CHECK_EQ(setup(which, 0).bytes[0], 0x01);
        CHECK(setup(which, 0).wait_ms >= 120); /* before 11, of a chip that was awake */
        CHECK_EQ(setup(which, 1).bytes[0], 0x11);
        CHECK(setup(which, 1).wait_ms >= 5);
    }
}

static void oleds_go_off_first_and_on_last(void)
{
    for (chip which = OLED_64; which <= OLED_GREY; which++) {
        uint8_t last = 0;
        while (setup(which, (uint8_t)(last + 1u)).count > 0) {
            last++;
        }
        CHECK_EQ(setup(which, 0).bytes[0], 0xae);
        CHECK_EQ(setup(which, last).bytes[0], 0xaf);
    }
}

static void steps_end_and_stay_inside_their_bytes(void)
{
    for (chip which = OLED_64; which < CHIPS; which++) {
        bool ended = false;
        for (uint16_t i = 0; i < 256; i++) {
            wg_step step = setup(which, (uint8_t)i);
            CHECK(step.count <= WG_STEP_BYTES);
            CHECK(!(ended && step.count));
            ended = step.count == 0;
        }
        CHECK(ended);
    }
}

/* Luminary's OSRAMClear writes 80 B0 80 04 80 12 40 before the pixels of page 0 and 80 B1 .. before
 * those of page 1: column 36. */
static void ssd0303_page_goes_out_as_published(void)
{
    static const uint8_t want[] = {0x80, 0xb1, 0x80, 0x04, 0x80, 0x12};
    const wg_rect page = {0, 8, 96, 16};
    uint8_t out[WG_SSD1306_I2C_BYTES];
    wg_step window = wg_ssd1306_window(page, WG_SSD0303_COLUMN);
    CHECK_EQ(wg_ssd1306_i2c(&window, out), sizeof want);
    CHECK(memcmp(out, want, sizeof want) == 0);
    CHECK_EQ(WG_SSD1306_DATA, 0x40);
}

/* SSD1306 10.1.1 to 10.1.3: B0h + page, 00h + the column's lower half, 10h + its upper half. */
static void ssd1306_windows_name_every_page_and_column(void)
{
    for (uint16_t y = 0; y < 64; y = (uint16_t)(y + 8)) {
        for (uint16_t x = 0; x < 128; x++) {
            const wg_rect page = {x, y, 128, (uint16_t)(y + 8)};
            wg_step step = wg_ssd1306_window(page, WG_SSD1306_COLUMN);
            CHECK_EQ(step.count, 3);
            CHECK_EQ(step.bytes[0], 0xb0 + y / 8);
            CHECK_EQ(step.bytes[1], x % 16);
            CHECK_EQ(step.bytes[2], 0x10 + x / 16);
        }
    }
}

/* SSD0323: 15h and 75h with first and last, columns being pairs of pixels. */
static void ssd0323_window_of_the_whole_glass_is_the_published_one(void)
{
    static const uint8_t want[] = {0x15, 0, 63, 0x75, 0, 63};
    const wg_rect all = {0, 0, 128, 64}, corner = {126, 63, 128, 64};
    wg_step step = wg_ssd0323_window(all);
    CHECK_EQ(step.count, sizeof want);
    CHECK(memcmp(step.bytes, want, sizeof want) == 0);
    step = wg_ssd0323_window(corner);
    CHECK_EQ(step.bytes[1], 63);
    CHECK_EQ(step.bytes[2], 63);
    CHECK_EQ(step.bytes[4], 63);
    CHECK_EQ(step.bytes[5], 63);
}

/* ST7789V 9.1.20 to 9.1.22: first and last as words, high byte first. */
static void dcs_windows_are_words_and_begin_at_the_glass(void)
{
    static const uint8_t columns[] = {0x2a, 0, 52, 0, 186}, rows[] = {0x2b, 0, 40, 1, 23};
    const wg_rect all = {0, 0, 135, 240};
    CHECK(memcmp(wg_dcs_window(&st7789_135, all, 0).bytes, columns, 5) == 0);
    CHECK_EQ(wg_dcs_window(&st7789_135, all, 0).count, 5);
    CHECK(memcmp(wg_dcs_window(&st7789_135, all, 1).bytes, rows, 5) == 0); /* 40 + 239 = 0117h */
    CHECK_EQ(wg_dcs_window(&st7789_135, all, 1).count, 5);
    CHECK_EQ(wg_dcs_window(&st7789_135, all, 2).bytes[0], 0x2c);
    CHECK_EQ(wg_dcs_window(&st7789_135, all, 2).count, 1);
    CHECK_EQ(wg_dcs_window(&st7789_135, all, 3).count, 0);
}

/* "0" and "1" in the order in which they go out, spaces ignored, into bytes. */
static int bits(const char *text, uint8_t *out)
{
    int count = 0;
    for (; *text; text++) {
        if (*text != ' ') {
            out[count / 8] = (uint8_t)(out[count / 8] << 1 | (*text == '1'));
            count++;
        }
    }
    return count / 8;
}

/* Application note, "Write Multiple Lines", first, intermediate and last line; lines 1 and 6 count
 * from 1 and go out with the lowest bit first. 16 pixels a line. */
static void sharp_lines_are_the_figures_of_the_application_note(void)
{
    static const char *const figure = "1 1 0 0 0 0 0 0  1 0 1 0 0 0 0 0  1010101111001101 00000000"
                                      "                 0 1 1 0 0 0 0 0  0001001000110100 00000000"
                                      "                                                   00000000";
    uint8_t want[16] = {0}, out[4 + WG_SHARP_BYTES(2)] = {0xab, 0xcd, 0x12, 0x34};
    const wg_rect lines = {0, 4, 16, 6};
    int count = bits(figure, want);
    CHECK_EQ(wg_sharp_lines(lines, 1, out), count);
    CHECK_EQ(count, sizeof out);
    CHECK(memcmp(out, want, sizeof out) == 0);
}

/* The same, "Change VCOM" and "Clear Screen". */
static void sharp_commands_are_the_figures_of_the_application_note(void)
{
    static const char *const figures[2][2] = {{"00000000 00000000", "01000000 00000000"},
                                              {"00100000 00000000", "01100000 00000000"}};
    for (uint8_t vcom = 0; vcom < 2; vcom++) {
        uint8_t want[2] = {0};
        CHECK_EQ(bits(figures[0][vcom], want), wg_sharp_vcom(vcom).count);
        CHECK(memcmp(wg_sharp_vcom(vcom).bytes, want, 2) == 0);
        CHECK_EQ(bits(figures[1][vcom], want), wg_sharp_clear(vcom).count);
        CHECK(memcmp(wg_sharp_clear(vcom).bytes, want, 2) == 0);
    }
    CHECK(WG_SHARP_VCOM_MS >= 50 && WG_SHARP_VCOM_MS <= 1000); /* 0.5 to 10 Hz, two changes each */
}

/* In place, in a buffer of exactly the size: nothing behind it is touched, no line is lost. */
static void sharp_lines_spread_in_place(void)
{
    for (uint16_t width = 8; width <= 400; width = (uint16_t)(width + 56)) {
        for (uint16_t count = 1; count <= 9; count++) {
            const wg_rect rect = {0, 200, width, (uint16_t)(200 + count)};
            size_t packed = (size_t)width / 8 * count, all = packed + WG_SHARP_BYTES(count);
            uint8_t *out = malloc(all);
            for (size_t i = 0; i < packed; i++) {
                out[i] = (uint8_t)(i * 37 + 11);
            }
            CHECK_EQ(wg_sharp_lines(rect, 0, out), all);
            for (size_t i = 0; i < packed; i++) {
                size_t line = i / (width / 8), column = i % (width / 8);
                CHECK_EQ(out[2 + line * (width / 8u + 2u) + column], (uint8_t)(i * 37 + 11));
            }
            free(out);
        }
    }
}

int main(void)
{
    TEST(ssd1306_setup_is_the_published_one);
    TEST(ssd0303_setup_is_the_published_one);
    TEST(ssd0323_setup_is_the_published_one);
    TEST(dcs_setup_is_the_published_one);
    TEST(oleds_go_off_first_and_on_last);
    TEST(steps_end_and_stay_inside_their_bytes);
    TEST(ssd0303_page_goes_out_as_published);
    TEST(ssd1306_windows_name_every_page_and_column);
    TEST(ssd0323_window_of_the_whole_glass_is_the_published_one);
    TEST(dcs_windows_are_words_and_begin_at_the_glass);
    TEST(sharp_lines_are_the_figures_of_the_application_note);
    TEST(sharp_commands_are_the_figures_of_the_application_note);
    TEST(sharp_lines_spread_in_place);
    return check_done();
}

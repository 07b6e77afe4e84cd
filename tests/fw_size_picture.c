/* Footprint image of a character on a display: player, mixing, shapes, raster and grey pixels, and the
 * RAM of 1,000 vertices, 32 bases, 48 channels and 2 layers beside the band. With SIZE_SKINS=1: skins,
 * fields and paints too, and 20 bones. Linked, never run.
 * SPDX-License-Identifier: MIT */
#include "picture_skin.h"
#include "pixels.h"

/* The certificate's figure for pictures has it (host-bake/certify_shapes_print.c). */
typedef char size_of_wg_picture[sizeof(wg_picture) == 232 ? 1 : -1];

#ifndef SIZE_SKINS
#define SIZE_SKINS 0
#endif

#define VERTICES 1000
#define BASES    32
#define CHANNELS 48
#define LAYERS   2
#define WIDTH    128
#define HEIGHT   64
#define ROWS     4
#define BONES    20

struct {
    wg_file file;
    wg_layer layers[LAYERS];
    wg_player player;
    int32_t values[CHANNELS];
    wg_picture picture;
    wg_vertex vertices[VERTICES];
    uint8_t shades[VERTICES];
    int16_t weights[BASES];
} size_ram;
uint32_t size_band[WIDTH * ROWS];
struct {
    wg_picture_skins skins;
    wg_bone bones[BONES];
} size_skins;

extern const uint32_t clip_words[];
extern volatile uint32_t clock_us;
extern volatile int bus;
void _start(void);

/* One frame's values and vertices. */
static void set(void)
{
    wg_player_sample(&size_ram.player, size_ram.values);
    if (SIZE_SKINS) {
        wg_fields_set(&size_ram.file, size_ram.values);
        wg_picture_set_skinned(&size_ram.picture, size_ram.values);
    } else {
        wg_picture_set(&size_ram.picture, size_ram.values);
    }
}

static void draw(wg_rect rect)
{
    wg_picture_band(&size_ram.picture, rect, size_band);
    bus = (int)wg_pixels_grey4(&size_ram.picture, rect, size_band, (uint8_t *)size_band);
}

void _start(void)
{
    const wg_size size = {WIDTH, HEIGHT}, align = {2, 1};
    const wg_picture_memory memory = {size_ram.vertices, size_ram.shades, 0, size_ram.weights};
    wg_event event;
    if (wg_open(&size_ram.file, clip_words, 65536) < 0 || wg_open_shapes(&size_ram.file) < 0 ||
        (SIZE_SKINS && wg_open_skins(&size_ram.file) < 0)) {
        return;
    }
    wg_player_init(&size_ram.player, &size_ram.file, size_ram.layers, LAYERS);
    wg_player_crossfade(&size_ram.player, 0, 1, 1000);
    wg_picture_init(&size_ram.picture, &size_ram.file, size, &memory);
    if (SIZE_SKINS) {
        size_skins.skins.bones = size_skins.bones;
        wg_picture_paint(&size_ram.picture, &size_skins.skins);
    }
    for (;;) {
        wg_player_update(&size_ram.player, clock_us);
        while (wg_player_event(&size_ram.player, &event)) {
            bus = event.id;
        }
        set();
        draw(wg_picture_dirty(&size_ram.picture, align));
    }
}

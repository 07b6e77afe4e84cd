/* The window of wiggly view.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "viewer_window.h"

#include <SDL2/SDL.h>
#include <stdio.h>
#include <string.h>

#define FRAME_MS 16 /* 60 frames a second, where the machine can */

typedef struct {
    SDL_Window *window;
    image contents;
    painter paint;
    char title[VIEWER_TITLE_BYTES];
    int turning, scrubbing; /* what the held button does */
} screen;

/* ---- input ----------------------------------------------------------------------------------- */

/* Keys that make no character; the others come as text, whatever the keyboard's layout. */
static int key_of(SDL_Keycode code)
{
    switch (code) {
    case SDLK_LEFT:
        return VIEWER_LEFT;
    case SDLK_RIGHT:
        return VIEWER_RIGHT;
    case SDLK_TAB:
        return '\t';
    case SDLK_ESCAPE:
        return VIEWER_ESCAPE;
    default:
        return 0;
    }
}

static void press(screen *s, viewer *v, const SDL_MouseButtonEvent *button)
{
    s->scrubbing = viewer_on_bar(&s->contents, button->y);
    s->turning = !s->scrubbing;
    if (s->scrubbing) {
        viewer_scrub(v, viewer_bar_fraction(&s->contents, button->x));
    }
}

static void move(screen *s, viewer *v, const SDL_MouseMotionEvent *motion)
{
    if (s->turning) {
        viewer_drag(v, motion->xrel, motion->yrel);
    } else if (s->scrubbing) {
        viewer_scrub(v, viewer_bar_fraction(&s->contents, motion->x));
    }
}

static void react(screen *s, viewer *v, const SDL_Event *event)
{
    switch (event->type) {
    case SDL_QUIT:
        v->quit = 1;
        break;
    case SDL_TEXTINPUT:
        viewer_key(v, (unsigned char)event->text.text[0]);
        break;
    case SDL_KEYDOWN:
        viewer_key(v, key_of(event->key.keysym.sym));
        break;
    case SDL_MOUSEBUTTONDOWN:
        press(s, v, &event->button);
        break;
    case SDL_MOUSEBUTTONUP:
        s->turning = s->scrubbing = 0;
        break;
    case SDL_MOUSEMOTION:
        move(s, v, &event->motion);
        break;
    case SDL_MOUSEWHEEL:
        viewer_wheel(v, event->wheel.y);
        break;
    default:
        break;
    }
}

/* ---- output ---------------------------------------------------------------------------------- */

static SDL_Surface *as_surface(image *m)
{
    return SDL_CreateRGBSurfaceWithFormatFrom(m->rgb, m->width, m->height, 24, 3 * m->width,
                                              SDL_PIXELFORMAT_RGB24);
}

static int fail_sdl(bake_error *error, const char *what)
{
    return bake_fail(error, "%s: %s", what, SDL_GetError());
}

static int draw(screen *s, const viewer *v, bake_error *error)
{
    SDL_Surface *glass = SDL_GetWindowSurface(s->window);
    if (glass == NULL) {
        return fail_sdl(error, "the window cannot be drawn on");
    }
    if (s->contents.width != glass->w || s->contents.height != glass->h) {
        image_free(&s->contents);
        s->contents = image_make(glass->w, glass->h);
    }
    if (viewer_paint(v, &s->paint, &s->contents, error) < 0) {
        return -1;
    }
    SDL_Surface *contents = as_surface(&s->contents);
    int bad = contents == NULL || SDL_BlitSurface(contents, NULL, glass, NULL) < 0 ||
              SDL_UpdateWindowSurface(s->window) < 0;
    SDL_FreeSurface(contents);
    return bad ? fail_sdl(error, "the window cannot be drawn on") : 0;
}

/* What the window holds, by way of SDL again. */
static int shoot(screen *s, const char *path, bake_error *error)
{
    image shot = image_make(s->contents.width, s->contents.height);
    SDL_Surface *copy = as_surface(&shot), *glass = SDL_GetWindowSurface(s->window);
    int bad = copy == NULL || glass == NULL || SDL_BlitSurface(glass, NULL, copy, NULL) < 0;
    int err =
        bad ? fail_sdl(error, "the window cannot be read") : image_write_png(&shot, path, error);
    SDL_FreeSurface(copy);
    image_free(&shot);
    return err;
}

static void entitle(screen *s, viewer *v)
{
    char title[VIEWER_TITLE_BYTES];
    viewer_title(v, title);
    if (strcmp(title, s->title) != 0) {
        SDL_SetWindowTitle(s->window, strcpy(s->title, title));
    }
    if (v->help) {
        v->help = 0;
        fputs(VIEWER_HELP, stdout);
        fflush(stdout);
    }
}

/* ---- the loop -------------------------------------------------------------------------------- */

static int run(screen *s, viewer *v, const window_wish *wish, bake_error *error)
{
    const double us = 1e6 / (double)SDL_GetPerformanceFrequency();
    Uint64 before = SDL_GetPerformanceCounter();
    for (long frame = 1; !v->quit; frame++) {
        SDL_Event event;
        Uint32 start = SDL_GetTicks();
        while (SDL_PollEvent(&event)) {
            react(s, v, &event);
        }
        Uint64 now = SDL_GetPerformanceCounter();
        viewer_advance(v, (double)(now - before) * us);
        before = now;
        if (draw(s, v, error) < 0) {
            return -1;
        }
        entitle(s, v);
        v->quit |= frame == wish->frames;
        Uint32 took = SDL_GetTicks() - start;
        SDL_Delay(took < FRAME_MS ? FRAME_MS - took : 1);
    }
    return wish->shot ? shoot(s, wish->shot, error) : 0;
}

/* Without a screen SDL draws where nobody looks: an error unless it was told to. */
static int start(bake_error *error)
{
    static const char *const UNSEEN[] = {"offscreen", "dummy", "evdev"};
    int good = SDL_Init(SDL_INIT_VIDEO) == 0;
    const char *why = good ? "DISPLAY leads to none" : SDL_GetError();
    for (int i = 0; i < 3 && good && SDL_getenv("SDL_VIDEODRIVER") == NULL; i++) {
        good = strcmp(SDL_GetCurrentVideoDriver(), UNSEEN[i]) != 0;
    }
    return good ? 0
                : bake_fail(error,
                            "there is no screen to open a window on (%s); play "
                            "--png needs none",
                            why);
}

int window_run(viewer *v, const window_wish *wish, bake_error *error)
{
    screen s = {0};
    if (start(error) < 0) {
        SDL_Quit();
        return -1;
    }
    s.window =
        SDL_CreateWindow("wiggly view", SDL_WINDOWPOS_UNDEFINED, SDL_WINDOWPOS_UNDEFINED,
                         wish->size.width, wish->size.height + VIEWER_BAR, SDL_WINDOW_RESIZABLE);
    int err = s.window ? 0 : fail_sdl(error, "no window");
    if (err == 0) {
        SDL_StartTextInput();
        err = run(&s, v, wish, error);
        SDL_DestroyWindow(s.window);
    }
    painter_close(&s.paint);
    image_free(&s.contents);
    SDL_Quit();
    return err;
}

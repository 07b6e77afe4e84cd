/* wiggly: the baker's command line.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "command.h"

#include <cblas.h>
#include <stdio.h>
#include <string.h>

static const char HELP[] =
    "wiggly: motion for things that are small or physical\n"
    "\n"
    "  wiggly bake SCENE.yaml -o OUT.wgl   solve, fit, pack and certify; also writes OUT.h and "
    "OUT.c\n"
    "  wiggly check SCENE.yaml [CLIP.wgl]  the certificate: what is played against what was "
    "authored\n"
    "      --json FILE      the certificate as JSON\n"
    "      --png FILE       authored and played curves; --clip NAME picks the clip (default: the "
    "first)\n"
    "      --csv FILE       the same curves as numbers, every 20 ms ('-': stdout)\n"
    "      --quiet          no certificate on stdout, no progress\n"
    "  wiggly info CLIP.wgl                what is in a clip file\n"
    "  wiggly play CLIP.wgl                plays all layers as the firmware does, or --clip NAME "
    "alone\n"
    "      --csv FILE       time, channels, servo positions ('-': stdout)\n"
    "      --png FILE       a clip with meshes: 4 x 4 pictures over its time, one with --at S, or "
    "all of\n"
    "                       them with a name like frame_%03d.png, --fps N a second (10); else its "
    "curves\n"
    "      --serial DEVICE  live on a servo bus; --baud N (115200)\n"
    "      --bus FILE       the frames of that bus in a file, at once\n"
    "      --rate HZ        frames a second (50)     --seconds S  how long (the longest clip)\n"
    "  wiggly view CLIP.wgl                the same in a window; the h key lists keys and mouse\n"
    "      --frames N       closes after N frames    --shot FILE   the last one as PNG\n"
    "  pictures of play and view:\n"
    "      --size WxH       pixels (play 240x240, view 400x400)\n"
    "      --panel NAME     exactly what a panel shows: ssd0323, ssd1306, ssd0303, st7789, "
    "ili9341, sharp\n"
    "      --view N         which camera (0)         --shading wire|flat|smooth (the view's)\n"
    "      --bases K        level of detail (all)    --at S        that moment, in seconds\n"
    "\n"
    "exit codes: 0 done, 1 failed (the message says where and what to do), 2 usage, 3 over "
    "tolerance\n";

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        int (*run)(int, char **, bake_error *);
    } commands[] = {{"bake", command_bake},
                    {"check", command_check},
                    {"info", command_info},
                    {"play", command_play},
                    {"view", command_view}};
    bake_error error = {""};
    openblas_set_num_threads(1); /* sums of several threads have no fixed order */
    if (argc > 1 && (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 ||
                     strcmp(argv[1], "help") == 0)) {
        fputs(HELP, stdout);
        return EXIT_DONE;
    }
    for (size_t i = 0; argc > 1 && i < sizeof commands / sizeof *commands; i++) {
        if (strcmp(argv[1], commands[i].name) == 0) {
            if (argc > 2 && (strcmp(argv[2], "--help") == 0 || strcmp(argv[2], "-h") == 0)) {
                fputs(HELP, stdout);
                return EXIT_DONE;
            }
            int code = commands[i].run(argc - 2, argv + 2, &error);
            if (error.text[0]) {
                fprintf(stderr, "wiggly %s: %s\n", argv[1], error.text);
            }
            if (fflush(stdout) != 0 || ferror(stdout)) {
                fprintf(stderr, "wiggly %s: stdout cannot be written: is the disk full?\n",
                        argv[1]);
                return EXIT_FAILED;
            }
            return code;
        }
    }
    if (argc > 1) {
        fprintf(stderr, "wiggly: there is no command '%s'\n\n", argv[1]);
    }
    fputs(HELP, stderr);
    return EXIT_USAGE;
}

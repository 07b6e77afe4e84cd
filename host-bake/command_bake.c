/* wiggly bake, wiggly check: from a scene to a certified clip.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "certify.h"
#include "check_curves.h"
#include "command.h"
#include "shapes.h"

#include <stdlib.h>
#include <string.h>

/* OUT must end so: it cannot be the scene file by mistake, and .h and .c beside it have a name. */
static const char ENDING[] = ".wgl";

static int is_clip_name(const char *path)
{
    size_t n = strlen(path), ending = sizeof ENDING - 1;
    return n > ending && strcmp(path + n - ending, ENDING) == 0 && path[n - ending - 1] != '/';
}

static char *stem_of(const char *path)
{
    char *stem = bake_copy(path);
    stem[strlen(stem) - (sizeof ENDING - 1)] = 0;
    return stem;
}

static int write_beside(const char *stem, const char *ending, const bytes *text, bake_error *error)
{
    char *path = bake_alloc(strlen(stem) + strlen(ending) + 1, 1);
    strcat(strcpy(path, stem), ending);
    int err = file_replace(path, text->at, text->count, error);
    free(path);
    return err;
}

/* OUT.h, OUT.c and, when those are there, OUT.wgl: a clip on disk is never newer than its header.
 */
static int write_clip(const build *b, const char *path, bake_error *error)
{
    bytes header = {0}, source = {0};
    char *stem = stem_of(path);
    const char *name = strrchr(stem, '/') ? strrchr(stem, '/') + 1 : stem;
    build_header_text(b, name, &header);
    build_source_text(b, name, &source);
    int err = write_beside(stem, ".h", &header, error);
    if (err == 0) {
        err = write_beside(stem, ".c", &source, error);
    }
    if (err == 0) {
        err = file_replace(path, b->file.at, b->file.count, error);
    }
    bytes_free(&header);
    bytes_free(&source);
    free(stem);
    return err;
}

static int write_json(const build *b, const certificate *c, const char *path, bake_error *error)
{
    bytes text = {0};
    certificate_json(b, c, &text);
    int err = file_replace(path, text.at, text.count, error);
    bytes_free(&text);
    return err;
}

/* Picture and table of one clip, where asked. */
static int write_curves(const build *b, const wg_file *file, const option *options,
                        bake_error *error)
{
    const char *png = option_value(options, "--png"), *csv = option_value(options, "--csv");
    const char *name = option_value(options, "--clip");
    int clip = png || csv ? clip_find(file, name) : 0;
    if (clip < 0) {
        return bake_fail(error, "%s has no clip named %s", b->scene->path, name);
    }
    int err = png ? curves_png(b, file, clip, png, error) : 0;
    return err == 0 && csv ? curves_csv(b, file, clip, csv, error) : err;
}

/* Certificate (unless --quiet) and warnings; JSON, picture and table where asked. Returns an exit
 * code. */
static int report(const build *b, const wg_file *file, size_t size, const option *options,
                  bake_error *error)
{
    certificate c;
    const char *json = option_value(options, "--json");
    if (certify(b, file, size, &c, error) < 0) {
        return EXIT_FAILED;
    }
    if (!option_value(options, "--quiet")) {
        certificate_print(b, &c, stdout);
        fflush(stdout); /* the warnings follow it in a log of both */
    }
    certificate_warn(b, &c, stderr);
    int err = json ? write_json(b, &c, json, error) : 0;
    if (err == 0) {
        err = write_curves(b, file, options, error);
    }
    int failed = c.failed;
    certificate_free(&c);
    return err < 0 ? EXIT_FAILED : failed ? EXIT_TOLERANCE : EXIT_DONE;
}

/* What was baked just now, or `clip` from disk. */
static int judge(const build *b, const char *clip, const option *options, bake_error *error)
{
    clip_disk disk;
    if (clip == NULL) {
        wg_file file;
        wg_open(&file, b->file.at, (uint32_t)b->file.count);
        return report(b, &file, b->file.count, options, error);
    }
    if (clip_read(clip, &disk, error) < 0) {
        return EXIT_FAILED;
    }
    int code = report(b, &disk.file, disk.size, options, error);
    clip_release(&disk);
    return code;
}

/* Bakes a scene, judges that or `clip`, and writes `out` if all is well. */
static int bake_scene(const char *path, const char *clip, const char *out, const option *options,
                      bake_error *error)
{
    scene s;
    shapes sh;
    build b;
    if (scene_load(path, &s, error) < 0) {
        return EXIT_FAILED;
    }
    int code = EXIT_FAILED;
    if (shapes_bake(&s, option_value(options, "--quiet") == NULL, &sh, &b, error) == 0) {
        code = judge(&b, clip, options, error);
        if (code == EXIT_DONE && out && write_clip(&b, out, error) < 0) {
            code = EXIT_FAILED;
        }
        if (code == EXIT_TOLERANCE) {
            bake_fail(error,
                      "%s: a channel or mesh misses its tolerance, or the target is too small (the "
                      "certificate says so, FAILED)%s",
                      clip ? clip : path, out ? "; nothing was written" : "");
        }
        build_free(&b);
        shapes_free(&sh);
    }
    scene_free(&s);
    return code;
}

int command_bake(int argc, char **argv, bake_error *error)
{
    option options[] = {{"-o", 1, NULL},    {"--json", 1, NULL}, {"--png", 1, NULL},
                        {"--csv", 1, NULL}, {"--clip", 1, NULL}, {"--quiet", 0, NULL},
                        {NULL, 0, NULL}};
    const char *words[1];
    int count = options_parse(argc, argv, options, (option_words){words, 1}, error);
    if (count >= 0 && (count != 1 || option_value(options, "-o") == NULL)) {
        count = bake_fail(error, "usage: wiggly bake SCENE.yaml -o OUT.wgl");
    }
    if (count >= 0 && !is_clip_name(option_value(options, "-o"))) {
        count =
            bake_fail(error, "-o %s: a clip's name ends in .wgl; .h and .c are written beside it",
                      option_value(options, "-o"));
    }
    return count < 0 ? EXIT_USAGE
                     : bake_scene(words[0], NULL, option_value(options, "-o"), options, error);
}

int command_check(int argc, char **argv, bake_error *error)
{
    option options[] = {{"--json", 1, NULL}, {"--png", 1, NULL},   {"--csv", 1, NULL},
                        {"--clip", 1, NULL}, {"--quiet", 0, NULL}, {NULL, 0, NULL}};
    const char *words[2];
    int count = options_parse(argc, argv, options, (option_words){words, 2}, error);
    if (count == 0) {
        count = bake_fail(error, "usage: wiggly check SCENE.yaml [CLIP.wgl]");
    }
    if (count < 0) {
        return EXIT_USAGE;
    }
    return bake_scene(words[0], count == 2 ? words[1] : NULL, NULL, options, error);
}

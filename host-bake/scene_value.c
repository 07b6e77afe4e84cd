/* Reads single fields of a scene: numbers with units, words, names, references.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_load.h"

#include "wiggly_format.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* A clip's length is stored as 32-bit microseconds: 4294 s. */
const scene_measure scene_time = {
    "a time such as 1.5, '1.5 s' or '250 ms'", {{"s", 1}, {"ms", 1e-3}}, 0, 4294};
const scene_measure scene_frequency = {"a frequency such as 2 or '2 Hz'", {{"Hz", 1}}, 1e-3, 1000};
const scene_measure scene_plain = {"a number such as 0.5", {{NULL, 0}}, -1e9, 1e9};
const scene_measure scene_positive = {"a number such as 0.5", {{NULL, 0}}, 0, 1e9};
const scene_measure scene_fraction = {"a number from 0 to 1", {{"%", 1e-2}}, 0, 1};
const scene_measure scene_length = {"a length such as 3 or '3 mm'", {{"mm", 1}}, 1e-6, 1e6};

/* 2^28 raw units at the coarsest useful resolution are far beyond any of these. */
#define VALUE 1e6
#define RATE  1e9
const scene_measure scene_value[4][3] = {
    [WG_UNIT_NONE] = {{"a number such as 0.5", {{NULL, 0}}, -VALUE, VALUE},
                      {"a velocity such as 0.5 or '0.5 /s'", {{"/s", 1}}, -RATE, RATE},
                      {"an acceleration such as 0.5 or '0.5 /s2'", {{"/s2", 1}}, -RATE, RATE}},
    [WG_UNIT_DEGREE] = {{"an angle such as 30 or '30 deg'", {{"deg", 1}}, -VALUE, VALUE},
                        {"a velocity such as 30 or '30 deg/s'", {{"deg/s", 1}}, -RATE, RATE},
                        {"an acceleration such as '30 deg/s2'", {{"deg/s2", 1}}, -RATE, RATE}},
    [WG_UNIT_MICROSECOND] = {{"a pulse such as 1500 or '1500 us'", {{"us", 1}}, -VALUE, VALUE},
                             {"a velocity such as '300 us/s'", {{"us/s", 1}}, -RATE, RATE},
                             {"an acceleration such as '9 us/s2'", {{"us/s2", 1}}, -RATE, RATE}},
    [WG_UNIT_MILLIMETRE] = {{"a length such as 3 or '3 mm'", {{"mm", 1}}, -VALUE, VALUE},
                            {"a velocity such as 3 or '3 mm/s'", {{"mm/s", 1}}, -RATE, RATE},
                            {"an acceleration such as '3 mm/s2'", {{"mm/s2", 1}}, -RATE, RATE}},
};

int loader_fail(const loader *l, const char *field, const char *format, ...)
{
    char what[800];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    return bake_fail(l->error, "%s:%d: %s", l->tree->path, scene_tree_line(l->tree, l->node, field),
                     what);
}

int loader_has(const loader *l, const char *field)
{
    return scene_tree_find(l->tree, l->node, field) >= 0;
}

int loader_need(const loader *l, const char *field, const char *text, const char *example)
{
    if (text != NULL && text[0] != '\0')
        return 0;
    return loader_fail(l, field, "'%s' is %s; write for example:  %s", field,
                       text == NULL ? "missing" : "empty", example);
}

/* Length of the decimal number at the start of `text`, 0 if there is none. strtod alone would also
 * take hexadecimal, "inf" and "nan", which in a scene are slips. */
static size_t number_length(const char *text)
{
    size_t sign = text[0] == '+' || text[0] == '-';
    size_t digits = strspn(text + sign, "0123456789.");
    if (strcspn(text + sign, "0123456789") >= digits)
        return 0;
    char *end;
    strtod(text, &end);
    size_t length = (size_t)(end - text);
    return text[sign] == '0' && (text[sign + 1] == 'x' || text[sign + 1] == 'X') ? 0 : length;
}

int loader_quantity(const loader *l, const char *field, const char *text, double *value,
                    char suffix[LOADER_SUFFIX_BYTES])
{
    size_t length = number_length(text);
    if (length == 0)
        return loader_fail(l, field, "'%s' is '%.40s'; expected a number", field, text);
    *value = strtod(text, NULL);
    if (!isfinite(*value))
        return loader_fail(l, field, "'%s' is '%.40s', too large for any number", field, text);
    const char *rest = text + length + strspn(text + length, " ");
    snprintf(suffix, LOADER_SUFFIX_BYTES, "%s", rest);
    return 0;
}

int loader_number(const loader *l, const char *field, const char *text,
                  const scene_measure *measure, double *out)
{
    if (text == NULL)
        return 0;
    char suffix[LOADER_SUFFIX_BYTES];
    double value;
    if (number_length(text) == 0)
        return loader_fail(l, field, "'%s' is '%.40s'; expected %s", field, text, measure->example);
    if (loader_quantity(l, field, text, &value, suffix))
        return -1;
    double factor = suffix[0] == '\0' ? 1 : 0;
    for (int i = 0; i < 4 && measure->unit[i].suffix != NULL; i++)
        if (strcmp(suffix, measure->unit[i].suffix) == 0)
            factor = measure->unit[i].factor;
    if (factor <= 0)
        return loader_fail(l, field, "'%s' has the unit '%s'; expected %s", field, suffix,
                           measure->example);
    value *= factor;
    if (value < measure->least || value > measure->most)
        return loader_fail(l, field, "'%s' is %g; it must be from %g to %g", field, value,
                           measure->least, measure->most);
    *out = value;
    return 0;
}

int loader_integer(const loader *l, const char *field, const char *text, const int range[2],
                   int *out)
{
    if (text == NULL)
        return 0;
    char *end;
    long value = strtol(text, &end, 10);
    if (end == text || *end != '\0')
        return loader_fail(l, field, "'%s' is '%.40s'; expected a whole number", field, text);
    if (value < range[0] || value > range[1])
        return loader_fail(l, field, "'%s' is %.20s; it must be from %d to %d", field, text,
                           range[0], range[1]);
    *out = (int)value;
    return 0;
}

int loader_word(const loader *l, const char *field, const char *text, const scene_word *words,
                int *out)
{
    if (text == NULL)
        return 0;
    scene_names names = {words, sizeof *words, 0};
    while (words[names.count].word != NULL)
        names.count++;
    int found = scene_names_find(&names, text);
    char hint[SCENE_HINT_BYTES];
    if (found < 0)
        return loader_fail(l, field, "'%s' is '%.40s'; %s", field, text,
                           scene_names_hint(&names, text, hint));
    *out = words[found].value;
    return 0;
}

int loader_flag(const loader *l, const char *field, const char *text, int *out)
{
    static const scene_word flags[] = {{"true", 1}, {"false", 0}, {"yes", 1}, {"no", 0}, {NULL, 0}};
    return loader_word(l, field, text, flags, out);
}

int loader_reference(const loader *l, const char *field, const char *text, scene_names names,
                     int *out)
{
    if (text == NULL)
        return 0;
    char hint[SCENE_HINT_BYTES];
    *out = scene_names_find(&names, text);
    if (*out < 0)
        return loader_fail(l, field, "there is no %s '%.60s'; %s", field, text,
                           scene_names_hint(&names, text, hint));
    return 0;
}

int loader_file(const loader *l, const char *text, char **out)
{
    const char *slash = strrchr(l->tree->path, '/');
    size_t directory = text[0] == '/' || slash == NULL ? 0 : (size_t)(slash - l->tree->path) + 1;
    *out = bake_alloc(directory + strlen(text) + 1, 1);
    memcpy(*out, l->tree->path, directory);
    strcpy(*out + directory, text);
    struct stat info;
    if (strchr(text, '#') == NULL && (stat(*out, &info) != 0 || !S_ISREG(info.st_mode)))
        return loader_fail(l, "file", "there is no file '%s'; paths start at the scene's directory",
                           *out);
    return 0;
}

int loader_colour(const loader *l, const char *field, char *const *text, unsigned count,
                  unsigned char out[3])
{
    static const int range[2] = {0, 255};
    if (text == NULL)
        return 0;
    if (count != 3)
        return loader_fail(l, field,
                           "'%s' has %u numbers; write red, green and blue:  [200, 180, 160]",
                           field, count);
    for (int i = 0; i < 3; i++) {
        int value = 0;
        if (loader_integer(l, field, text[i], range, &value))
            return -1;
        out[i] = (unsigned char)value;
    }
    return 0;
}

int loader_name(const loader *l, scene_names names, int index, const char *example, char **out)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    static const char others[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
    const char *name = scene_names_at(&names, index);
    if (loader_need(l, "name", name, example))
        return -1;
    if (strchr(letters, name[0]) == NULL || name[strspn(name, others)] != '\0')
        return loader_fail(l, "name",
                           "the name '%.60s' must begin with a letter and go on with letters, "
                           "digits, '_' or '-', because it becomes a C macro",
                           name);
    if (strlen(name) > 63)
        return loader_fail(l, "name", "the name '%.20s...' has more than 63 characters", name);
    names.count = index;
    if (scene_names_find(&names, name) >= 0)
        return loader_fail(l, "name", "there is already a '%s' in this list; names must differ",
                           name);
    int same = scene_names_find_macro(&names, name);
    if (same >= 0)
        return loader_fail(l, "name", "the names '%s' and '%s' become the same C macro; change one",
                           scene_names_at(&names, same), name);
    *out = bake_copy(name);
    return 0;
}

int loader_each(loader *l, const char *field, int (*read)(loader *l, int index))
{
    int outer = l->node, list = scene_tree_find(l->tree, outer, field);
    int child = list >= 0 ? l->tree->nodes[list].child : -1;
    for (int i = 0; child >= 0; i++, child = l->tree->nodes[child].next) {
        l->node = child;
        if (read(l, i))
            return -1;
    }
    l->node = outer;
    return 0;
}

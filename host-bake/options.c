/* Command lines.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "command.h"

#include <stdlib.h>
#include <string.h>

static option *find(option *options, const char *name, size_t length)
{
    for (; options->name; options++) {
        if (strlen(options->name) == length && strncmp(options->name, name, length) == 0) {
            return options;
        }
    }
    return NULL;
}

int options_parse(int argc, char **argv, option *options, option_words words, bake_error *error)
{
    int count = 0;
    for (int i = 0; i < argc; i++) {
        if (argv[i][0] != '-' || argv[i][1] == 0) {
            if (count == words.most) {
                return bake_fail(error, "'%s' is one word too many; see wiggly --help", argv[i]);
            }
            words.word[count++] = argv[i];
            continue;
        }
        const char *equals = strchr(argv[i], '=');
        size_t length = equals ? (size_t)(equals - argv[i]) : strlen(argv[i]);
        option *o = find(options, argv[i], length);
        if (o == NULL) {
            return bake_fail(error, "%s is not an option here; see wiggly --help", argv[i]);
        }
        if (!o->takes_value) {
            o->value = "";
        } else if (equals) {
            o->value = equals + 1;
        } else if (i + 1 < argc) {
            o->value = argv[++i];
        } else {
            return bake_fail(error, "%s needs a value after it", argv[i]);
        }
    }
    return count;
}

const char *option_value(const option *options, const char *name)
{
    for (; options->name; options++) {
        if (strcmp(options->name, name) == 0) {
            return options->value;
        }
    }
    return NULL;
}

double option_number(const option *options, const char *name, double otherwise, bake_error *error)
{
    const char *text = option_value(options, name);
    if (text == NULL) {
        return otherwise;
    }
    char *end;
    double value = strtod(text, &end);
    if (end == text || *end != 0 || !(value > 0) || value > 1e9) {
        return bake_fail(error, "%s needs a positive number, not '%s'", name, text);
    }
    return value;
}

/* Tables: to a file or to stdout, whole or with a complaint.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "command.h"

#include <string.h>

FILE *csv_open(const char *path, bake_error *error)
{
    FILE *to = strcmp(path, "-") == 0 ? stdout : fopen(path, "w");
    if (to == NULL) {
        bake_fail(error, "%s: cannot be written", path);
    }
    return to;
}

int csv_close(FILE *to, const char *path, bake_error *error)
{
    int bad = fflush(to) != 0 || ferror(to);
    bad |= to != stdout && fclose(to) != 0;
    return bad ? bake_fail(error, "%s: cannot be written whole: is the disk full?", path) : 0;
}

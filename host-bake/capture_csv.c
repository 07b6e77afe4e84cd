/* Captured curves from CSV: one row a sample, an optional header row, a column of times [s].
 * Comma, semicolon or tab, whichever the first row has; '#' begins a comment line; values may be
 * quoted, but hold no separator. The column of times is called "time" or is the first.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "capture.h"
#include "scene_names.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS_MAX = 1024 };

typedef struct {
    capture_reader *reader;
    int line;
    char separator;  /* 0 before the first row */
    int time, value; /* columns, 0-based */
    char *cell[COLUMNS_MAX];
    int cell_count;
} csv;

static int fail_row(const csv *t, const char *what, const char *found)
{
    return bake_fail(t->reader->error, "%s:%d: %s, found '%.40s'", t->reader->source->file, t->line,
                     what, found);
}

static char *trim(char *cell)
{
    cell += strspn(cell, " \t\"");
    size_t length = strlen(cell);
    while (length > 0 && strchr(" \t\r\n\"", cell[length - 1]) != NULL)
        cell[--length] = '\0';
    return cell;
}

/* Cuts the row in place; -1 when it has too many columns. */
static int split(csv *t, char *row)
{
    t->cell_count = 0;
    for (char *next = row; next != NULL;) {
        if (t->cell_count == COLUMNS_MAX)
            return bake_fail(t->reader->error, "%s:%d: more than %d columns",
                             t->reader->source->file, t->line, COLUMNS_MAX);
        char *cell = next;
        next = strchr(cell, t->separator);
        if (next != NULL)
            *next++ = '\0';
        t->cell[t->cell_count++] = trim(cell);
    }
    return 0;
}

static int is_number(const char *text, double *value)
{
    char *end;
    *value = strtod(text, &end);
    return end != text && *end == '\0';
}

static int same_word(const char *a, const char *b)
{
    while (*a != '\0' && (*a | 32) == (*b | 32))
        a++, b++;
    return *a == *b;
}

static int fail_column(const csv *t, int header)
{
    const capture_reader *r = t->reader;
    char hint[SCENE_HINT_BYTES] = "the file has no header row, so give its number, 1 = the first";
    if (header)
        scene_names_hint(&(scene_names){t->cell, sizeof *t->cell, t->cell_count}, r->curve->column,
                         hint);
    return bake_fail(r->error, "%s:%d: '%s' has no column '%.60s'; %s", r->scene_path,
                     r->curve->line, r->source->file, r->curve->column, hint);
}

/* Decides from the first row which columns count. A name wins over a number. */
static int choose_columns(csv *t, int *header)
{
    const capture_reader *r = t->reader;
    const char *wanted = r->curve->column;
    double number;
    *header = 0;
    for (int i = 0; i < t->cell_count; i++)
        *header |= !is_number(t->cell[i], &number);
    t->time = 0;
    t->value = -1;
    for (int i = t->cell_count - 1; *header && i >= 0; i--) {
        if (same_word(t->cell[i], "time"))
            t->time = i;
        if (strcmp(t->cell[i], wanted) == 0)
            t->value = i;
    }
    if (t->value < 0 && is_number(wanted, &number) && number >= 1 && number <= t->cell_count &&
        number == floor(number))
        t->value = (int)number - 1;
    if (t->value < 0)
        return fail_column(t, *header);
    if (t->value == t->time)
        return bake_fail(r->error, "%s:%d: column '%.60s' of '%s' holds the times", r->scene_path,
                         r->curve->line, wanted, r->source->file);
    return 0;
}

static int take_sample(csv *t)
{
    const capture *c = t->reader->out;
    double time, value;
    int last = t->time > t->value ? t->time : t->value;
    if (t->cell_count <= last)
        return bake_fail(t->reader->error, "%s:%d: the row has %d columns, %d are needed",
                         t->reader->source->file, t->line, t->cell_count, last + 1);
    if (!is_number(t->cell[t->time], &time) || !isfinite(time))
        return fail_row(t, "expected a time in seconds", t->cell[t->time]);
    if (!is_number(t->cell[t->value], &value) || !(fabs(value) <= 1e9))
        return fail_row(t, "expected a number", t->cell[t->value]);
    if (c->count > 0 && time <= c->time[c->count - 1])
        return fail_row(t, "times must ascend", t->cell[t->time]);
    capture_add(t->reader, time, value);
    return 0;
}

static char find_separator(const char *row)
{
    return strchr(row, ',') ? ',' : strchr(row, ';') ? ';' : '\t';
}

static int take_row(csv *t, char *row)
{
    int header = 0;
    if (row[strspn(row, " \t\r\n")] == '\0' || row[0] == '#')
        return 0;
    int first = t->separator == 0;
    if (first)
        t->separator = find_separator(row);
    if (split(t, row) || (first && choose_columns(t, &header)))
        return -1;
    return header ? 0 : take_sample(t);
}

int capture_read_csv(capture_reader *r)
{
    FILE *file = fopen(r->source->file, "r");
    if (file == NULL)
        return bake_fail(r->error, "%s:%d: '%s' may not be read", r->scene_path, r->curve->line,
                         r->source->file);
    csv table = {.reader = r};
    char *row = NULL;
    size_t room = 0;
    int err = 0;
    while (err == 0 && getline(&row, &room, file) >= 0) {
        table.line++;
        int mark = table.line == 1 && strncmp(row, "\xef\xbb\xbf", 3) == 0; /* byte order mark */
        err = take_row(&table, row + (mark ? 3 : 0));
    }
    free(row);
    fclose(file);
    if (err == 0 && r->out->count < 2)
        return bake_fail(r->error, "%s:%d: the file has %d rows of numbers; a curve needs two",
                         r->source->file, table.line, r->out->count);
    return err;
}

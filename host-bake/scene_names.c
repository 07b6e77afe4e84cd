/* Finding names, and the nearest ones when a name is misspelt.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "scene_names.h"

#include <stdio.h>
#include <string.h>

enum { NAME_COMPARED = 40, HINTS = 6 };

const char *scene_names_at(const scene_names *names, int index)
{
    const char *name;
    memcpy(&name, (const char *)names->first + (size_t)index * names->stride, sizeof name);
    return name;
}

int scene_names_find(const scene_names *names, const char *name)
{
    for (int i = 0; i < names->count; i++) {
        const char *other = scene_names_at(names, i);
        if (other != NULL && strcmp(other, name) == 0)
            return i;
    }
    return -1;
}

static int lower(char c)
{
    return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c;
}

static int same_macro(const char *a, const char *b)
{
    for (; *a != '\0' && *b != '\0'; a++, b++)
        if (lower(*a == '-' ? '_' : *a) != lower(*b == '-' ? '_' : *b))
            return 0;
    return *a == *b;
}

int scene_names_find_macro(const scene_names *names, const char *name)
{
    for (int i = 0; i < names->count; i++) {
        const char *other = scene_names_at(names, i);
        if (other != NULL && same_macro(other, name))
            return i;
    }
    return -1;
}

static int least(int a, int b, int c)
{
    int ab = a < b ? a : b;
    return ab < c ? ab : c;
}

/* Edits (insert, delete, replace, swap neighbours) between two names; case counts as nothing. Only
 * the first 40 characters count, so the work is bounded for any input. */
static int edits(const char *a, const char *b)
{
    int rows[3][NAME_COMPARED + 1];
    int length_a = (int)strnlen(a, NAME_COMPARED), length_b = (int)strnlen(b, NAME_COMPARED);
    for (int j = 0; j <= length_b; j++)
        rows[0][j] = j;
    for (int i = 1; i <= length_a; i++) {
        int *now = rows[i % 3], *before = rows[(i + 2) % 3], *before2 = rows[(i + 1) % 3];
        now[0] = i;
        for (int j = 1; j <= length_b; j++) {
            int same = lower(a[i - 1]) == lower(b[j - 1]);
            now[j] = least(before[j] + 1, now[j - 1] + 1, before[j - 1] + !same);
            if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) &&
                lower(a[i - 2]) == lower(b[j - 1]) && before2[j - 2] + 1 < now[j])
                now[j] = before2[j - 2] + 1;
        }
    }
    return rows[length_a % 3][length_b];
}

/* The six names with the fewest edits, nearest first; returns how many. */
static int nearest(const scene_names *names, const char *wrong, int index[HINTS],
                   int distance[HINTS])
{
    int count = 0;
    for (int i = 0; i < names->count; i++) {
        const char *name = scene_names_at(names, i);
        if (name == NULL || name[0] == '\0')
            continue;
        int d = edits(name, wrong);
        int at = count < HINTS ? count++ : HINTS;
        for (; at > 0 && distance[at - 1] > d; at--) {
            if (at < HINTS) {
                distance[at] = distance[at - 1];
                index[at] = index[at - 1];
            }
        }
        if (at < HINTS) {
            distance[at] = d;
            index[at] = i;
        }
    }
    return count;
}

const char *scene_names_hint(const scene_names *names, const char *wrong,
                             char text[SCENE_HINT_BYTES])
{
    int index[HINTS], distance[HINTS];
    int count = nearest(names, wrong, index, distance);
    if (count == 0) {
        snprintf(text, SCENE_HINT_BYTES, "there are none");
        return text;
    }
    /* Two edits in a short name make a different word; a third of the letters is a misspelling. */
    int near = 1 + (int)strnlen(wrong, NAME_COMPARED) / 3;
    const char *best = scene_names_at(names, index[0]);
    int used = 0;
    if (distance[0] <= near)
        used = snprintf(text, SCENE_HINT_BYTES, "did you mean '%.40s'? ", best);
    used += snprintf(text + used, (size_t)(SCENE_HINT_BYTES - used),
                     "%s: ", names->count > count ? "the nearest there are" : "there is");
    for (int i = 0; i < count; i++)
        used += snprintf(text + used, (size_t)(SCENE_HINT_BYTES - used), "%s%.34s", i ? ", " : "",
                         scene_names_at(names, index[i]));
    return text;
}

/* A board without a display: nothing of shapes and pictures is linked.
 * SPDX-License-Identifier: MIT */
#include "screen.h"

int screen_start(const wg_file *file)
{
    (void)file;
    return 0;
}

void screen_frame(const int32_t *values)
{
    (void)values;
}

bool screen_work(void)
{
    return false;
}

void screen_finish(const int32_t *values)
{
    (void)values;
}

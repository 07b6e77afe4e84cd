/* The whole test framework: checks count, failures print, main returns check_done().
 * SPDX-License-Identifier: MIT */
#ifndef CHECK_H
#define CHECK_H

#include <stdio.h>

static int check_passed, check_failed; /* tests, not checks: see TEST */
static int check_ok;

#define CHECK(cond)                                                                                \
    do {                                                                                           \
        if (!(cond)) {                                                                             \
            check_ok = 0;                                                                          \
            printf("%s:%d: %s\n", __FILE__, __LINE__, #cond);                                      \
        }                                                                                          \
    } while (0)

#define CHECK_EQ(got, want)                                                                        \
    do {                                                                                           \
        long long check_got = (long long)(got), check_want = (long long)(want);                    \
        if (check_got != check_want) {                                                             \
            check_ok = 0;                                                                          \
            printf("%s:%d: %s is %lld, not %lld\n", __FILE__, __LINE__, #got, check_got,           \
                   check_want);                                                                    \
        }                                                                                          \
    } while (0)

#define CHECK_NEAR(got, want, tolerance)                                                           \
    do {                                                                                           \
        double check_got = (got), check_want = (want), check_tol = (tolerance);                    \
        if (!(check_got - check_want <= check_tol && check_want - check_got <= check_tol)) {       \
            check_ok = 0;                                                                          \
            printf("%s:%d: %s is %.17g, not %.17g +- %g\n", __FILE__, __LINE__, #got, check_got,   \
                   check_want, check_tol);                                                         \
        }                                                                                          \
    } while (0)

/* Runs one named test: void name(void). */
#define TEST(name)                                                                                 \
    do {                                                                                           \
        check_ok = 1;                                                                              \
        name();                                                                                    \
        check_ok ? check_passed++ : check_failed++;                                                \
        if (!check_ok)                                                                             \
            printf("FAIL %s\n", #name);                                                            \
    } while (0)

static inline int check_done(void)
{
    printf("%d passed, %d failed\n", check_passed, check_failed);
    return check_failed != 0;
}

#endif

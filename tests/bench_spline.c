/* Splines per second of processor time: ten random hard keys, end velocities, the banded path.
 *   bench_spline [count] [report]   default 1000000 without the report's quadrature
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "spline_random.h"

#include <stdlib.h>
#include <time.h>

#define PROBLEMS 64
#define TEN      10

int main(int argc, char **argv)
{
    static bake_key keys[PROBLEMS][KEYS];
    static bake_spline_problem problems[PROBLEMS];
    long count = argc > 1 ? strtol(argv[1], NULL, 10) : 1000000, failed = 0;
    bake_spline_report report, *wanted = argc > 2 ? &report : NULL;
    bake_error error;
    double sum = 0.0;
    for (int i = 0; i < PROBLEMS; i++) {
        random_keys(keys[i], TEN);
        problems[i] = clamped;
        problems[i].mode = random_mode();
    }
    struct timespec start, end;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &start);
    for (long i = 0; i < count; i++) {
        bake_curve curve;
        failed += bake_spline_solve(&problems[i % PROBLEMS], keys[i % PROBLEMS], TEN, &curve,
                                    wanted, &error) != 0;
        sum += curve.count ? curve.segment[0].w[1] : 0.0;
        bake_curve_free(&curve);
    }
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
    double seconds =
        (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
    printf("%ld splines of %d keys in %.3f s: %.0f per second (%ld failed, checksum %.6g)\n", count,
           TEN, seconds, (double)count / seconds, failed, sum);
    return failed != 0;
}

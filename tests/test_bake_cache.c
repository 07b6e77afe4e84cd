/* Results on disk: what is found again, what is not, and what damage, size and
 * company do to it. Source: own; everything is compared with what was stored,
 * or with no file at all. SPDX-License-Identifier: AGPL-3.0-or-later */
#include "cache.h"
#include "check.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define PLACE "build/cache_test"
#define FILES PLACE "/wiggly"

enum { BYTES = 300, HEAD = 48 };

static cache_key key_of(const char *kind, int number)
{
    cache_key key = cache_key_start(kind);
    cache_key_int(&key, number);
    return key;
}

static int same_key(cache_key a, cache_key b)
{
    return a.a == b.a && a.b == b.b;
}

static void pattern(unsigned char *out, int size, int start)
{
    for (int i = 0; i < size; i++)
        out[i] = (unsigned char)(start + 7 * i);
}

/* Visits all files of the cache; the last one's path is left in `path`. Returns
 * how many there are. */
static int list(char path[512], int remove_them)
{
    int count = 0;
    DIR *d = opendir(FILES);
    for (struct dirent *e = d ? readdir(d) : NULL; e; e = readdir(d)) {
        if (e->d_name[0] == '.')
            continue;
        snprintf(path, 512, "%s/%s", FILES, e->d_name);
        if (remove_them)
            remove(path);
        count++;
    }
    if (d)
        closedir(d);
    return count;
}

static void empty(void)
{
    char path[512];
    list(path, 1);
    rmdir(FILES);
    remove(PLACE);
    rmdir(PLACE);
    setenv("XDG_CACHE_HOME", PLACE, 1);
}

/* 1: `size` bytes are there and are those of pattern(start). */
static int is_there(const cache_key *key, int size, int start)
{
    unsigned char want[BYTES];
    size_t found = 0;
    unsigned char *data = cache_load(key, &found);
    pattern(want, size, start);
    int good = data && found == (size_t)size && memcmp(data, want, found) == 0;
    CHECK(data == NULL || good); /* anything else is worse than nothing */
    free(data);
    return good;
}

static void store(const cache_key *key, int size, int start)
{
    unsigned char data[BYTES];
    pattern(data, size, start);
    cache_store(key, data, (size_t)size);
}

static void keys_tell_all_that_they_are_made_of(void)
{
    const double x[3] = {1, 2, 3}, y[3] = {1, 2, 3.0000000000000004};
    cache_key a = cache_key_start("modes 1"), b = a, c = a, d = a;
    CHECK(!same_key(a, cache_key_start("modes 2")));
    cache_key_add(&a, x, sizeof x);
    cache_key_add(&b, y, sizeof y);
    CHECK(!same_key(a, b)); /* one bit in a number */
    cache_key_add(&c, x, sizeof x[0]);
    cache_key_add(&c, x + 1, 2 * sizeof x[0]);
    CHECK(!same_key(a, c)); /* the same bytes, divided otherwise */
    cache_key_add(&d, NULL, 0);
    CHECK(!same_key(d, cache_key_start("modes 1"))); /* a list of none is something */
    CHECK(!same_key(key_of("x", 1), key_of("x", -1)));
    cache_key zero = cache_key_start("x"), minus = zero;
    cache_key_real(&zero, 0.0);
    cache_key_real(&minus, -0.0);
    CHECK(!same_key(zero, minus));
    CHECK(same_key(key_of("x", 5), key_of("x", 5)));
}

/* 2016 words of two bits: neither half of any two keys is alike. */
static void keys_of_neighbours_differ(void)
{
    static cache_key all[2016];
    int count = 0;
    for (int high = 1; high < 64; high++)
        for (int low = 0; low < high; low++) {
            uint64_t word = 1ull << high | 1ull << low;
            cache_key key = cache_key_start("w");
            cache_key_add(&key, &word, sizeof word);
            for (int i = 0; i < count; i++)
                CHECK(key.a != all[i].a && key.b != all[i].b);
            all[count++] = key;
        }
    CHECK_EQ(count, 2016);
}

static void what_is_stored_is_found_again(void)
{
    empty();
    cache_key a = key_of("t", 1), b = key_of("t", 2);
    CHECK(!is_there(&a, 3, 0));
    store(&a, BYTES, 1);
    store(&b, 0, 0);
    CHECK(is_there(&a, BYTES, 1) && is_there(&b, 0, 0));
    store(&a, 20, 9);
    CHECK(is_there(&a, 20, 9)); /* the later one */
    size_t size = 21;
    CHECK(cache_load(&a, &size) == NULL); /* not as many as wanted */
    size = 20;
    void *data = cache_load(&a, &size);
    CHECK(data != NULL);
    free(data);
}

static size_t read_file(const char *path, unsigned char *out, size_t room)
{
    FILE *f = fopen(path, "rb");
    size_t size = f ? fread(out, 1, room, f) : 0;
    if (f)
        fclose(f);
    return size;
}

static void write_file(const char *path, const unsigned char *data, size_t size)
{
    FILE *f = fopen(path, "wb");
    CHECK(f && fwrite(data, 1, size, f) == size);
    if (f)
        fclose(f);
}

static void damage_is_absence(void)
{
    unsigned char good[HEAD + BYTES + 8], bad[HEAD + BYTES + 8];
    char path[512];
    cache_key key = key_of("t", 3);
    empty();
    store(&key, BYTES, 5);
    CHECK_EQ(list(path, 0), 1);
    size_t size = read_file(path, good, sizeof good);
    CHECK_EQ(size, HEAD + BYTES);
    for (size_t i = 0; i < size; i++) { /* a byte changed */
        memcpy(bad, good, size);
        bad[i] ^= (unsigned char)(1 << i % 8);
        write_file(path, bad, size);
        CHECK(!is_there(&key, BYTES, 5));
    }
    for (size_t i = 0; i < size; i++) { /* cut short */
        write_file(path, good, i);
        CHECK(!is_there(&key, BYTES, 5));
    }
    write_file(path, good, size + 1);
    CHECK(!is_there(&key, BYTES, 5));
    store(&key, BYTES, 6); /* repaired by the next one */
    CHECK(is_there(&key, BYTES, 6));
}

/* A file under another one's name: what it says of itself counts. */
static void files_do_not_change_names(void)
{
    char from[512], to[512];
    cache_key a = key_of("t", 4), b = key_of("t", 5);
    empty();
    store(&b, 8, 0);
    list(to, 1);
    store(&a, 8, 0);
    list(from, 0);
    CHECK(rename(from, to) == 0);
    CHECK(!is_there(&a, 8, 0) && !is_there(&b, 8, 0));
}

static void no_place_is_no_cache(void)
{
    cache_key key = key_of("t", 6);
    char path[512];
    empty();
    write_file(PLACE, (const unsigned char *)"x", 1); /* a file where the directory should be */
    store(&key, 8, 0);
    CHECK(!is_there(&key, 8, 0));
    setenv("XDG_CACHE_HOME", "/proc/no/such/place", 1);
    store(&key, 8, 0);
    CHECK(!is_there(&key, 8, 0));
    char *home = getenv("HOME") ? strdup(getenv("HOME")) : NULL;
    unsetenv("XDG_CACHE_HOME");
    unsetenv("HOME");
    store(&key, 8, 0);
    CHECK(!is_there(&key, 8, 0));
    setenv("HOME", PLACE "/home", 1);
    empty();
    unsetenv("XDG_CACHE_HOME");
    store(&key, 8, 0); /* ~/.cache is made */
    CHECK(is_there(&key, 8, 0));
    CHECK(access(PLACE "/home/.cache/wiggly", R_OK) == 0);
    CHECK(system("rm -r " PLACE) == 0);
    if (home)
        setenv("HOME", home, 1);
    free(home);
    empty();
    CHECK_EQ(list(path, 0), 0);
}

/* Sparse files of 400 MB stand for results: three are too many, and the oldest
 * one goes. A file that is no result is not counted and not removed. */
static void the_oldest_go_first(void)
{
    static const char *const NAMES[] = {"00000000000000000000000000000001",
                                        "00000000000000000000000000000002",
                                        "00000000000000000000000000000003", "a note"};
    cache_key key = key_of("t", 7);
    char path[512];
    empty();
    mkdir(PLACE, 0700);
    mkdir(FILES, 0700);
    for (int i = 0; i < 4; i++) {
        const struct timespec when[2] = {{1000 - 100 * (i % 3), 0}, {1000 - 100 * (i % 3), 0}};
        snprintf(path, sizeof path, FILES "/%s", NAMES[i]);
        write_file(path, (const unsigned char *)"x", 1);
        CHECK(truncate(path, 400 << 20) == 0 && utimensat(AT_FDCWD, path, when, 0) == 0);
    }
    store(&key, 8, 0);
    CHECK(is_there(&key, 8, 0));
    for (int i = 0; i < 4; i++) {
        snprintf(path, sizeof path, FILES "/%s", NAMES[i]);
        CHECK((access(path, F_OK) == 0) == (i != 2));
    }
    CHECK_EQ(list(path, 0), 4);
}

/* Two processes store other things under one key, over and over, while this one
 * reads: it finds one or the other, whole, and nothing is left behind. */
static void readers_see_whole_results(void)
{
    cache_key key = key_of("t", 8);
    pid_t child[2];
    char path[512];
    empty();
    store(&key, BYTES, 1);
    for (int i = 0; i < 2; i++) {
        child[i] = fork();
        if (child[i] == 0) {
            for (int k = 0; k < 300; k++)
                store(&key, BYTES, i + 1);
            _exit(0);
        }
    }
    for (int k = 0; k < 600; k++) {
        unsigned char want[2][BYTES], *data;
        size_t size = BYTES;
        for (int i = 0; i < 2; i++)
            pattern(want[i], BYTES, i + 1);
        data = cache_load(&key, &size);
        CHECK(data && (memcmp(data, want[0], BYTES) == 0 || memcmp(data, want[1], BYTES) == 0));
        free(data);
    }
    for (int i = 0; i < 2; i++) {
        int status = 1;
        CHECK(waitpid(child[i], &status, 0) == child[i] && status == 0);
    }
    CHECK_EQ(list(path, 0), 1);
}

static void blobs_give_back_what_was_put(void)
{
    cache_blob blob = {0};
    double x[40], y[40];
    int n = 40, m = 0;
    for (int i = 0; i < n; i++)
        x[i] = i / 7.0;
    cache_put(&blob, &n, sizeof n);
    cache_put(&blob, NULL, 0);
    cache_put(&blob, x, sizeof x);
    CHECK_EQ(blob.count, sizeof n + sizeof x);
    CHECK(cache_take(&blob, &m, sizeof m) == 0 && m == n);
    CHECK(cache_take(&blob, NULL, 0) == 0);
    CHECK(cache_take(&blob, y, sizeof y + 1) < 0);
    CHECK(cache_take(&blob, y, sizeof y) == 0 && memcmp(x, y, sizeof x) == 0);
    CHECK(cache_take(&blob, y, 1) < 0 && cache_take(&blob, y, SIZE_MAX) < 0);
    free(blob.at);
}

int main(void)
{
    mkdir("build", 0777);
    TEST(keys_tell_all_that_they_are_made_of);
    TEST(keys_of_neighbours_differ);
    TEST(what_is_stored_is_found_again);
    TEST(damage_is_absence);
    TEST(files_do_not_change_names);
    TEST(no_place_is_no_cache);
    TEST(the_oldest_go_first);
    TEST(readers_see_whole_results);
    TEST(blobs_give_back_what_was_put);
    empty();
    return check_done();
}

/* Results on disk.
 * Source: own. The hash is FNV-1a (Fowler, Noll, Vo) over 8 bytes at a time, with two multipliers.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#include "cache.h"

#include "bake.h"

#include <dirent.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define MOST_BYTES (1ull << 30)
#define PATH_BYTES 4096

static const char MAGIC[8] = "wgcache1";

/* ---- keys ------------------------------------------------------------------------------------- */

static void mix(cache_key *key, uint64_t word)
{
    key->a = (key->a ^ word) * 0x100000001b3u;
    key->a ^= key->a >> 29; /* a product carries upwards only */
    key->b = (key->b ^ word) * 0x9e3779b97f4a7c15u;
    key->b ^= key->b >> 32;
}

void cache_key_add(cache_key *key, const void *data, size_t size)
{
    const char *from = data;
    uint64_t word = size;
    mix(key, word);
    for (; size >= sizeof word; size -= sizeof word, from += sizeof word) {
        memcpy(&word, from, sizeof word);
        mix(key, word);
    }
    word = 0;
    if (size > 0) { /* of nothing there may be no address */
        memcpy(&word, from, size);
    }
    mix(key, word);
}

cache_key cache_key_start(const char *kind)
{
    cache_key key = {0xcbf29ce484222325u, 0x84222325cbf29ce4u};
    cache_key_add(&key, kind, strlen(kind));
    return key;
}

void cache_key_int(cache_key *key, int value)
{
    mix(key, (uint64_t)value);
}

void cache_key_real(cache_key *key, double value)
{
    cache_key_add(key, &value, sizeof value);
}

/* ---- files ------------------------------------------------------------------------------------ */

typedef struct {
    char magic[8];
    uint64_t size;
    cache_key key, content;
} header;

/* 0 when there is no place for a cache. */
static int directory(char path[PATH_BYTES])
{
    const char *base = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    int n = base && *base   ? snprintf(path, PATH_BYTES, "%s/wiggly", base)
            : home && *home ? snprintf(path, PATH_BYTES, "%s/.cache/wiggly", home)
                            : PATH_BYTES;
    return n < PATH_BYTES - 64;
}

static void make_directories(const char *path)
{
    char part[PATH_BYTES];
    size_t length = strlen(path);
    for (size_t i = 1; i <= length; i++) {
        if (path[i] == '/' || path[i] == 0) {
            memcpy(part, path, i);
            part[i] = 0;
            mkdir(part, 0700); /* it may be there; opening a file tells */
        }
    }
}

static int file_of(const cache_key *key, char path[PATH_BYTES])
{
    if (!directory(path)) {
        return 0;
    }
    size_t used = strlen(path);
    snprintf(path + used, PATH_BYTES - used, "/%016llx%016llx", (unsigned long long)key->a,
             (unsigned long long)key->b);
    return 1;
}

static cache_key content_of(const void *data, size_t size)
{
    cache_key key = cache_key_start("content");
    cache_key_add(&key, data, size);
    return key;
}

static void *read_all(FILE *from, const cache_key *key, size_t *size)
{
    header h;
    struct stat about;
    if (fread(&h, sizeof h, 1, from) != 1 || memcmp(h.magic, MAGIC, sizeof MAGIC) != 0 ||
        memcmp(&h.key, key, sizeof *key) != 0 || fstat(fileno(from), &about) != 0 ||
        (uint64_t)about.st_size != h.size + sizeof h || (*size && *size != h.size)) {
        return NULL;
    }
    void *data = bake_alloc((size_t)h.size + 1, 1);
    cache_key content;
    int good = fread(data, 1, (size_t)h.size, from) == h.size;
    content = content_of(data, (size_t)h.size);
    if (!good || memcmp(&content, &h.content, sizeof content) != 0) {
        free(data);
        return NULL;
    }
    *size = (size_t)h.size;
    return data;
}

void *cache_load(const cache_key *key, size_t *size)
{
    char path[PATH_BYTES];
    FILE *from = file_of(key, path) ? fopen(path, "rb") : NULL;
    if (from == NULL) {
        return NULL;
    }
    void *data = read_all(from, key, size);
    fclose(from);
    if (data) {
        utimensat(AT_FDCWD, path, NULL, 0); /* used now: the oldest go first */
    }
    return data;
}

/* ---- room ------------------------------------------------------------------------------------- */

typedef struct {
    char name[64];
    struct timespec used;
    uint64_t size;
} entry;

static int by_age(const void *a, const void *b)
{
    const entry *x = a, *y = b;
    if (x->used.tv_sec != y->used.tv_sec) {
        return x->used.tv_sec < y->used.tv_sec ? -1 : 1;
    }
    return x->used.tv_nsec < y->used.tv_nsec ? -1 : x->used.tv_nsec > y->used.tv_nsec;
}

static void make_room(const char *path)
{
    DIR *d = opendir(path);
    entry *all = NULL;
    size_t count = 0;
    uint64_t total = 0;
    for (struct dirent *e = d ? readdir(d) : NULL; e; e = readdir(d)) {
        struct stat about;
        if (strlen(e->d_name) >= 32 && strlen(e->d_name) < sizeof all->name &&
            fstatat(dirfd(d), e->d_name, &about, 0) == 0) {
            all = bake_grow(all, count + 1, sizeof *all);
            snprintf(all[count].name, sizeof all->name, "%.63s", e->d_name);
            all[count].used = about.st_mtim;
            all[count++].size = (uint64_t)about.st_size;
            total += (uint64_t)about.st_size;
        }
    }
    if (count > 0) {
        qsort(all, count, sizeof *all, by_age);
    }
    for (size_t i = 0; i < count && total > MOST_BYTES; i++) {
        unlinkat(dirfd(d), all[i].name, 0);
        total -= all[i].size;
    }
    free(all);
    if (d) {
        closedir(d);
    }
}

/* A cache that cannot be written is none. */
void cache_store(const cache_key *key, const void *data, size_t size)
{
    char path[PATH_BYTES], temporary[PATH_BYTES + 32], place[PATH_BYTES];
    header h = {.size = size, .key = *key, .content = content_of(data, size)};
    memcpy(h.magic, MAGIC, sizeof MAGIC);
    if (!directory(place) || !file_of(key, path)) {
        return;
    }
    make_directories(place);
    snprintf(temporary, sizeof temporary, "%s.%ld", path, (long)getpid());
    FILE *to = fopen(temporary, "wb");
    if (to == NULL) {
        return;
    }
    int good = fwrite(&h, sizeof h, 1, to) == 1 && fwrite(data, 1, size, to) == size;
    good = fclose(to) == 0 && good;
    if (!good || rename(temporary, path) != 0) {
        unlink(temporary);
    }
    make_room(place);
}

/* ---- blobs ------------------------------------------------------------------------------------ */

void cache_put(cache_blob *blob, const void *data, size_t size)
{
    if (blob->count + size > blob->room) {
        blob->room = 2 * (blob->count + size);
        blob->at = bake_grow(blob->at, blob->room, 1);
    }
    if (size > 0) {
        memcpy(blob->at + blob->count, data, size);
    }
    blob->count += size;
}

int cache_take(cache_blob *blob, void *data, size_t size)
{
    if (size > blob->count - blob->next) {
        return -1;
    }
    if (size > 0) {
        memcpy(data, blob->at + blob->next, size);
    }
    blob->next += size;
    return 0;
}

/* What took long and may be wanted again: results on disk, found by a hash of all that they depend
 * on.
 * In $XDG_CACHE_HOME/wiggly or ~/.cache/wiggly, at most 1 GB; the oldest go first. Deleting it
 * costs time alone, and a file that is damaged is one that is not there.
 * SPDX-License-Identifier: AGPL-3.0-or-later */
#ifndef BAKE_CACHE_H
#define BAKE_CACHE_H

#include <stddef.h>
#include <stdint.h>

/* FNV-1a, twice 64 bits with different starts and multipliers of words: not against malice. */
typedef struct {
    uint64_t a, b;
} cache_key;

/* kind: a word and a version, such as "modes 1": change the version with the arithmetic. */
cache_key cache_key_start(const char *kind);
void cache_key_add(cache_key *key, const void *data, size_t size);
void cache_key_int(cache_key *key, int value);
void cache_key_real(cache_key *key, double value);

/* The bytes stored under a key, the caller's; NULL when there are none, or not `size` of them (0:
 * any;
 * *size then says how many). */
void *cache_load(const cache_key *key, size_t *size);
void cache_store(const cache_key *key, const void *data, size_t size);

/* Blobs of several arrays: appended in order, taken in the same order. */
typedef struct {
    char *at;
    size_t count, room, next;
} cache_blob;
void cache_put(cache_blob *blob, const void *data, size_t size);
/* 0, or -1 when so many bytes are not there. */
int cache_take(cache_blob *blob, void *data, size_t size);

#endif

/* SPDX-License-Identifier: MIT */
/* The room "index": finds a thing by its name, however many names there are. */
#ifndef INDEX_H
#define INDEX_H

#include "data/base/base.h"
#include "spectral.h"

/* ---- index.c: a hash table from keys to numbers ---- */

/* Numbers by their keys, strings of any bytes. The time to find a key does not grow with the number
 * of keys. Zeroed it is empty. It keeps copies of the keys. */
struct index {
    struct index_slot *slots; /* owned */
    size_t n_slots, n_keys;   /* n_slots: 0 or a power of two, above n_keys */
    char *keys;               /* one behind the other; owned */
    size_t length, room;      /* bytes of the keys, and bytes that `keys` has room for */
    uint64_t seed;            /* another one in each index: no input can make all keys collide */
};
/* Returns the number of a key; -1: the index does not have it. */
int index_find(const struct index *index, const void *key, size_t length);
/* Adds a key that the index does not have, with its number, 0 or above. A failure, for lack of
 * memory, changes nothing. */
bool index_add(struct index *index, const void *key, size_t length, int number, struct error *err);
void index_free(struct index *index);
/* Returns a number whose every bit depends on every bit of the argument. */
uint64_t hash_bits(uint64_t bits);

#endif

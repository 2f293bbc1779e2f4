/* SPDX-License-Identifier: MIT */
/* A hash table with open addressing: a key lies in the first free slot from the one that its hash
 * names. At least half of the slots are free, so that a search soon meets a free one. */
#include "data/base/base.h"

/* A slot is free if its hash is 0; no key has that hash. */
struct index_slot {
    uint64_t hash;
    size_t key, length; /* where the key begins among the keys, and its bytes */
    int number;
};

/* The finalizer of MurmurHash3, which its author has put into the public domain. */
uint64_t hash_bits(uint64_t bits)
{
    bits = (bits ^ bits >> 33) * 0xff51afd7ed558ccdU;
    bits = (bits ^ bits >> 33) * 0xc4ceb9fe1a85ec53U;
    return bits ^ bits >> 33;
}

static uint64_t hash_of(const struct index *index, const char *key, size_t length)
{
    uint64_t hash = hash_bits(index->seed ^ length), part;
    for (; length > 0; key += sizeof part) {
        const size_t n = length < sizeof part ? length : sizeof part;
        part = 0;
        memcpy(&part, key, n);
        hash = hash_bits(hash ^ part);
        length -= n;
    }
    return hash > 0 ? hash : 1;
}

/* Returns the slot of the key, or the free one where it would be. */
static struct index_slot *slot_of(const struct index *index, uint64_t hash, const void *key,
                                  size_t length)
{
    size_t i = (size_t)hash & (index->n_slots - 1);
    for (;; i = (i + 1) & (index->n_slots - 1)) {
        struct index_slot *slot = &index->slots[i];
        if (slot->hash == 0 || (slot->hash == hash && slot->length == length &&
                                memcmp(index->keys.text + slot->key, key, length) == 0))
            return slot;
    }
}

int index_find(const struct index *index, const void *key, size_t length)
{
    if (index->n_keys == 0)
        return -1;
    const struct index_slot *slot = slot_of(index, hash_of(index, key, length), key, length);
    return slot->hash != 0 ? slot->number : -1;
}

/* Doubles the slots, and puts each key into its new one. */
static bool grow_slots(struct index *index, struct error *err)
{
    const struct index before = *index;
    const size_t n = before.n_slots > 0 ? 2 * before.n_slots : 16;
    struct index_slot *slots;
    if (!MAKE_ARRAY(slots, n, err, "the places of %zu names", n / 2))
        return false;
    if (before.n_slots == 0)
        index->seed = hash_bits((uint64_t)(uintptr_t)slots ^ hash_bits((uint64_t)(uintptr_t)index));
    index->slots = slots;
    index->n_slots = n;
    for (size_t i = 0; i < before.n_slots; i++) {
        const struct index_slot *slot = &before.slots[i];
        if (slot->hash != 0)
            *slot_of(index, slot->hash, index->keys.text + slot->key, slot->length) = *slot;
    }
    free(before.slots);
    return true;
}

bool index_add(struct index *index, const void *key, size_t length, int number, struct error *err)
{
    const size_t place = index->keys.length;
    if (2 * (index->n_keys + 1) > index->n_slots && !grow_slots(index, err))
        return false;
    print_bytes(&index->keys, key, length);
    if (index->keys.failed)
        return memory_lacks(err, (double)index->keys.capacity, "%zu names", index->n_keys);
    const uint64_t hash = hash_of(index, key, length);
    *slot_of(index, hash, key, length) =
        (struct index_slot){.hash = hash, .key = place, .length = length, .number = number};
    index->n_keys++;
    return true;
}

void index_free(struct index *index)
{
    FREE_ALL(index->slots, index->keys.text);
    *index = (struct index){.n_keys = 0};
}

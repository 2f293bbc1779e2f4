/* SPDX-License-Identifier: MIT */
/* A hash table, compared with a list: keys of all lengths, with bytes of all values. */

#include "data/base/base.h"
#include "test.h"

enum { KEYS = 20000 };

/* Writes key i: its number, and up to 23 more bytes. Returns its length. */
static size_t key_of(int i, unsigned char key[32])
{
    const size_t length = (size_t)(i % 24) + sizeof i;
    memcpy(key, &i, sizeof i);
    for (size_t k = sizeof i; k < length; k++)
        key[k] = (unsigned char)(i * 7 + (int)k);
    return length;
}

static void check_many(void)
{
    struct index index = {.n_keys = 0};
    struct error err = {.text = ""};
    unsigned char key[32];
    int right = 0, absent = 0;
    for (int i = 0; i < KEYS; i++) {
        const size_t length = key_of(i, key);
        absent += index_find(&index, key, length) == -1;
        if (!index_add(&index, key, length, KEYS - i, &err))
            break;
    }
    CHECK(absent == KEYS, "a key is not found before it is added");
    for (int i = 0; i < KEYS; i++)
        right += index_find(&index, key, key_of(i, key)) == KEYS - i;
    CHECK(right == KEYS, "each of %d keys is found with its number", KEYS);
    absent = 0;
    for (int i = KEYS; i < 2 * KEYS; i++)
        absent += index_find(&index, key, key_of(i, key)) == -1;
    CHECK(absent == KEYS, "other keys are not found");
    index_free(&index);
    CHECK(index_find(&index, key, 4) == -1, "a freed index is empty");
}

static void check_few(void)
{
    struct index index = {.n_keys = 0};
    struct error err = {.text = ""};
    char key[] = "gold";
    CHECK(index_find(&index, "", 0) == -1, "an empty index has no empty key");
    CHECK(index_add(&index, "", 0, 0, &err) && index_find(&index, "", 0) == 0,
          "the empty key is a key");
    CHECK(index_add(&index, key, 4, 5, &err), "a key is added");
    key[0] = 'c';
    CHECK(index_find(&index, "gold", 4) == 5 && index_find(&index, key, 4) == -1,
          "an index keeps copies of its keys");
    CHECK(index_find(&index, "gol", 3) == -1 && index_find(&index, "gold\0", 5) == -1,
          "keys are compared whole, with NULs at their end");
    index_free(&index);
}

int main(void)
{
    check_few();
    check_many();
    return test_end();
}

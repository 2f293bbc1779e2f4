/* SPDX-License-Identifier: MIT */
/* Numbers in files have their lowest byte first. Some machines have the highest one first in
 * memory. */
#include <string.h>

#include "data/base/base.h"

bool machine_is_big_endian(void)
{
    const uint16_t one = 1;
    return *(const unsigned char *)&one == 0;
}

void store_numbers(void *out, const void *numbers, size_t size, size_t length)
{
    const char *from = numbers;
    char *to = out;
    if (!machine_is_big_endian())
        memcpy(out, numbers, length);
    else
        for (size_t i = 0; i < length; i++)
            to[i] = from[i ^ (size - 1)];
}

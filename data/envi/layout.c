/* SPDX-License-Identifier: MIT */
/* ENVI's types of samples, and the three orders in which samples lie. */
#include "data/envi/envi.h"

static const struct {
    int bytes;
    const char *name;
} types[ENVI_TYPES] = {
    [ENVI_UINT8] = {1, "unsigned 8-bit"},   [ENVI_INT16] = {2, "signed 16-bit"},
    [ENVI_INT32] = {4, "signed 32-bit"},    [ENVI_FLOAT] = {4, "32-bit float"},
    [ENVI_DOUBLE] = {8, "64-bit float"},    [ENVI_UINT16] = {2, "unsigned 16-bit"},
    [ENVI_UINT32] = {4, "unsigned 32-bit"}, [ENVI_INT64] = {8, "signed 64-bit"},
    [ENVI_UINT64] = {8, "unsigned 64-bit"}};

int envi_type_bytes(enum envi_type type)
{
    return (unsigned)type < ENVI_TYPES ? types[type].bytes : 0;
}

const char *envi_type_name(enum envi_type type)
{
    return types[type].name;
}

const char *envi_interleave_name(enum envi_interleave interleave)
{
    static const char *const names[] = {"bsq", "bil", "bip"};
    return names[interleave];
}

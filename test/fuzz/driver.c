/* SPDX-License-Identifier: MIT */
/* libFuzzer calls this function with each input. $FUZZ_TARGET names the target. */
#include <stdint.h>
#include <stdlib.h>

#include "test/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t length);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t length)
{
    const char *name = getenv("FUZZ_TARGET");
    const struct fuzz_target *target = fuzz_target(name != NULL ? name : "");
    fuzz_holds(target != NULL, "$FUZZ_TARGET names a target");
    fuzz_run(target, bytes, length);
    return 0;
}

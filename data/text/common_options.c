/* SPDX-License-Identifier: MIT */
/* Options that many commands take. */
#include "data/text/text.h"

static const struct option common[] = {
    {"--memory MIB", "MiB of memory that a command may take beyond a tile's 300 (default: 1024)",
     SHARED(COUNT, memory_mib), .lowest = 1, .highest = 1 << 24},
    {"-h, --help", "prints the help of this command; spectral -V, --version prints the versions",
     SHARED(FLAG, help)},
};
static const struct option threads[] = {
    {"-j, --threads N", "threads to compute with (default: one per processor)",
     SHARED(COUNT, threads), .lowest = 1, .highest = 1024},
};
static const struct option json[] = {
    {"--json FILE", "writes the results as JSON; - is standard output", SHARED(TEXT, json),
     .writes = true},
};
static const struct option quiet[] = {
    {"-q, --quiet", "prints no table and no progress", SHARED(FLAG, quiet)},
};
static const struct option seeing[] = {
    {"--detector, --observer NAME", "sees with it (default: cie1931); a camera only in develop",
     SHARED(TEXT, detector)},
    {"--white SPECTRUM", "the light of the white (default: those that the stack records)",
     SHARED(TEXT, white)},
};
const struct option_list common_options = OPTION_LIST(common),
                         threads_option = OPTION_LIST(threads), json_option = OPTION_LIST(json),
                         quiet_option = OPTION_LIST(quiet), seeing_options = OPTION_LIST(seeing);

/* SPDX-License-Identifier: MIT */
/* For libraries that LD_PRELOAD places before others. */
#ifndef PRELOAD_H
#define PRELOAD_H

#include <dlfcn.h>
#include <stdint.h>

/* The function of this name in the library behind this one. ISO C does not allow a cast from an
 * object pointer to a function pointer; POSIX promises that dlsym's works. */
#define REAL(name) ((__typeof__(name) *)(uintptr_t)dlsym(RTLD_NEXT, #name))

#endif

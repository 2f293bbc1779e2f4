/* SPDX-License-Identifier: MIT */
#include "spectral.h"

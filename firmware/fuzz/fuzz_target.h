/* SPDX-License-Identifier: Apache-2.0 */

/* What libFuzzer calls with its inputs, and replay.c with those that are kept. */

#ifndef ARCTRUE_FUZZ_TARGET_H
#define ARCTRUE_FUZZ_TARGET_H

#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#endif

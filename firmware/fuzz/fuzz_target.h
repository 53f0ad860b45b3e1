/* SPDX-License-Identifier: Apache-2.0 */

/* Declares the entry point that libFuzzer calls with its inputs, and that replay.c calls with the stored inputs. */

#ifndef ARCTRUE_FUZZ_TARGET_H
#define ARCTRUE_FUZZ_TARGET_H

#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#endif

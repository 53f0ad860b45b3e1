/* SPDX-License-Identifier: Apache-2.0 */

/* Provides the compiler's conversions from 64-bit integers to double. The library's object file with these conversions
   also contains a software addition of doubles, which takes 0.9 KB and is not needed here. */

#include <stdint.h>

/* The compiler calls these functions with the arguments and results of a processor without a floating-point unit. */
#ifdef __arm__
#define RUNTIME __attribute__((pcs("aapcs")))
#else
#define RUNTIME
#endif

#define TWO_TO_32 4294967296.0

RUNTIME double __aeabi_ul2d(uint64_t value);
RUNTIME double __aeabi_l2d(int64_t value);

/* Both products are exact, so only the sum is rounded. */
double __aeabi_ul2d(uint64_t value) {
    return (double)(uint32_t)(value >> 32) * TWO_TO_32 + (double)(uint32_t)value;
}

double __aeabi_l2d(int64_t value) {
    return (double)(int32_t)(value >> 32) * TWO_TO_32 + (double)(uint32_t)value;
}

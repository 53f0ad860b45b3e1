/* SPDX-License-Identifier: Apache-2.0 */

/* ASSERT(condition): what must never be otherwise, whatever comes from outside. On the chip a condition that
   fails is a fault like any other: record, console, a new start. On a host it ends the process. */

#ifndef ARCTRUE_ASSERTION_H
#define ARCTRUE_ASSERTION_H

/* Permanently undefined in Thumb (Armv7-A, UDF): the fault handler knows an assertion by it. */
#define ASSERTION_OPERAND 0xA5
#define ASSERTION_INSTRUCTION (0xDE00U | ASSERTION_OPERAND)

#if __STDC_HOSTED__

#include <stdio.h>
#include <stdlib.h>

#define ASSERT(condition) \
    ((condition) \
         ? (void)0 \
         : ((void)fprintf(stderr, "%s:%d: assertion fails: %s\n", __FILE__, __LINE__, #condition), \
            abort()))

#else

/* The line makes each a text of its own: the compiler joins none, and the address says which it is. */
#define ASSERT(condition) \
    do { \
        if (!(condition)) { \
            __asm__ volatile("udf %c0 @ line %c1" ::"i"(ASSERTION_OPERAND), "i"(__LINE__)); \
            __builtin_unreachable(); \
        } \
    } while (0)

#endif

#endif

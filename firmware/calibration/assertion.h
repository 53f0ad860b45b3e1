/* SPDX-License-Identifier: Apache-2.0 */

/* ASSERT(condition) checks a condition that must hold for any input. On the chip, a condition that fails is handled
   like any other fault: the fault handler stores a record of the fault, prints a line on the console, and restarts the
   firmware. On a host a condition that fails ends the process. */

#ifndef ARCTRUE_ASSERTION_H
#define ARCTRUE_ASSERTION_H

/* Permanently undefined instruction in Thumb (Armv7-A, UDF); the fault handler recognises a failed assertion by this
   instruction. */
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

/* The line number makes each assembly text unique, so that the compiler merges no two assertions and the address
   identifies the failed one. */
#define ASSERT(condition) \
    do { \
        if (!(condition)) { \
            __asm__ volatile("udf %c0 @ line %c1" ::"i"(ASSERTION_OPERAND), "i"(__LINE__)); \
            __builtin_unreachable(); \
        } \
    } while (0)

#endif

#endif

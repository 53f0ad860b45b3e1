/* SPDX-License-Identifier: Apache-2.0 */

/* Start-up code between the boot ROM and C: sets up vectors, stacks, caches, translation tables and
   floating point.

   The boot ROM hands over with the on-chip memory at 0 and caches and MMU off; a debugger may hand
   over any state, so this code assumes none. It enables the MMU before any C code runs: while the
   MMU is off, every access is strongly ordered and must be aligned. The level-2 cache stays off,
   because it does not serve the on-chip memory. */

    .syntax unified
    .arch armv7-a
    .fpu neon
    .arm

    .equ MODE_IRQ, 0x12
    .equ MODE_SVC, 0x13
    .equ MODE_ABT, 0x17
    .equ MODE_UND, 0x1B
    .equ INTERRUPTS_OFF, 0xC0

    .section .vectors, "ax"
    .global vectors
vectors:
    b start
    b undefined_instruction
    b supervisor_call
    b prefetch_abort
    b data_abort
    b .
    b interrupt_request
    b .

    .text

    /* The entry address is a multiple of 64, because public tools require this alignment of a boot
       image. */
    .balign 64
    /* The firmware also restarts here after a fault, so this code assumes no reset. */
    .global start
    .type start, %function
start:
    cpsid aif
    mrc p15, 0, r0, c0, c0, 5       /* MPIDR: the other core sleeps */
    ands r0, r0, #3
other_core:
    wfene
    bne other_core

    /* Branch prediction is disabled first: while the MMU is off, it could fetch from any address
       (erratum 794073 of the Cortex-A9). */
    mov r0, #0
    mcr p15, 0, r0, c7, c5, 6
    mrc p15, 0, r0, c1, c0, 0       /* SCTLR */
    bic r0, r0, #0x0800
    mcr p15, 0, r0, c1, c0, 0
    dsb
    isb
    bic r0, r0, #0x1000             /* instruction cache, MMU, alignment, data cache off; */
    bic r0, r0, #0x0007
    bic r0, r0, #0x70000000         /* exceptions in ARM state; no access flag, no remapping; */
    bic r0, r0, #0x02000000         /* little endian; */
    bic r0, r0, #0x2000             /* vectors at the address in VBAR */
    mcr p15, 0, r0, c1, c0, 0
    isb
    ldr r0, =vectors
    mcr p15, 0, r0, c12, c0, 0

    /* Each mode has its own stack. The C program runs in supervisor mode; the page below its stack
       is not mapped. */
    ldr r0, =stack_top_exceptions
    cps #MODE_IRQ
    mov sp, r0
    sub r0, r0, #512
    cps #MODE_ABT
    mov sp, r0
    sub r0, r0, #512
    cps #MODE_UND
    mov sp, r0
    cps #MODE_SVC
    ldr sp, =stack_top

    mov r0, #0
    mcr p15, 0, r0, c8, c7, 0       /* TLB, instruction cache, branch predictor */
    mcr p15, 0, r0, c7, c5, 0
    mcr p15, 0, r0, c7, c5, 6
    bl invalidate_data_cache

    ldr r0, =translation_table
    orr r0, r0, #0x48               /* table walks use the cache */
    mcr p15, 0, r0, c2, c0, 0
    mov r0, #0x24
    mcr p15, 0, r0, c2, c0, 2       /* TTBCR: the table covers the first 256 MB only */
    mov r0, #1
    mcr p15, 0, r0, c3, c0, 0       /* domain 0: permissions are checked */
    dsb
    isb
    mrc p15, 0, r0, c1, c0, 0
    orr r0, r0, #0x1800             /* instruction cache, branch prediction */
    orr r0, r0, #0x0005             /* data cache, MMU */
    mcr p15, 0, r0, c1, c0, 0
    isb

    mrc p15, 0, r0, c1, c0, 2       /* CPACR: coprocessors 10 and 11 */
    orr r0, r0, #0xF00000
    mcr p15, 0, r0, c1, c0, 2
    isb
    mov r0, #0x40000000
    vmsr fpexc, r0
    mov r0, #0
    vmsr fpscr, r0

    ldr r0, =bss_start
    ldr r1, =bss_end
    mov r2, #0
clear:
    cmp r0, r1
    strlo r2, [r0], #4
    blo clear
    ldr r0, =upper_start
    ldr r1, =upper_end
clear_upper:
    cmp r0, r1
    strlo r2, [r0], #4
    blo clear_upper
    ldr r0, =data_start
    ldr r1, =data_end
    ldr r3, =data_image
copy:
    cmp r0, r1
    ldrlo r2, [r3], #4
    strlo r2, [r0], #4
    blo copy

    bl main
    b .

/* Invalidates by set and way: 256 sets, 4 ways, lines of 32 bytes. The content at power-on is
   undefined. */
invalidate_data_cache:
    mov r0, #0
    mcr p15, 2, r0, c0, c0, 0
    mov r1, #0
way:
    mov r2, #0
set:
    orr r3, r1, r2
    mcr p15, 0, r3, c7, c6, 2
    add r2, r2, #32
    cmp r2, #8192
    blo set
    adds r1, r1, #0x40000000
    bcc way
    dsb
    bx lr

/* Passes a fault to C, which does not return: its kind (r0), the instruction (r1), the accessed
   address (r2) and the fault status (r3). */
    .macro fault name, code, back
\name:
    sub r1, lr, #\back
    mov r0, #\code
    mrc p15, 0, r2, c6, c0, 0
    mrc p15, 0, r3, c5, c0, 0
    b fault_taken
    .endm

    /* All C code is Thumb: for the first two exceptions lr is two bytes beyond the instruction. */
    fault undefined_instruction, 1, 2
    fault supervisor_call, 2, 2
    fault prefetch_abort, 3, 4
    fault data_fault, 4, 8

/* The load at probing_load may fail; it then returns 0. No other abort returns, so no registers are
   saved. */
data_abort:
    sub r1, lr, #8
    ldr r0, =probing_load
    cmp r0, r1
    bne data_fault
    mov r0, #0
    subs pc, lr, #4

/* uint32_t register_probe(uintptr_t seen). It saves the link register on the stack: in abort mode,
   an abort of the load overwrites it. */
    .global register_probe
    .type register_probe, %function
register_probe:
    push {r4, lr}
probing_load:
    ldr r0, [r0]
    pop {r4, pc}

/* Floating-point registers are saved too, because C code may use them at any time. */
interrupt_request:
    sub lr, lr, #4
    srsdb sp!, #MODE_SVC
    cps #MODE_SVC
    push {r0-r3, r12, lr}
    vpush {d0-d7}
    vpush {d16-d31}
    vmrs r0, fpscr
    mov r1, sp
    bic sp, sp, #7
    push {r0, r1}
    ldr r0, [r1, #216]              /* the interrupted instruction: above the registers pushed here */
    bl interrupt_taken
    pop {r0, r1}
    mov sp, r1
    vmsr fpscr, r0
    vpop {d16-d31}
    vpop {d0-d7}
    pop {r0-r3, r12, lr}
    rfeia sp!

/* The tables are in constant memory, because they never change. */
    .equ PAGE_CODE, 0x25E           /* normal, write-back, read only */
    .equ PAGE_TEXTS, 0x25F          /* normal, write-back, read only, not executable */
    .equ PAGE_DATA, 0x5F            /* normal, write-back, not executable */
    .equ SECTION_DEVICE, 0x416      /* device, not executable */

    .equ SECTION_READ_ONLY, 0x8416  /* device, not executable, read only */

    /* The table covers the first 256 MB only, so that it has 1 KB instead of 16 KB; TTBCR makes
       every access beyond them a fault. The program sees a device at the address that seen_at() of
       memory_mapped.h returns: section S at (S ^ S >> 4 & 0xF0) & 0xFF. */
    .section .pages, "a"
    .balign 1024
translation_table:
    .word page_table + 1
    .rept 0x30 - 0x01
    .word 0
    .endr
    .set megabyte, 0xFC0            /* seen from 0x03000000 on: flash, by linear addressing */
    .rept 0x10
    .word (megabyte << 20) | SECTION_READ_ONLY
    .set megabyte, megabyte + 1
    .endr
    .word (0x400 << 20) | SECTION_DEVICE    /* seen at 0x04000000: the core. No other window of the */
    .rept 0x70 - 0x41                       /* fabric is mapped: without a device an access never ends */
    .word 0
    .endr
    .set megabyte, 0xF80            /* seen from 0x07000000 on: system control, interrupt controller, timers */
    .rept 0x10
    .word (megabyte << 20) | SECTION_DEVICE
    .set megabyte, megabyte + 1
    .endr
    .rept 0xE0 - 0x80
    .word 0
    .endr
    .word (0xE00 << 20) | SECTION_DEVICE    /* seen at 0x0E000000: UARTs and other peripherals */
    .rept 0x100 - 0xE1
    .word 0
    .endr

    .balign 1024
page_table:
    .set page, 0                    /* see the memory map in on_chip_memory.ld */
    .rept 0x1B
    .word (page << 12) | PAGE_CODE
    .set page, page + 1
    .endr
    .rept 0x1F - 0x1B
    .word (page << 12) | PAGE_TEXTS
    .set page, page + 1
    .endr
    .rept 0x21 - 0x1F               /* the stacks are mapped further up */
    .word 0
    .endr
    .set page, 0x21
    .rept 0x30 - 0x21
    .word (page << 12) | PAGE_DATA
    .set page, page + 1
    .endr
    .rept 0x32 - 0x30               /* below the stacks */
    .word 0
    .endr
    .set page, 0x1F                 /* STACK_SEEN */
    .rept 0x35 - 0x32
    .word (page << 12) | PAGE_DATA
    .set page, page + 1
    .endr
    .rept 0x40 - 0x35
    .word 0
    .endr
    .set page, 0xFFFF0              /* UPPER_SEEN: on-chip memory up to the end of all addresses */
    .rept 0x10
    .word (page << 12) | PAGE_DATA
    .set page, page + 1
    .endr
    .rept 0x100 - 0x50
    .word 0
    .endr

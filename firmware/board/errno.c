/* SPDX-License-Identifier: Apache-2.0 */

/* Returns the memory in which the C library's wrappers of sqrt() and atan2() store an error; no code reads it. The
   library's own errno would add a kilobyte of data and a kilobyte of initial values. */

int *__errno(void);

int *__errno(void) {
    static int unread;
    return &unread;
}

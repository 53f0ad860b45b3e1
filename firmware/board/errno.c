/* SPDX-License-Identifier: Apache-2.0 */

/* Where the C library's wrappers of sqrt() and atan2() leave an error that nobody reads: its own place
   for it brings a kilobyte of data with it, and as much of initial values. */

int *__errno(void);

int *__errno(void) {
    static int unread;
    return &unread;
}

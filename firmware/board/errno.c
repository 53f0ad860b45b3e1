/* SPDX-License-Identifier: Apache-2.0 */

/* Memory in which the C library's wrappers of sqrt() and atan2() store an error, which nobody reads. The library's own
   errno would add a kilobyte of data and a kilobyte of initial values. */

int *__errno(void);

int *__errno(void) {
    static int unread;
    return &unread;
}

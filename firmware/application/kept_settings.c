/* SPDX-License-Identifier: Apache-2.0 */

#include "kept_settings.h"

#include <stddef.h>
#include <string.h>

#include "crc32.h"

_Static_assert(offsetof(struct settings_copy, check) % sizeof(uint32_t) == 0, "whole words");

static uint32_t check_of(const struct settings_copy *copy) {
    const unsigned char *bytes = (const unsigned char *)copy;
    uint32_t crc = 0;
    for (size_t place = 0; place < offsetof(struct settings_copy, check); place += sizeof crc) {
        uint32_t word;
        memcpy(&word, bytes + place, sizeof word);
        crc = crc32_add_word(crc, word);
    }
    return crc;
}

static bool is_whole(const struct settings_copy *copy) {
    const struct settings *settings = &copy->settings;
    return copy->size == sizeof *copy && copy->check == check_of(copy) &&
           settings->frozen <= 1 && settings->bypassed <= 1 && settings->telemetry <= 1 &&
           parameters_are_valid(&settings->parameters);
}

/* NULL: neither is whole. */
static const struct settings_copy *later_copy(const struct kept_settings *kept) {
    const struct settings_copy *first = &kept->copy[0];
    const struct settings_copy *second = &kept->copy[1];
    if (!is_whole(first) || !is_whole(second)) {
        return is_whole(first) ? first : (is_whole(second) ? second : NULL);
    }
    return (int32_t)(second->sequence - first->sequence) > 0 ? second : first;
}

bool kept_settings_read(const struct kept_settings *kept, struct settings *settings) {
    const struct settings_copy *later = later_copy(kept);
    if (later == NULL) {
        return false;
    }
    *settings = later->settings;
    return true;
}

void kept_settings_write(struct kept_settings *kept, const struct settings *settings) {
    const struct settings_copy *later = later_copy(kept);
    struct settings_copy *other = &kept->copy[later == &kept->copy[0]];
    /* Its sum no longer fits while it is written. */
    other->check = ~other->check;
    memset(other, 0, offsetof(struct settings_copy, check));
    other->size = sizeof *other;
    other->sequence = later != NULL ? later->sequence + 1U : 0U;
    other->settings = *settings;
    other->check = check_of(other);
}

/* SPDX-License-Identifier: Apache-2.0 */

#include "kept_settings.h"

#include <stddef.h>
#include <string.h>

#include "crc32.h"

_Static_assert(offsetof(struct settings_copy, check) % sizeof(uint32_t) == 0, "whole words");

static uint32_t kept_settings_check(const struct settings_copy *copy) {
    const unsigned char *bytes = (const unsigned char *)copy;
    uint32_t crc = 0;
    for (size_t place = 0; place < offsetof(struct settings_copy, check); place += sizeof crc) {
        uint32_t word;
        memcpy(&word, bytes + place, sizeof word);
        crc = crc32_add_word(crc, word);
    }
    return crc;
}

static bool kept_settings_is_whole(const struct settings_copy *copy) {
    const struct settings *settings = &copy->settings;
    return copy->size == sizeof *copy && copy->check == kept_settings_check(copy) &&
           settings->frozen <= 1 && settings->bypassed <= 1 && settings->telemetry <= 1 &&
           parameters_are_valid(&settings->parameters);
}

/* Returns the valid copy that was written last, or NULL if neither copy is valid. */
static const struct settings_copy *kept_settings_later(const struct kept_settings *kept) {
    const struct settings_copy *first = &kept->copy[0];
    const struct settings_copy *second = &kept->copy[1];
    if (!kept_settings_is_whole(first) || !kept_settings_is_whole(second)) {
        return kept_settings_is_whole(first) ? first
                                             : (kept_settings_is_whole(second) ? second : NULL);
    }
    return (int32_t)(second->sequence - first->sequence) > 0 ? second : first;
}

bool kept_settings_read(const struct kept_settings *kept, struct settings *settings) {
    const struct settings_copy *later = kept_settings_later(kept);
    if (later == NULL) {
        return false;
    }
    *settings = later->settings;
    return true;
}

void kept_settings_write(struct kept_settings *kept, const struct settings *settings) {
    const struct settings_copy *later = kept_settings_later(kept);
    struct settings_copy *other = &kept->copy[later == &kept->copy[0]];
    /* Makes the check sum wrong while the copy is being written. */
    other->check = ~other->check;
    memset(other, 0, offsetof(struct settings_copy, check));
    other->size = sizeof *other;
    other->sequence = later != NULL ? later->sequence + 1U : 0U;
    other->settings = *settings;
    other->check = kept_settings_check(other);
}

/* SPDX-License-Identifier: Apache-2.0 */

#include "saving.h"

#include <stddef.h>
#include <string.h>

#include "local_table.h"
#include "prepared.h"
#include "settings.h"

void saving_recover(struct application *application) {
    if (application->save == NULL || !save_find(application->save)) {
        return;
    }
    const struct saved *saved = &application->save->content;
    bool holds = saved_lanes(saved) > 0 || saved->table.place.choice != 0;
    application->saved_state = holds ? SAVED_WAITING : SAVED_NONE;
    if (application->settings_origin == SETTINGS_PRESET) {
        application->settings_origin = SETTINGS_SAVED;
        settings_take(application, &saved->settings);
    } else if (application->settings_origin == SETTINGS_LOST) {
        application->parameters = saved->settings.parameters;
    }
}

/* Tells whether the device itself calibrated the mean whose lanes are active or were active before the core restarted.
   Compares only the words of the means, because the active lanes of a loaded mean may have been computed for another
   temperature than the loaded lanes. */
static bool saving_has_own_mean(const struct application *application) {
    const struct mean_set *mean = &application->active.mean;
    return mean->heads != 0 && memcmp(mean, &application->load.loaded.mean, sizeof *mean) != 0;
}

/* Takes the loaded set, even if no turn has judged it again yet, and the calibration's lanes that are active or were
   active before the core restarted. */
static void saving_take_known(const struct application *application, struct saved *saved) {
    const struct load *load = &application->load;
    bool waits = application->saved_state == SAVED_WAITING;
    bool own_mean = saving_has_own_mean(application);
    if (!waits || load_at_work(load) != NULL) {
        bool kept = load->loaded_state != LOADED_REJECTED && !own_mean;
        saved->loaded = kept ? load->loaded : (struct coefficients){0};
        saved->thermal = kept ? load->thermal : (struct thermal){0};
        saved->followed = kept ? load->followed : (struct followed){.lanes = 0};
        saved->unjudged = kept ? load->unjudged : 0;
        saved->sets.number = 0;
        if (kept) {
            prepared_keep(application, &saved->sets);
        }
        saved->table = kept ? load->table : (struct load_table){.next = 0};
    }
    if (own_mean && !waits) {
        /* The device's own mean is saved as a loaded set: a turn can judge the places of its heads, but not its single
           lanes. */
        saved->loaded = application->active;
        saved->unjudged = UINT64_MAX;
        prepared_keep(application, &saved->sets);
    }
    /* Lanes of a mean do not correct head 1, so they are not saved as lanes of the calibration. */
    saved->own =
        application->active.mean.heads == 0 ? application->active : (struct coefficients){0};
    for (uint32_t lane = 0; lane < saved->own.lanes; lane++) {
        if (coefficients_have(&saved->loaded, saved->own.lane[lane].order) ||
            coefficients_have(&load->loaded, saved->own.lane[lane].order)) {
            saved->own.lane[lane] = (struct lane){0};
        }
    }
}

/* Tells whether the idle bank holds the points of the table to be saved; they are read from this bank while the record
   is written. A load that ended early may have overwritten them. Then the function restores them from the latest
   record, unless the bank holds the points of a table that is being received or waits for its judgement. */
static bool saving_holds_table(const struct application *application) {
    const struct load *load = &application->load;
    const struct load_table *table = &application->save->content.table;
    bool receives =
        (load->state == LOAD_RECEIVING || load->whole) && load->received_table.place.choice != 0;
    return table->place.choice == 0 || (receives ? local_table_is_held(application, table->crc)
                                                 : local_table_restore(application));
}

/* Selects the coefficients and begins to save them. Coefficients of the latest record that wait for their first turn
   are saved again, unless they belong to another table. Coefficients that a turn contradicts are replaced as soon as
   there are others. Coefficients that are inactive only while the index is searched again are kept. */
enum save_answer application_save(struct application *application) {
    struct save *save = application->save;
    if (save == NULL) {
        return SAVE_NO_FLASH;
    }
    if (save->state != SAVE_IDLE) {
        return SAVE_UNDER_WAY;
    }
    enum save_answer readable = save_look_again(save);
    if (readable != SAVE_DONE) {
        return readable;
    }
    struct saved *saved = &save->content;
    uint32_t counts_per_rev = (uint32_t)application->parameters.counts_per_rev;
    bool of_this_table = saved->own.counts_per_rev == counts_per_rev && !application->forgotten;
    bool known = application->active.counts_per_rev == counts_per_rev &&
                 (coefficients_most_order(&application->active) != 0 ||
                  application->load.table.place.choice != 0);
    saved->settings = settings_present(application);
    if (!of_this_table) {
        *saved = (struct saved){.settings = saved->settings};
    }
    if (known) {
        saving_take_known(application, saved);
    }
    saved->own.counts_per_rev = counts_per_rev;
    saved->loaded.counts_per_rev = counts_per_rev;
    bool asked = application->forgotten || application->has_active ||
                 save->kept_counts_per_rev != counts_per_rev;
    enum save_answer answer = SAVE_TABLE_NOT_HELD;
    if (saving_holds_table(application)) {
        answer = save_begin(save, asked ? 0 : save->kept_lanes);
    }
    if (answer != SAVE_DONE) {
        save_take_back(save);
    } else if ((known || application->forgotten) && application->saved_state != SAVED_WAITING) {
        application->saved_state = SAVED_NONE;
    }
    return answer;
}

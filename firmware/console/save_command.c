/* SPDX-License-Identifier: Apache-2.0 */

#include "save_command.h"

#include <stddef.h>

const char save_use[] = "save: write parameters, switches and coefficients to the flash";

static void refuse(const struct console *console, enum save_answer answer) {
    text_error(&console->sink, "save ", save_answer_name(answer));
}

void save_command(struct console *console, char *const *words, uint32_t number) {
    (void)words;
    (void)number;
    bool free = console->images == NULL || !console->images->busy;
    enum save_answer answer = free ? application_save(console->application) : SAVE_UNDER_WAY;
    if (answer != SAVE_DONE) {
        refuse(console, answer);
    }
}

void save_step_reported(struct console *console) {
    struct save *save = console->application->save;
    if (save == NULL || !save->fresh) {
        return;
    }
    save->fresh = false;
    if (save->answer != SAVE_DONE) {
        refuse(console, save->answer);
        return;
    }
    text_word(&console->sink, "ok, record ");
    text_unsigned(&console->sink, save->sequence);
    text_word(&console->sink, ": parameters and ");
    text_unsigned(&console->sink, saved_lanes(&save->content));
    text_word(&console->sink, " orders");
    if (save->worn != 0) {
        text_word(&console->sink, "; worn sectors: ");
        text_unsigned(&console->sink, save_worn(save));
    }
    text_line(&console->sink, "");
}

/* SPDX-License-Identifier: Apache-2.0 */

/* Provides the firmware's application and console to Python as one object. */

#include <stdlib.h>
#include <string.h>

#include "application.h"
#include "console.h"

#define EXPORTED __attribute__((visibility("default")))

extern uint32_t firmware_bus_read(void *context, uint32_t offset);
extern void firmware_bus_write(void *context, uint32_t offset, uint32_t word);
extern const volatile int32_t *firmware_bus_capture(void *context, uint32_t number);
extern const volatile int32_t *firmware_bus_further_capture(void *context, uint32_t number);

struct processor {
    struct application application;
    struct console console;
    struct text_sink sink;
    /* Operator's settings, which survive a restart after a fault. */
    struct kept_settings kept;
    char *said;
    size_t length;
    size_t room;
    /* Reading of the table's thermometer. */
    int thermometer_answers;
    double thermometer_c;
    struct capture_copy copy;
    struct axis_mean axis;
    struct save save;
    /* Flash with two records, each in its own sector; its content survives a loss of power. */
    uint32_t flash[2][SAVED_WORDS_MOST];
};

static uint32_t flash_open(void *context) {
    const struct processor *processor = context;
    return sizeof processor->flash[0];
}

static bool flash_read(void *context, uint32_t address, uint32_t *words, uint32_t number) {
    const struct processor *processor = context;
    memcpy(words, &processor->flash[0][0] + address / sizeof *words, number * sizeof *words);
    return true;
}

static bool flash_erase(void *context, uint32_t address) {
    struct processor *processor = context;
    memset(&processor->flash[0][0] + address / sizeof(uint32_t), 0xFF, sizeof processor->flash[0]);
    return true;
}

static bool flash_program(void *context, uint32_t address, const uint32_t *words, uint32_t number) {
    struct processor *processor = context;
    memcpy(&processor->flash[0][0] + address / sizeof *words, words, number * sizeof *words);
    return true;
}

static enum flash_activity flash_activity(void *context) {
    (void)context;
    return FLASH_IDLE;
}

static bool read_thermometer(void *context, double *celsius) {
    const struct processor *processor = context;
    if (!processor->thermometer_answers) {
        return false;
    }
    *celsius = processor->thermometer_c;
    return true;
}

static void put(void *context, const char *characters, size_t number) {
    struct processor *processor = context;
    if (processor->length + number > processor->room) {
        size_t room = 2 * (processor->length + number);
        char *larger = realloc(processor->said, room);
        if (larger == NULL) {
            return;
        }
        processor->said = larger;
        processor->room = room;
    }
    memcpy(processor->said + processor->length, characters, number);
    processor->length += number;
}

static void settle(void) {
}

/* Prepares the firmware like main(), up to the first access to the core. */
static void prepare(struct processor *processor, const struct core_access *core, int after_fault) {
    application_prepare(&processor->application, core);
    application_use_copy(&processor->application, &processor->copy);
    application_use_axis(&processor->application, &processor->axis);
    console_prepare(&processor->console, &processor->application, &processor->sink);
    application_keep_settings(&processor->application, &processor->kept, settle);
    const struct flash_access flash = {flash_open,    flash_read,     flash_erase,
                                       flash_program, flash_activity, processor};
    save_prepare(&processor->save, &flash, 0, sizeof processor->flash);
    application_use_flash(&processor->application, &processor->save);
    application_recover(&processor->application, after_fault != 0);
}

EXPORTED struct processor *firmware_new(void *bus) {
    struct processor *processor = calloc(1, sizeof *processor);
    if (processor != NULL) {
        struct core_access core = {
            .read = firmware_bus_read,
            .write = firmware_bus_write,
            .capture = firmware_bus_capture,
            .further_capture = firmware_bus_further_capture,
            .context = bus,
        };
        processor->sink.put = put;
        processor->sink.context = processor;
        memset(processor->flash, 0xFF, sizeof processor->flash);
        prepare(processor, &core, 0);
    }
    return processor;
}

/* Returns the flash, of firmware_flash_bytes() bytes, so that it can be copied to another processor. */
EXPORTED void *firmware_flash(struct processor *processor) {
    return processor->flash;
}

EXPORTED uint32_t firmware_flash_bytes(void) {
    return sizeof(uint32_t[2][SAVED_WORDS_MOST]);
}

/* Starts like main(), with the content of the flash. */
EXPORTED void firmware_power_on(struct processor *processor) {
    struct core_access core = processor->application.core;
    prepare(processor, &core, 0);
    application_begin(&processor->application);
}

/* Restarts the firmware as after a fault; only the operator's settings stay in its memory. */
EXPORTED void firmware_fault(struct processor *processor) {
    struct core_access core = processor->application.core;
    prepare(processor, &core, 1);
    application_begin(&processor->application);
}

EXPORTED void firmware_delete(struct processor *processor) {
    free(processor->said);
    free(processor);
}

/* Sets the answer of the thermometer; the first call connects the thermometer to the firmware. */
EXPORTED void firmware_thermometer(struct processor *processor, int answers, double celsius,
                                   double clock_hz) {
    processor->application.temperature_clock_hz = clock_hz;
    processor->thermometer_answers = answers;
    processor->thermometer_c = celsius;
    if (processor->application.table.read == NULL) {
        application_use_thermometer(&processor->application, read_thermometer, processor);
    }
}

EXPORTED void firmware_start(struct processor *processor) {
    application_rearm(&processor->application);
}

EXPORTED void firmware_step(struct processor *processor) {
    application_step(&processor->application);
    console_step(&processor->console);
}

EXPORTED void firmware_type(struct processor *processor, const char *line) {
    while (*line != '\0') {
        console_receive(&processor->console, (uint8_t)*line++);
    }
}

/* Returns the console's output since the previous call; the text is valid until the next call. */
EXPORTED const char *firmware_said(struct processor *processor) {
    put(processor, "", 1);
    processor->length = 0;
    return processor->said;
}

EXPORTED const char *firmware_phase(const struct processor *processor) {
    return application_phase_name(processor->application.phase);
}

EXPORTED int firmware_set(struct processor *processor, const char *name, double value) {
    const struct parameter_description *description = NULL;
    return (int)parameters_set(&processor->application.parameters, name, value, &description);
}

EXPORTED uint32_t firmware_turns(const struct processor *processor) {
    return processor->application.turns;
}

/* Copies the words of the active coefficients into the arrays; returns the number of lanes, or 0. */
EXPORTED uint32_t firmware_coefficients(const struct processor *processor, uint64_t *steps,
                                        uint32_t *offsets, int32_t *amplitudes) {
    const struct application *application = &processor->application;
    if (!application->has_active) {
        return 0;
    }
    for (uint32_t lane = 0; lane < application->active.lanes; lane++) {
        steps[lane] = coefficients_phase_step(application->active.lane[lane].order,
                                              application->active.counts_per_rev);
        offsets[lane] = application->active.lane[lane].phase_offset;
        amplitudes[lane] = application->active.lane[lane].amplitude;
    }
    return application->active.lanes;
}

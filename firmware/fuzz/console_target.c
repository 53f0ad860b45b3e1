/* SPDX-License-Identifier: Apache-2.0 */

/* Sends any bytes to the console, with a core on the bus that delivers a turn after each of the first four lines. The
   output must be text in whole lines, and the kept settings must equal the settings that the lines have ordered. */

#include <stdlib.h>
#include <string.h>

#include "arctrue_registers.h"
#include "console.h"
#include "fuzz_target.h"

#define AT(register) (offsetof(arctrue_registers_t, register) / 4)

enum { WINDOW_WORDS = 0x2100 / 4, SAMPLES = 40, BOTH_INDICES = 3 };
/* Few orders and few turns, so that the fuzzer has time for more lines: a calibration takes longer than a line of the
   console. */
enum { ORDERS = 6, TURNS_MOST = 4 };
/* The images use the first sectors of the flash; saved records use the others, and a save needs two of them. */
enum { IMAGE_SECTORS = 2, SAVE_SECTORS = 2, SECTORS = IMAGE_SECTORS + SAVE_SECTORS };

static struct {
    struct application application;
    struct console console;
    struct kept_settings kept;
    struct capture_copy copy;
    struct axis_mean axis;
    struct save save;
    struct image_store images;
    uint32_t flash[SECTORS][SAVED_WORDS_MOST];
    uint32_t words[WINDOW_WORDS];
    int32_t bank[2 * SAMPLES];
    char before;
} fuzz;

static void require(bool holds) {
    if (!holds) {
        abort();
    }
}

static uint32_t read_word(void *context, uint32_t offset) {
    (void)context;
    require(offset % 4 == 0 && offset / 4 < WINDOW_WORDS);
    return fuzz.words[offset / 4];
}

static void obey(uint32_t command) {
    if (command & ARCTRUE_REGISTERS__COMMAND__REARM_bm) {
        fuzz.words[AT(counts_per_rev_active)] = fuzz.words[AT(counts_per_rev)];
    }
    if (command & ARCTRUE_REGISTERS__COMMAND__SWAP_bm) {
        fuzz.words[AT(swap_count)]++;
    }
    if (command & ARCTRUE_REGISTERS__COMMAND__CAPTURE_RELEASE_bm) {
        fuzz.words[AT(status)] = 0;
    }
}

static void write_word(void *context, uint32_t offset, uint32_t word) {
    (void)context;
    require(offset % 4 == 0 && offset / 4 < WINDOW_WORDS);
    if (offset / 4 == AT(command)) {
        obey(word);
    } else {
        fuzz.words[offset / 4] = word;
    }
}

static const volatile int32_t *capture_words(void *context, uint32_t number) {
    (void)context;
    require(number <= 2 * SAMPLES);
    return fuzz.bank;
}

static void put(void *context, const char *characters, size_t number) {
    (void)context;
    for (size_t place = 0; place < number; place++) {
        char character = characters[place];
        bool text = character >= ' ' && character <= '~';
        require(text || character == '\r' || (character == '\n' && fuzz.before == '\r'));
        fuzz.before = character;
    }
}

static bool read_temperature(void *context, double *celsius) {
    (void)context;
    *celsius = 48.5;
    return true;
}

static void settle(void) {
}

static uint32_t flash_open(void *context) {
    (void)context;
    return sizeof fuzz.flash[0];
}

static bool flash_read(void *context, uint32_t address, uint32_t *words, uint32_t number) {
    (void)context;
    for (uint32_t word = 0; word < number; word++) {
        uint32_t place = address / 4 + word;
        words[word] = place < SECTORS * SAVED_WORDS_MOST ? (&fuzz.flash[0][0])[place] : 0xFFFFFFFFU;
    }
    return true;
}

static bool flash_erase(void *context, uint32_t address) {
    (void)context;
    require(address / sizeof fuzz.flash[0] < SECTORS);
    memset(fuzz.flash[address / sizeof fuzz.flash[0]], 0xFF, sizeof fuzz.flash[0]);
    return true;
}

static bool flash_program(void *context, uint32_t address, const uint32_t *words, uint32_t number) {
    (void)context;
    require(address / 4 + number <= SECTORS * SAVED_WORDS_MOST && number <= FLASH_PAGE_WORDS);
    memcpy(&(&fuzz.flash[0][0])[address / 4], words, number * sizeof *words);
    return true;
}

static enum flash_activity flash_activity(void *context) {
    (void)context;
    return FLASH_IDLE;
}

static void prepare_flash(void) {
    const struct flash_access access = {flash_open,    flash_read,     flash_erase,
                                        flash_program, flash_activity, NULL};
    memset(fuzz.flash, 0xFF, sizeof fuzz.flash);
    save_prepare(&fuzz.save, &access, IMAGE_SECTORS * sizeof fuzz.flash[0],
                 SAVE_SECTORS * sizeof fuzz.flash[0]);
    static const struct image_map map = {
        .golden = 0x100, .golden_bytes = 0x100, .end = IMAGE_SECTORS * sizeof fuzz.flash[0]};
    image_store_prepare(&fuzz.images, &access, &map);
    fuzz.console.images = &fuzz.images;
    application_use_flash(&fuzz.application, &fuzz.save);
}

static void prepare_core(void) {
    fuzz.words[AT(identification)] = ARCTRUE_REGISTERS__IDENTIFICATION__VALUE_reset;
    fuzz.words[AT(version)] =
        (uint32_t)ARCTRUE_REGISTERS__VERSION__MAJOR_reset << ARCTRUE_REGISTERS__VERSION__MAJOR_bp |
        (uint32_t)ARCTRUE_REGISTERS__VERSION__MINOR_reset << ARCTRUE_REGISTERS__VERSION__MINOR_bp;
    fuzz.words[AT(capability)] = HEADS_MOST << ARCTRUE_REGISTERS__CAPABILITY__HEADS_bp |
                                 ARCTRUE_REGISTERS__CAPABILITY__MEAN_bm;
    fuzz.words[AT(core_configuration)] =
        4U << ARCTRUE_REGISTERS__CORE_CONFIGURATION__LANES_bp |
        (uint32_t)SAMPLES << ARCTRUE_REGISTERS__CORE_CONFIGURATION__CAPTURE_DEPTH_bp;
    fuzz.words[AT(clock_hz)] = 100000000;
    fuzz.words[AT(head1.flags)] = 1;
    fuzz.words[AT(head2.flags)] = 1;
    fuzz.words[AT(capture_header.flags)] =
        BOTH_INDICES | ARCTRUE_REGISTERS__CAPTURE_HEADER__FLAGS__FURTHER_INDEX_SEEN_bm;
    fuzz.words[AT(capture_header.sample_count)] = SAMPLES;
}

/* Delivers a turn with the counts per turn that the operator has set. */
static void hand_over(void) {
    double step = (double)fuzz.words[AT(counts_per_rev_active)] / (SAMPLES - 1);
    for (uint32_t sample = 0; sample < SAMPLES; sample++) {
        fuzz.bank[2 * sample] = (int32_t)(sample * step);
        fuzz.bank[2 * sample + 1] = (int32_t)(sample * step + 18.0 * step);
    }
    fuzz.words[AT(status)] = ARCTRUE_REGISTERS__STATUS__CAPTURE_READY_bm;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const struct core_access core = {read_word, write_word, capture_words,
                                            NULL,      NULL,       capture_words};
    static const struct text_sink sink = {.put = put};
    memset(&fuzz, 0, sizeof fuzz);
    prepare_core();
    application_prepare(&fuzz.application, &core);
    application_use_copy(&fuzz.application, &fuzz.copy);
    application_use_axis(&fuzz.application, &fuzz.axis);
    application_use_temperature(&fuzz.application, read_temperature, NULL);
    console_prepare(&fuzz.console, &fuzz.application, &sink);
    fuzz.application.parameters.orders = ORDERS;
    application_keep_settings(&fuzz.application, &fuzz.kept, settle);
    prepare_flash();
    application_recover(&fuzz.application, false);
    application_start(&fuzz.application);
    unsigned turns = 0;
    for (size_t place = 0; place < size; place++) {
        console_receive(&fuzz.console, data[place]);
        if (data[place] == '\r' || data[place] == '\n') {
            if (turns++ < TURNS_MOST) {
                hand_over();
            }
            for (int step = 0; step < 3; step++) {
                application_step(&fuzz.application);
                console_step(&fuzz.console);
            }
        }
        require(fuzz.console.length <= CONSOLE_LINE_MOST);
    }
    /* After any input the console must understand the next line. */
    static const char question[] = "\rhelp\r";
    for (size_t place = 0; place + 1 < sizeof question; place++) {
        console_receive(&fuzz.console, (uint8_t)question[place]);
    }
    require(fuzz.before == '\n');
    /* The kept settings must equal the ordered settings, because the firmware would restart with them after a fault. */
    struct settings kept;
    require(kept_settings_read(&fuzz.kept, &kept));
    require(memcmp(&kept.parameters, &fuzz.application.parameters, sizeof kept.parameters) == 0);
    require(kept.bypassed == fuzz.application.bypassed && kept.frozen == fuzz.application.frozen);
    return 0;
}

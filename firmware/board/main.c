/* SPDX-License-Identifier: Apache-2.0 */

#include "application.h"
#include "board_fabric.h"
#include "board_settings.h"
#include "build_name.h"
#include "clocks.h"
#include "console.h"
#include "die_temperature.h"
#include "fault.h"
#include "flash.h"
#include "flash_map.h"
#include "i2c.h"
#include "image_store.h"
#include "interrupts.h"
#include "memory_mapped.h"
#include "registers.h"
#include "thermometer.h"
#include "timer.h"
#include "uart.h"
#include "watchdog.h"

#define CAPTURE_WINDOW 0x20000U
#define FURTHER_CAPTURE_WINDOW 0x40000U

/* State of the firmware; the large parts that only some steps need are placed in the upper 64 KB. */
static struct {
    struct flash flash;
    struct save save;
    struct image_store images;
    struct thermometer thermometer;
    struct capture_copy copy;
    struct axis_mean axis;
    struct uart_output output;
} upper __attribute__((section(".upper")));

static struct {
    struct uart uart;
    struct application application;
    struct console console;
    uint64_t longest_step_ticks;
    volatile bool core_interrupted;
} firmware;

void interrupt_taken(uint32_t instruction);

void interrupt_taken(uint32_t instruction) {
    uint32_t acknowledged = register_read(GIC_ICCIAR);
    uint32_t interrupt = acknowledged & 0x3FFU;
    if (interrupt >= GIC_SPURIOUS) {
        return;
    }
    if (interrupt == INTERRUPT_GLOBAL_TIMER) {
        timer_interrupt();
        uart_go_on(&upper.output);
    } else if (interrupt == INTERRUPT_UART0) {
        uart_interrupt(&firmware.uart);
    } else if (interrupt == INTERRUPT_FABRIC) {
        interrupts_fabric_off();
        firmware.core_interrupted = true;
    }
    register_write(GIC_ICCEOIR, acknowledged);
    if (interrupt == INTERRUPT_GLOBAL_TIMER && watchdog_is_overdue()) {
        /* Feeds the watchdog, so that it does not cut off the message on the console. */
        watchdog_feed();
        fault_hang(instruction);
    }
}

/* Reads a word of the core. Without a configured fabric every word reads 0, which identifies no core. If the fabric
   contains another circuit, the bus may answer with an error; the probe of word 0 detects this, and no other word is
   read then. */
static uint32_t read_core(void *context, uint32_t offset) {
    (void)context;
    if (!board_fabric_usable()) {
        return 0;
    }
    return offset == 0 ? register_probe(seen_at(BOARD_CORE_BASE))
                       : register_read(BOARD_CORE_BASE + offset);
}

static void write_core(void *context, uint32_t offset, uint32_t word) {
    (void)context;
    if (board_fabric_usable()) {
        register_write(BOARD_CORE_BASE + offset, word);
    }
}

/* Searches for the thermometer, which is connected to pins of the fabric. A thermometer that is plugged in later is
   found at the next `rearm`. */
static void use_thermometer(void) {
    if (upper.thermometer.kind != THERMOMETER_NONE || !board_fabric_usable()) {
        return;
    }
    i2c_prepare(board_registers(), CLOCKS_BUS_HZ);
    thermometer_find(&upper.thermometer, board_registers());
    if (upper.thermometer.kind != THERMOMETER_NONE) {
        application_use_thermometer(&firmware.application, thermometer_read, &upper.thermometer);
    }
}

static void look_for_fabric(void *context) {
    (void)context;
    if (!board_fabric_usable()) {
        (void)board_fabric_look_again();
    }
    use_thermometer();
}

static const char *fabric_word(void) {
    return fabric_state_name(board_fabric_state());
}

static const volatile int32_t *capture_words(void *context, uint32_t number) {
    (void)context;
    (void)number;
    return (const volatile int32_t *)seen_at(BOARD_CORE_BASE + CAPTURE_WINDOW);
}

static const volatile int32_t *further_capture_words(void *context, uint32_t number) {
    (void)context;
    (void)number;
    return (const volatile int32_t *)seen_at(BOARD_CORE_BASE + FURTHER_CAPTURE_WINDOW);
}

static bool read_temperature(void *context, double *celsius) {
    (void)context;
    return die_temperature_read(board_registers(), celsius);
}

static void put_characters(void *context, const char *characters, size_t number) {
    (void)context;
    uart_send(&upper.output, characters, number);
    watchdog_feed();
}

static size_t room(void *context) {
    (void)context;
    return uart_room(&upper.output);
}

static void take_core_interrupt(void) {
    if (firmware.core_interrupted) {
        firmware.core_interrupted = false;
        application_interrupt(&firmware.application);
        interrupts_fabric_on();
    }
}

static void step_application(void) {
    uint64_t before = timer_ticks();
    application_step(&firmware.application);
    uint64_t ticks = timer_ticks() - before;
    if (ticks > firmware.longest_step_ticks) {
        firmware.longest_step_ticks = ticks;
        firmware.console.longest_step_us = (double)ticks * 1e6 / CLOCKS_TIMER_HZ;
    }
}

static void work(void) {
    uint8_t character;
    take_core_interrupt();
    step_application();
    firmware.console.overruns = firmware.uart.overruns;
    while (uart_take(&firmware.uart, &character)) {
        console_receive(&firmware.console, character);
    }
    console_step(&firmware.console);
    uart_send(&upper.output, "", 0);
}

/* Reports to the core that the firmware works. The core raises an alarm of its own if no report comes for
   WATCHDOG_HANG_S. */
static void tell_alive(void) {
    const struct application *application = &firmware.application;
    if (application->phase != PHASE_NO_CORE) {
        uint64_t clocks = (uint64_t)application->configuration.clock_hz * WATCHDOG_HANG_S;
        core_tell_alive(&application->core, clocks < UINT32_MAX ? (uint32_t)clocks : UINT32_MAX);
    }
}

static bool work_waits(void) {
    return firmware.core_interrupted || uart_waits(&firmware.uart) ||
           application_busy(&firmware.application) || console_busy(&firmware.console) ||
           uart_is_sending(&upper.output);
}

static void tell_settings(const struct text_sink *sink) {
    const struct application *application = &firmware.application;
    if (upper.save.found == SAVED_UNREAD) {
        text_word(sink, "no saved data is in use: the flash does not answer\r\n");
    }
    if (application->settings_origin != SETTINGS_PRESET) {
        text_word(sink, "settings ");
        text_word(sink, settings_origin_name(application->settings_origin));
        text_word(sink, application->bypassed ? ", bypass on\r\n" : ", bypass off\r\n");
    }
    if (application->phase == PHASE_HELD && application->settings_origin == SETTINGS_LOST) {
        text_word(sink, "held as the settings are lost: rearm begins anew\r\n");
    } else if (application->phase == PHASE_HELD) {
        text_word(sink, "held after ");
        text_unsigned(sink, application->faults_in_a_row);
        text_word(sink, " faults in a row: rearm begins anew\r\n");
    }
}

static void tell_start(const struct text_sink *sink, enum fabric_state fabric) {
    const struct console *console = &firmware.console;
    if (console->reset_instruction != 0) {
        text_word(sink, "began anew after ");
        text_word(sink, console->reset_reason);
        text_word(sink, " at 0x");
        text_hexadecimal(sink, console->reset_instruction);
        text_word(sink, "\r\n");
    }
    tell_settings(sink);
    text_word(sink, "fabric ");
    text_word(sink, console->fabric());
    text_word(sink, ": ");
    text_word(sink, fabric_state_meaning(fabric));
    bool emulated = board_fabric_emulated();
    text_word(sink, emulated ? "; emulated" : (board_fabric_usable() ? "" : "; not accessed"));
    text_word(sink, "\r\n");
    text_word(sink, "arctrue " BOARD_NAME ", help lists the commands\r\n");
}

/* Prepares the flash for storage. Call it before the fabric is loaded, because the loading reads the flash as
   memory. */
static void use_flash(void) {
    flash_prepare(&upper.flash, board_registers());
    struct flash_access access = flash_access_to(&upper.flash);
    save_prepare(&upper.save, &access, FLASH_MAP_RECORDS, FLASH_MAP_RECORDS_BYTES);
    application_use_flash(&firmware.application, &upper.save);
    static const struct image_map map = {
        .golden = FLASH_MAP_GOLDEN,
        .golden_bytes = FLASH_MAP_GOLDEN_BYTES,
        .end = FLASH_MAP_RECORDS,
    };
    image_store_prepare(&upper.images, &access, &map);
    firmware.console.images = &upper.images;
    firmware.console.started_from =
        (register_read(DEVCFG_MULTIBOOT_ADDR) & DEVCFG_MULTIBOOT_PLACES) * DEVCFG_MULTIBOOT_BYTES;
}

int main(void) {
    static const struct core_access core = {
        .look = look_for_fabric,
        .read = read_core,
        .write = write_core,
        .capture = capture_words,
        .further_capture = further_capture_words,
    };
    static const struct text_sink sink = {put_characters, NULL, room};
    clocks_set_up();
    timer_set_up();
    watchdog_start();
    uart_set_up(&firmware.uart);
    interrupts_set_up();
    application_prepare(&firmware.application, &core);
    console_prepare(&firmware.console, &firmware.application, &sink);
    firmware.console.firmware = BUILD_VERSION;
    firmware.console.build = BUILD_NAME;
    struct fault_record last = fault_last();
    firmware.console.reset_reason = fault_name((enum fault_code)last.code);
    firmware.console.reset_instruction = last.instruction;
    application_use_copy(&firmware.application, &upper.copy);
    application_use_axis(&firmware.application, &upper.axis);
    application_keep_settings(&firmware.application, fault_kept_settings(), fault_keep);
    use_flash();
    application_recover(&firmware.application, last.code != FAULT_NONE);
    fault_bus_errors_on();
    enum fabric_state fabric = board_fabric_start();
    firmware.console.fabric = fabric_word;
    die_temperature_prepare(board_registers());
    application_use_temperature(&firmware.application, read_temperature, NULL);
    application_begin(&firmware.application);
    tell_start(&sink, fabric);
    for (;;) {
        watchdog_feed();
        tell_alive();
        work();
        interrupts_sleep_unless(work_waits);
    }
}

"""Ways to break the firmware's C, and the host test that must notice each: scripts/mutate.py."""

from __future__ import annotations

from typing import Final

from scripts.mutation import Mutation

_TESTS = "sim/tests/firmware"

FIRMWARE_MUTATIONS: Final[tuple[Mutation, ...]] = (
    Mutation(
        "angle_of_the_first_sample",
        "the angle at which a capture begins is off by the travel since then",
        "firmware/application/application.c",
        "(int64_t)position->head1_angle - travel;",
        "(int64_t)position->head1_angle + travel;",
        f"{_TESTS}/test_wrapped_position.py",
    ),
    Mutation(
        "no_running_average",
        "the turns are added to the average, and each is used alone",
        "firmware/application/calibrate.c",
        "    average_apply(&application->average, estimate);\n",
        "",
        f"{_TESTS}/test_usual_noise.py::test_the_average_is_quieter_than_a_turn",
    ),
    Mutation(
        "usual_noise_never_follows",
        "the noise of the first turn stays the usual one",
        "firmware/application/calibrate.c",
        "usual + NOISE_SHARE * (noise - usual)",
        "usual + 0.0 * NOISE_SHARE * (noise - usual)",
        f"{_TESTS}/test_usual_noise.py::test_noise_that_rises_slowly_becomes_the_usual_one",
    ),
    Mutation(
        "noisy_turns_are_never_forgotten",
        "the fifth noisy turn is taken though quiet ones came in between",
        "firmware/application/calibrate.c",
        "    application->noisy_turns = 0;\n",
        "",
        f"{_TESTS}/test_usual_noise.py::test_only_noisy_turns_in_a_row_become_usual",
    ),
    Mutation(
        "older_record",
        "of two whole records the older one is read",
        "firmware/application/save.c",
        "(int32_t)(sequence[1] - sequence[0]) > 0;",
        "(int32_t)(sequence[1] - sequence[0]) < 0;",
        f"{_TESTS}/test_save.py::test_the_sequence_number_wraps",
    ),
    Mutation(
        "the_only_record_is_erased",
        "a save erases the record that is the later whole one",
        "firmware/application/save.c",
        "save->found == SAVED_READ ? 1U - save->latest : 0U;",
        "save->found == SAVED_READ ? save->latest : 0U;",
        f"{_TESTS}/test_save.py::test_records_are_written_in_turn_and_nothing_else",
    ),
    Mutation(
        "saved_is_not_judged",
        "saved coefficients are applied whatever the captured turn says",
        "firmware/application/calibrate.c",
        "if (fits && load_is_better(turn, active, &application->candidate)) {",
        "if (fits && (load_is_better(turn, active, &application->candidate) || fits)) {",
        f"{_TESTS}/test_save.py::test_another_table_does_not_get_them",
    ),
    Mutation(
        "waiting_coefficients_are_not_saved",
        "a save before the first turn drops the coefficients that wait for it",
        "firmware/application/application.c",
        "        return save_begin(save);\n    }\n",
        "    }\n",
        f"{_TESTS}/test_save.py::test_a_save_before_the_first_turn_keeps_the_coefficients_that_wait",
    ),
    Mutation(
        "sine_follows_backwards",
        "the sine of a lane follows the temperature with the wrong sign",
        "firmware/application/thermal.c",
        "value.im -= (slope->sine",
        "value.im += (slope->sine",
        f"{_TESTS}/test_thermal.py::test_a_lane_at_a_temperature",
    ),
    Mutation(
        "jumps_are_believed",
        "a thermometer that jumps is followed",
        "firmware/application/table_temperature.c",
        "if (fabs(celsius - table->shown_c) > limits->jump_k) {",
        "if (fabs(celsius - table->shown_c) > 1000.0 * limits->jump_k) {",
        f"{_TESTS}/test_thermal.py::test_a_thermometer_that_fails_leaves_the_last_good_model",
    ),
    Mutation(
        "select_between_words",
        "the flash is let go between its address and what is written there",
        "firmware/zynq/flash.c",
        "    bool answers = exchange(flash, QSPI_TXD0, word, &nothing);\n",
        "    bool answers = exchange(flash, QSPI_TXD0, word, &nothing);\n"
        "    select(flash, false);\n    select(flash, true);\n",
        f"{_TESTS}/test_flash.py::test_a_sector_is_erased_and_a_page_programmed",
    ),
    Mutation(
        "golden_is_written_again",
        "the golden image may be written although it is whole",
        "firmware/application/image_store.c",
        "return touches && golden_is_whole(store) ?",
        "return touches && first == 1U && golden_is_whole(store) ?",
        f"{_TESTS}/test_image_store.py::test_the_golden_image_and_what_is_saved_cannot_be_written",
    ),
    Mutation(
        "image_is_not_read_back",
        "what the flash holds after a write is not compared",
        "firmware/application/image_store.c",
        "if (words[place] != store->words[place]) {",
        "if (words[place] != store->words[place] && place > IMAGE_WORDS_MOST) {",
        f"{_TESTS}/test_image_store.py::test_a_flash_that_does_not_obey",
    ),
    Mutation(
        "lag_is_not_followed",
        "how far the thermometer is behind the table is never corrected by what it shows",
        "firmware/application/table_temperature.c",
        "table->behind_k += behind_gain * off;",
        "table->behind_k += 0.0 * behind_gain * off;",
        f"{_TESTS}/test_thermal.py::test_the_lag_is_taken_off",
    ),
    Mutation(
        "turn_is_told_twice",
        "an alarm between two turns tells the turn before once more",
        "firmware/application/application.c",
        "report->between_turns = report->between_turns || !report->fresh;",
        "report->between_turns = report->between_turns && !report->fresh;",
        f"{_TESTS}/test_application.py::test_a_stuck_capture_ends_in_the_safe_state",
    ),
    Mutation(
        "compare_begins_behind_the_table",
        "the compare is armed at a place that the table has passed",
        "firmware/application/core.c",
        "position + (uint32_t)(upwards ? counts : -counts)",
        "position + (uint32_t)(upwards ? -counts : counts)",
        f"{_TESTS}/test_pins.py::test_compare_begins_at_the_next_place_in_the_way_of_the_table",
    ),
    Mutation(
        "no_edge_is_a_stuck_capture",
        "where no edge of sync_in comes the correction is taken away",
        "firmware/application/application.c",
        "    if (application_capture(application) == CAPTURE_BY_SYNC) {\n        return;\n    }\n",
        "",
        f"{_TESTS}/test_pins.py::test_samples_at_the_edges_of_sync_in",
    ),
    Mutation(
        "dna_is_shifted",
        "the upper bits of the chip's identifier are a place too low",
        "firmware/application/core.c",
        "CHIP_DNA_HIGH__VALUE) << 32",
        "CHIP_DNA_HIGH__VALUE) << 31",
        f"{_TESTS}/test_console.py::test_version_tells_firmware_gateware_and_chip",
    ),
)

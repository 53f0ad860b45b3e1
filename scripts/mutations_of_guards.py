"""Ways to take a guard of the diagnosis away, and the fast test that must notice each.

Each is a rule or a charge without which a verdict says more than its set knows. An anchor that is
no longer in its file is a fault of this list: move it with the guard.
"""

from __future__ import annotations

from typing import Final

from scripts.mutations import Mutation

DIAGNOSE = "sim/arctrue/workbench/diagnose"
GUARDS = "sim/tests/workbench/diagnose/test_guards.py"
COVERAGE = "sim/tests/workbench/diagnose/test_coverage.py"
OUTLIERS = "sim/tests/workbench/observations/test_outliers.py"
PROBABILITIES = "sim/tests/workbench/diagnose/test_probabilities.py"

GUARD_MUTATIONS: Final[tuple[Mutation, ...]] = (
    Mutation(
        "places_are_free",
        "the places that a search looked at are not charged",
        f"{DIAGNOSE}/significance.py",
        "np.expm1(max(trials, 1.0) * np.log1p(",
        "np.expm1(1.0 * np.log1p(",
        f"{GUARDS}::test_every_place_that_was_looked_at_is_charged",
    ),
    Mutation(
        "candidates_are_free",
        "the number of candidates is not charged",
        f"{DIAGNOSE}/significance.py",
        "max(placed, 0.0) * max(candidates, 1)",
        "max(placed, 0.0)",
        f"{GUARDS}::test_every_candidate_is_charged",
    ),
    Mutation(
        "noise_is_known",
        "noise known from few runs is taken as known for sure",
        f"{DIAGNOSE}/significance.py",
        "    if freedom > MANY:\n",
        "    if freedom > 0.0:\n",
        f"{GUARDS}::test_noise_that_is_little_known_makes_a_gain_less_rare",
    ),
    Mutation(
        "products_are_free",
        "each order of a product spends false alarms as if it were the only one",
        f"{DIAGNOSE}/parts_scan.py",
        "float(orders[0] / order)) / total",
        "float(orders[0] / order))",
        f"{GUARDS}::test_shares_of_the_false_alarms_of_products_add_up_to_one",
    ),
    Mutation(
        "held_out_rows_need_not_fall",
        "a name is confirmed by rows left out that do not show it",
        f"{DIAGNOSE}/heldout.py",
        "    return gain > STANDARD_ERRORS * error\n",
        "    return True\n",
        f"{GUARDS}::test_a_fall_within_two_standard_errors_is_none",
    ),
    Mutation(
        "held_out_rows_may_rise",
        "a name stands though rows left out get worse",
        f"{DIAGNOSE}/heldout.py",
        "        return gain > -STANDARD_ERRORS * error\n",
        "        return True\n",
        f"{GUARDS}::test_what_left_out_rows_cannot_show_must_not_get_worse",
    ),
    Mutation(
        "folds_in_turn",
        "rows are left out in turn, so that one fold has all visits of a station",
        f"{DIAGNOSE}/heldout.py",
        "random.permuted(np.tile(np.arange(FOLDS), (rounds, 1)), axis=1).ravel()",
        "np.tile(np.arange(FOLDS), (rounds, 1)).ravel()",
        f"{GUARDS}::test_rows_side_by_side_are_left_out_apart_and_stations_not_together",
    ),
    Mutation(
        "noise_is_white",
        "the noise has no coloured part",
        "sim/arctrue/workbench/noise/estimate.py",
        "spectra[int(np.searchsorted(law.runs, name))] = fit.spectrum",
        "spectra[int(np.searchsorted(law.runs, name))] = Spectrum(fit.spectrum.variance)",
        f"{GUARDS}::test_slow_noise_is_a_part_of_the_noise_and_no_effect",
    ),
    Mutation(
        "noise_swallows_the_effect",
        "an effect is judged with the noise that was estimated without it",
        f"{DIAGNOSE}/evidence.py",
        "        base = _with_noise(residuals, under(grown, base.solution))\n",
        "        base = _with_noise(residuals, base.solution.noise)\n",
        f"{GUARDS}::test_the_noise_beside_an_effect_is_estimated_anew",
    ),
    Mutation(
        "no_scatter_is_no_noise",
        "a channel with no reading beyond its coefficients has no noise",
        "sim/arctrue/workbench/inference/noise_fit.py",
        "if freedom < LEAST_FREEDOM and stated is None:",
        "if freedom < -1e9 and stated is None:",
        f"{GUARDS}::test_a_channel_without_repeats_does_not_know_its_noise",
    ),
    Mutation(
        "index_without_prior",
        "four runs that agree by chance have a perfect index",
        "sim/arctrue/workbench/inference/noise_fit.py",
        "total = freedom * prior + float(offsets @ offsets)",
        "total = 0.0 * prior + float(offsets @ offsets)",
        f"{GUARDS}::test_four_runs_do_not_know_the_index_better_than_the_prior_allows",
    ),
    Mutation(
        "runs_are_many",
        "what is known from four runs has the freedom of all rows",
        "sim/arctrue/workbench/noise/sureness.py",
        "        spread += (index / total) ** 2 * 2.0 / known\n",
        "        spread += 0.0 * known\n",
        f"{GUARDS}::test_what_is_known_from_the_runs_has_the_freedom_of_the_runs",
    ),
    Mutation(
        "fits_anything",
        "means of groups never differ by more than their scatter",
        f"{DIAGNOSE}/lack_of_fit.py",
        "f_distribution.sf(between / within, groups - 1, values.size - groups)",
        "f_distribution.sf(0.0 * between / within, groups - 1, values.size - groups)",
        f"{GUARDS}::test_means_of_groups_are_judged_by_the_scatter_within_them",
    ),
    Mutation(
        "line_is_free",
        "a line in time does not pay for the frequencies that were looked at",
        f"{DIAGNOSE}/lack_of_fit.py",
        "log_p = np.log(power.size) + (power.size - 1)",
        "log_p = (power.size - 1)",
        f"{GUARDS}::test_a_line_pays_for_all_frequencies",
    ),
    Mutation(
        "once_is_enough",
        "an order that one run shows is a property of the disc",
        f"{DIAGNOSE}/every_pass.py",
        "    return bool((gain.sum() - gain[strongest]) > LEAST_SHARE * height * others)\n",
        "    return True\n",
        f"{GUARDS}::test_an_order_of_one_run_alone_is_no_property_of_the_disc",
    ),
    Mutation(
        "one_speed_is_enough",
        "a frequency that shows at one of several speeds is a vibration",
        f"{DIAGNOSE}/free_in_runs.py",
        "    return float(gain[other].sum() / gain.sum()) > LEAST_SHARE * expected\n",
        "    return True\n",
        f"{GUARDS}::test_a_frequency_of_one_speed_alone_is_no_vibration",
    ),
    Mutation(
        "untestable_is_absent",
        "an effect that cannot be tested, and would look the same, is not thought of",
        f"{DIAGNOSE}/excluded.py",
        "if alike.size >= best.rank and float(np.min(alike[: best.rank])) > LIKE:",
        "if False:",
        f"{GUARDS}::test_an_effect_that_the_set_cannot_test_forbids_a_sure_name",
    ),
    Mutation(
        "line_before_its_cause",
        "a line without a cause is named beside an effect that says its cause",
        f"{DIAGNOSE}/classes.py",
        "if not item.effect.unspecific or not any(",
        "if True or not any(",
        f"{GUARDS}::test_what_says_why_goes_before_what_says_what_is_seen",
    ),
    Mutation(
        "line_in_every_class",
        "an effect that says its cause is ambiguous with the line that it is",
        f"{DIAGNOSE}/classes.py",
        "if other.effect.unspecific and not best.effect.unspecific:",
        "if False:",
        "sim/tests/workbench/test_periodic_error.py"
        "::test_a_drive_of_a_broken_tooth_count_has_its_own_name",
    ),
    Mutation(
        "frame_by_a_decimal",
        "a head is blamed for an order of the disc by a decimal of the likelihood",
        f"{DIAGNOSE}/parts_scan.py",
        "if value > max(worth) - FRAME_MARGIN",
        "if value >= max(worth)",
        f"{GUARDS}::test_a_more_natural_frame_is_left_only_for_odds_of_twenty_to_one",
    ),
    Mutation(
        "idle_condition",
        "a product has a condition that adds nothing to its wave",
        f"{DIAGNOSE}/parts_scan.py",
        "if worth(item) > max(simpler, default=-np.inf) + FRAME_MARGIN:",
        "if worth(item) > max(simpler, default=-np.inf):",
        f"{GUARDS}::test_a_condition_that_adds_nothing_is_not_a_part",
    ),
    Mutation(
        "adequate_though_little_was_tested",
        "a set that can test one effect says that none is missing",
        f"{DIAGNOSE}/coverage.py",
        "if len(found.untestable) <= MOST_UNTESTED * whole:",
        "if True:",
        f"{COVERAGE}::test_a_set_that_can_test_little_cannot_tell",
    ),
    Mutation(
        "adequate_though_all_is_slow",
        "a set whose residual is all slow noise says that none is missing",
        f"{DIAGNOSE}/coverage.py",
        "if slow > COLOURED_SHARE * variance and size > matters:",
        "if False:",
        f"{COVERAGE}::test_noise_that_is_all_slow_cannot_tell",
    ),
    Mutation(
        "adequate_though_nothing_could_be_found",
        "a set in which an effect would have to exceed the residual says that none is missing",
        f"{DIAGNOSE}/coverage.py",
        "    if unseen <= UNSEEN_SHARE * tried:\n",
        "    if unseen <= tried:\n",
        f"{COVERAGE}::test_a_residual_smaller_than_what_can_be_found_cannot_tell",
    ),
    Mutation(
        "outliers_stay",
        "a row that the recording got wrong is fitted to",
        "sim/arctrue/workbench/observations/outliers.py",
        "far = np.flatnonzero(size > FAR_SIGMA * scatter)",
        "far = np.flatnonzero(size > 1e9 * scatter)",
        f"{OUTLIERS}::test_each_single_wrong_row_is_masked_and_no_other",
    ),
    Mutation(
        "any_share_of_outliers",
        "so many rows are masked that the recording is no longer called faulty",
        "sim/arctrue/workbench/observations/used_rows.py",
        "    if share > MOST_SHARE:\n",
        "    if share > 1.0:\n",
        f"{OUTLIERS}::test_so_many_outliers_are_a_faulty_recording",
    ),
    Mutation(
        "probability_of_what_was_excluded",
        "what adds nothing beside the named effect stays as probable as its own fit",
        f"{DIAGNOSE}/posterior.py",
        "weights[name] = min(value, first + float(np.log(NOTHING_LEFT_P)))",
        "weights[name] = value",
        f"{PROBABILITIES}::test_what_is_named_has_the_largest",
    ),
    Mutation(
        "probability_without_the_untestable",
        "an effect that cannot be tested, and would look the same, has no probability",
        f"{DIAGNOSE}/posterior.py",
        "        weights |= dict.fromkeys(look_alikes, first)\n",
        "",
        f"{PROBABILITIES}::test_a_look_alike_that_cannot_be_tested_is_as_probable",
    ),
)

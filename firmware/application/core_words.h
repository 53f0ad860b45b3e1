/* SPDX-License-Identifier: Apache-2.0 */

/* Converts lanes and means to the words of the coefficient banks and of the prepared sets. */

#ifndef ARCTRUE_CORE_WORDS_H
#define ARCTRUE_CORE_WORDS_H

#include <stdbool.h>
#include <stdint.h>

#include "coefficients.h"
#include "core_access.h"

enum { WORDS_A_LANE = 4 };
/* Numbers of the words in the registers of the mean. The offsets begin at word 0; the weights and the choice of heads
   follow. */
enum { MEAN_WEIGHTS = 4, MEAN_CHOICE = 8, MEAN_WORDS = 9 };

void core_lane_words(const struct lane *lane, uint32_t counts_per_rev, uint32_t modulator,
                     uint32_t words[WORDS_A_LANE]);
/* Returns a word for the registers of the mean; without a mean, head 1 has the whole weight. */
uint32_t core_mean_word(const struct mean_set *mean, uint32_t place);
/* Tells whether the core contains this word of the mean. An access to another word ends with a bus error. */
bool core_mean_word_is_built(const struct core_access *core, uint32_t place);
/* Returns the summand of a word in the check sum of the prepared sets: 0 for the word 0. */
uint32_t core_summand(uint32_t offset, uint32_t word);
/* Writes a word and returns its summand. */
uint32_t core_write_summed(const struct core_access *core, uint32_t offset, uint32_t word);
/* Writes the words of the mean from address `first` on; returns their sum. */
uint32_t core_write_mean(const struct core_access *core, const struct mean_set *mean,
                         uint32_t first);

#endif

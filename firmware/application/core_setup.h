/* SPDX-License-Identifier: Apache-2.0 */

/* Converts the parameters into the registers that set up the core. */

#ifndef ARCTRUE_CORE_SETUP_H
#define ARCTRUE_CORE_SETUP_H

#include "state.h"

/* Returns the words of the registers for the present parameters. The parameters state the ramp's speed and acceleration
   as angles, so that the ramp does not depend on the counts per turn. */
struct core_setup setup_of_parameters(const struct application *application);

#endif

/* SPDX-License-Identifier: Apache-2.0 */

/* From parameters to the registers that set the core up. */

#ifndef ARCTRUE_CORE_SETUP_H
#define ARCTRUE_CORE_SETUP_H

#include "state.h"

/* The registers' words for the parameters as they are. The ramp is the same angle a second whatever the counts of a turn are. */
struct core_setup setup_of_parameters(const struct application *application);

#endif

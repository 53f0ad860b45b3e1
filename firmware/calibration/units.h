/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_UNITS_H
#define ARCTRUE_UNITS_H

#define PI 3.14159265358979323846
#define ARCSEC_PER_TURN 1296000.0
#define ARCSEC_PER_RAD (ARCSEC_PER_TURN / (2.0 * PI))

#endif

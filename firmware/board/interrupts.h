/* SPDX-License-Identifier: Apache-2.0 */

#ifndef ARCTRUE_INTERRUPTS_H
#define ARCTRUE_INTERRUPTS_H

/* Timer and UART to this processor; interrupts on. */
void interrupts_set_up(void);

#endif

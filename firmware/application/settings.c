/* SPDX-License-Identifier: Apache-2.0 */

#include "settings.h"

#include <stddef.h>

struct settings settings_present(const struct application *application) {
    return (struct settings){
        .parameters = application->parameters,
        .frozen = application->frozen,
        .bypassed = application->bypassed,
        .telemetry = application->telemetry,
        .faults_in_a_row = application->faults_in_a_row,
    };
}

void settings_keep(struct application *application) {
    struct settings settings = settings_present(application);
    if (application->kept != NULL) {
        kept_settings_write(application->kept, &settings);
        application->settle();
    }
}

void settings_take(struct application *application, const struct settings *settings) {
    application->parameters = settings->parameters;
    application->frozen = settings->frozen != 0;
    application->bypassed = settings->bypassed != 0;
    application->telemetry = settings->telemetry != 0;
}

void settings_recover(struct application *application) {
    struct settings settings;
    if (application->kept == NULL || !kept_settings_read(application->kept, &settings)) {
        application->settings_origin = SETTINGS_LOST;
        application->bypassed = true;
        application->faults_in_a_row = 1;
        return;
    }
    application->settings_origin = SETTINGS_KEPT;
    settings_take(application, &settings);
    application->faults_in_a_row = settings.faults_in_a_row + 1;
}

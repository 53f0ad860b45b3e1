/* SPDX-License-Identifier: Apache-2.0 */

#include "calibrate_mean.h"

#include <math.h>

#include "arctrue_number_formats.h"
#include "assertion.h"
#include "moved_head.h"
#include "units.h"

/* Relative standard uncertainty of a radius: a rectangular distribution of +-0.1 mm on the paper's radius of 53.975
   mm. */
#define U_RADIUS (0.1 / 1.7320508075688772 / 53.975)
/* Largest share of an axis motion that the present weights may leave in the mean; above it the firmware computes new
   weights. */
#define LEAK_LIMIT 1e-3
/* One count as a u24.4 word. */
#define OFFSET_ONE ((double)(1 << ARCTRUE_HEAD_OFFSET_FRACTION))

bool calibrate_mean_wanted(const struct application *application) {
    uint32_t heads = application->capture.heads;
    const struct load *load = &application->load;
    bool waits = application->saved_state == SAVED_WAITING || load->whole ||
                 load->loaded_state == LOADED_PENDING;
    bool wanted =
        application->configuration.has_mean && heads > 2 && !waits && load_at_work(load) == NULL;
    for (uint32_t head = 2; head < heads; head++) {
        wanted = wanted && parameters_place_deg(&application->parameters, head) != 0.0;
    }
    return wanted;
}

static void offset_words(struct mean_set *mean, const struct heads_geometry *geometry,
                         uint32_t counts_per_rev) {
    for (uint32_t head = 0; head < geometry->heads; head++) {
        double turns = geometry->offset_rad[head] / (2.0 * PI);
        double word = rint((turns - floor(turns)) * OFFSET_ONE * counts_per_rev);
        mean->offset[head] = word < OFFSET_ONE * counts_per_rev ? (uint32_t)word : 0;
    }
}

/* Copies the words of the active mean to `mean` if they were computed for the same number of heads and the same delays;
   otherwise clears `mean`. Returns true if the copied weights still suppress an axis motion. */
static bool mean_goes_on(const struct application *application, const struct heads_found *found,
                         struct mean_set *mean) {
    const struct coefficients *active = state_active(application);
    bool same = active != NULL && active->mean.heads == found->geometry.heads &&
                active->mean.delays == (uint32_t)application->parameters.head_delays;
    *mean = same ? active->mean : (struct mean_set){0};
    return same && heads_leak(&found->geometry, mean->weight) <= LEAK_LIMIT;
}

/* If one head has moved along the scale, adds its motion to its offset, so that the zero of the mean does not move. */
static void mean_follow_moved_head(struct application *application, const struct heads_found *found,
                                   struct mean_set *mean) {
    double one = OFFSET_ONE * application->capture.counts_per_rev;
    double offset_rad[HEADS_MOST];
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        offset_rad[head] = mean->offset[head] * 2.0 * PI / one;
    }
    struct moved_head moved = moved_head_find(&found->geometry, offset_rad);
    if (moved.head != 0) {
        uint32_t *offset = &mean->offset[moved.head - 1];
        double word = rint(*offset + moved.moved_rad / (2.0 * PI) * one);
        word -= word < one ? 0.0 : one;
        *offset = (uint32_t)(word < 0.0 ? word + one : word);
        application->report.moved_head = moved.head;
        application->report.moved_arcsec = moved.moved_rad * ARCSEC_PER_RAD;
        /* The moved head changes the apparent place of the axis. */
        application->found.asynchronous.stated = false;
        if (application->axis != NULL) {
            application->axis->orders = 0;
        }
    }
}

enum refusal calibrate_mean_estimate(struct application *application, const struct turn *turn,
                                     struct mean_set *mean) {
    const struct parameters *parameters = &application->parameters;
    const struct capture *capture = &application->capture;
    struct heads_workspace *workspace = &application->workspace.heads;
    struct heads_found *found = &application->found;
    struct heads_settings settings = {
        .u_place_arcsec = SEPARATION_TOLERANCE_U_ARCSEC,
        .u_index_arcsec = parameters->index_detection_arcsec,
        .u_radius = U_RADIUS,
        .orders = (uint32_t)parameters->orders,
        .axis = application->axis,
    };
    for (uint32_t head = 0; head < HEADS_MOST; head++) {
        settings.place_rad[head] =
            parameters_place_deg(&application->parameters, head) * PI / 180.0;
    }
    enum refusal reason = capture_verify_further(capture, turn, &application->report.fault);
    if (reason == NOT_REFUSED) {
        reason = heads_estimate(workspace, capture, turn, &settings, found, &application->measured);
    }
    bool goes_on = reason == NOT_REFUSED && mean_goes_on(application, found, mean);
    if (reason == NOT_REFUSED && mean->heads != 0) {
        mean_follow_moved_head(application, found, mean);
    }
    if (reason == NOT_REFUSED && !goes_on) {
        bool first = mean->heads == 0;
        mean->heads = found->geometry.heads;
        mean->used = (1U << mean->heads) - 1U;
        mean->delays = (uint32_t)parameters->head_delays;
        if (first) {
            offset_words(mean, &found->geometry, capture->counts_per_rev);
        }
        bool has_weights = heads_weights(&found->geometry, mean->used, mean->weight);
        reason = has_weights ? NOT_REFUSED : REFUSED_NO_MEAN;
    }
    if (reason == NOT_REFUSED) {
        workspace->made.disc = application->measured;
        heads_estimate_of_mean(workspace, found, capture->counts_per_rev, mean,
                               &application->measured);
        bool valid = mean_set_is_valid(mean, mean->heads, capture->counts_per_rev);
        reason =
            valid && estimate_is_finite(&application->measured) ? NOT_REFUSED : REFUSED_AMPLITUDE;
    }
    if (reason != NOT_REFUSED) {
        found->geometry.heads = 0;
    }
    application->report.mean_reason = reason;
    return reason;
}

void calibrate_mean_average(struct application *application, struct mean_set *mean) {
    struct heads_workspace *workspace = &application->workspace.heads;
    struct estimate *disc = &workspace->made.disc;
    average_add(&application->average, disc, application->parameters.keep);
    average_apply(&application->average, disc);
    application->measured = *disc;
    heads_estimate_of_mean(workspace, &application->found, application->capture.counts_per_rev,
                           mean, &application->measured);
}

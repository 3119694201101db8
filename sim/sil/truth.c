#include "truth.h"

#include <lcm/lcm.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "channels.h"
#include "lcm_ssv_vehicle_state_t.h"
#include "ssv/link.h"

#define PERIOD_US INT64_C(100000)

struct truth {
    lcm_t* lcm;
    int64_t next_us;
    ssv_timeline_t timeline; ///< room for what is read of the live one
};

truth_t* truth_open(const char* url, char* error, size_t error_size) {
    truth_t* truth = calloc(1, sizeof *truth);
    if (truth != NULL) truth->lcm = lcm_create(url[0] == '\0' ? NULL : url);
    if (truth != NULL && truth->lcm != NULL) return truth;
    (void)snprintf(error, error_size,
                   "no LCM on %s; for UDP multicast the machine needs a route, e.g. ip route add 224.0.0.0/4 dev lo",
                   url[0] == '\0' ? "its default URL" : url);
    free(truth);
    return NULL;
}

static lcm_ssv_pose_t wire_pose(const rb_pose_t* X) {
    lcm_ssv_pose_t wire;
    memcpy(wire.p_m, X->p_m, sizeof wire.p_m);
    memcpy(wire.q, X->q, sizeof wire.q);
    return wire;
}

void truth_tell(truth_t* truth, const sil_t* sil) {
    uint8_t message[512];
    if (sil->now_us < truth->next_us) return;
    truth->next_us = sil->now_us + PERIOD_US;
    const sim_world_t* world = &sil->world;
    const uint8_t* live = ssv_link_vehicle_live(&sil->vehicle.link, NULL);
    truth->timeline.plan_hash = 0;
    if (live != NULL) ssv_timeline_read_header(live, &truth->timeline, NULL);
    lcm_ssv_vehicle_state_t wire = {
        .time_s = world->t_s,
        .plan_hash = (int64_t)truth->timeline.plan_hash,
        .X_IS = wire_pose(&world->state.eta),
        .X_IB = wire_pose(&world->X_nB),
        .mated = world->beam == SIM_BEAM_CARRIED,
        .docked = world->beam == SIM_BEAM_DOCKED,
    };
    memcpy(wire.v_IS_S_m_s, &world->state.nu[0], sizeof wire.v_IS_S_m_s);
    memcpy(wire.w_IS_S_rad_s, &world->state.nu[3], sizeof wire.w_IS_S_rad_s);
    for (int t = 0; t < SIM_THRUSTERS; t++) wire.u_N[t] = (double)sil->output.u_N[t];
    const int size = lcm_ssv_vehicle_state_t_encode(message, 0, sizeof message, &wire);
    if (size > 0) (void)lcm_publish(truth->lcm, CHANNEL_TRUTH, message, (unsigned)size); // a lost one is not missed
}

void truth_close(truth_t* truth) {
    if (truth == NULL) return;
    lcm_destroy(truth->lcm);
    free(truth);
}

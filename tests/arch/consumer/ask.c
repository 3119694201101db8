/// Somebody else's program that asks a running planner over LCM, by the message types that are installed: the same
/// case study as in fly.c. Prints the price.
///   ask LCM_URL
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <lcm/lcm.h>

#include "channels.h"
#include "lcm_ssv_plan_t.h"
#include "lcm_ssv_task_t.h"

#define REQUEST_ID 42
#define WAIT_MS 500
#define MAX_TRIES 60

static void set_3(double* to, double x, double y, double z) {
    to[0] = x;
    to[1] = y;
    to[2] = z;
}

static void fill_bodies(lcm_ssv_scenario_t* scenario) {
    lcm_ssv_vehicle_t* vehicle = &scenario->vehicle;
    vehicle->body.mass_kg = 76.2;
    set_3(vehicle->body.inertia_kg_m2, 2.7, 2.7, 2.7);
    vehicle->body.drag_lin_kg_s = 413.685;
    vehicle->body.drag_quad_ang_Nm_s2 = 2.2;
    vehicle->radius_m = 0.3025;
    vehicle->force_max_N = 6;
    for (int i = 0; i < 6; i++) {
        const double side = i % 2 == 0 ? 1 : -1;
        vehicle->thruster[i].p_ST_m[(i / 2 + 2) % 3] = side * 0.3025;
        vehicle->thruster[i].n_T_S[i / 2] = side;
    }
    scenario->beam.body.mass_kg = 11.3636;
    set_3(scenario->beam.body.inertia_kg_m2, 8.81, 8.81, 0.0376);
    scenario->beam.radius_m = 0.0606;
    scenario->beam.length_m = 3.048;
    scenario->beam.drag_strip_kg_m2 = 66.66;
}

static lcm_ssv_task_t case_study(void) {
    lcm_ssv_task_t task;
    memset(&task, 0, sizeof task);
    lcm_ssv_scenario_t* scenario = &task.scenario;
    scenario->asker.request_id = REQUEST_ID;
    fill_bodies(scenario);
    scenario->X_IS.q[3] = 1; // scalar first: half a turn about z
    set_3(scenario->X_IB.p_m, 5, 0, 0);
    scenario->X_IB.q[0] = scenario->X_IB.q[2] = sqrt(0.5);
    set_3(scenario->port.p_IP_m, 6.524, 5, 0);
    set_3(scenario->port.axis_I, 0, -1, 0);
    scenario->standoff_m = 0.3025;
    scenario->weight_time_per_s = scenario->weight_impulse_per_Ns = 1;
    return task;
}

static void received(const lcm_recv_buf_t* packet, const char* channel, void* context) {
    lcm_ssv_plan_t* plan = (lcm_ssv_plan_t*)context;
    (void)channel;
    lcm_ssv_plan_t answer;
    if (lcm_ssv_plan_t_decode(packet->data, 0, (int)packet->data_size, &answer) < 0) return;
    if (answer.answer.asker.request_id == REQUEST_ID) *plan = answer;
}

int main(int argc, char** argv) {
    lcm_t* const lcm = argc == 2 ? lcm_create(argv[1]) : NULL;
    lcm_ssv_plan_t plan;
    memset(&plan, 0, sizeof plan);
    if (lcm == NULL || lcm_subscribe(lcm, CHANNEL_PLAN, received, &plan) == NULL) {
        fprintf(stderr, "no LCM on %s\n", argc == 2 ? argv[1] : "no address");
        return 1;
    }
    const lcm_ssv_task_t task = case_study();
    const int size = lcm_ssv_task_t_encoded_size(&task);
    void* const bytes = malloc((size_t)size);
    if (bytes == NULL || lcm_ssv_task_t_encode(bytes, 0, size, &task) != size) return 1;
    for (int n = 0; n < MAX_TRIES && plan.answer.asker.request_id != REQUEST_ID; n++) { // a datagram may be lost
        lcm_publish(lcm, CHANNEL_SCENARIO, bytes, (unsigned)size);
        lcm_handle_timeout(lcm, WAIT_MS);
    }
    free(bytes);
    lcm_destroy(lcm);
    if (plan.answer.asker.request_id != REQUEST_ID || plan.quote.status != LCM_SSV_QUOTE_T_STATUS_OK) {
        fprintf(stderr, "no plan\n");
        return 1;
    }
    printf("%a\n", plan.quote.cost);
    lcm_ssv_plan_t_decode_cleanup(&plan);
    return 0;
}

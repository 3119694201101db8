#include "scene.h"

#include <string.h>

void scene_of_plan(const plan_file_t* plan, sil_config_t* config) {
    memset(config, 0, sizeof *config);
    config->world.vehicle = plan->vehicle;
    config->world.beam = plan->beam;
    memcpy(config->world.thruster, plan->thruster, sizeof config->world.thruster);
    config->world.X_nb = plan->X_IS;
    config->world.X_nB = plan->X_IB;
    config->place = (sim_mate_place_t){plan->standoff_m, plan->attach_height_m, plan->ring_angle_rad};
    config->port.contact = plan->contact;
    memcpy(config->port.p_nP_m, plan->p_IP_m, sizeof config->port.p_nP_m);
    memcpy(config->port.axis_n, plan->axis_I, sizeof config->port.axis_n);
    config->around = plan->around;
    config->force_max_N = plan->force_max_N;
    config->boot_id = 1;
}

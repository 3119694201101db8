// The SSV of the paper as a vehicle: three pairs of thrusters on the hull, each pair's equal thrusts pure moment and
// its opposite ones force.
#include <string.h>

#include "ssv/vehicle.h"

static const ssv_link_parameter_t parameters[] = {
    {"SSV_BEAT_WARN_S", 0.5F}, {"SSV_BEAT_STOP_S", 1}, {"SSV_FORCE_N", 6}, {"SSV_TICK_S", 0.005F}};

#define HULL_M 0.3025F

void ssv_vehicle_config_default(ssv_vehicle_config_t* config, uint32_t boot_id) {
    memset(config, 0, sizeof *config);
    config->link = (ssv_link_vehicle_config_t){.sysid = SSV_LINK_VEHICLE_SYSID,
                                               .compid = SSV_LINK_VEHICLE_COMPID,
                                               .boot_id = boot_id,
                                               .version = 0x00010000,
                                               .parameters = parameters,
                                               .num_parameters = sizeof parameters / sizeof *parameters,
                                               .force_max_N = 6,
                                               .start_tolerance_m = 0.05F,
                                               .start_tolerance_rad = 0.05F};
    config->thrust_max_N = 7.5F;
    config->beat_warn_us = 500000;
    config->beat_stop_us = 1000000;
    config->trim_hold_us = 300000;
    config->trim_ramp_us = 500000;
    config->trim_stop_us = 1000000;
    config->trim_max_N = 12; // from full thrust one way to full thrust the other
    config->brake_kg_s = 100;
    config->brake_Nm_s = 4;
    config->brake_speed_m_s = 0.005F;
    config->brake_rate_rad_s = 0.005F;
    config->brake_max_us = 30000000;
    config->navigation_stale_us = 1000000;
    // The pair that pushes along axis i turns about axis (i + 1) % 3: at +z along x, at +x along y, at +y along z.
    for (int i = 0; i < 3; i++) {
        for (int end = 0; end < 2; end++) {
            config->u_per_wrench[2 * i + end][i] = end == 0 ? 0.5F : -0.5F;
            config->u_per_wrench[2 * i + end][3 + (i + 1) % 3] = 0.5F / HULL_M;
        }
    }
}

// The core's samples of a plan that came as JSON, one line each: time, pose, velocity, rate and thrusts.
#include <stdio.h>
#include <stdlib.h>

#include "ssv/answer.h"
#include "wire/message.h"

int main(int argc, char** argv) {
    static char text[TREE_YAML_MAX], error[1024];
    static ssv_plan_t plan;
    lcm_ssv_plan_t message;
    const int count = argc == 2 ? atoi(argv[1]) : 0;
    const size_t size = fread(text, 1, sizeof text, stdin);
    const wire_part_t part = {"plan", "plan_t", &message};
    if (count <= 0 || !wire_json_read("standard input", text, size, &part, 1, error, sizeof error)) {
        fprintf(stderr, "Usage: plan_samples COUNT <PLAN.json: %s\n", error);
        return 64;
    }
    ssv_plan_from_wire(&plan, &message);
    for (int i = 0; i < count; i++) {
        ssv_sample_t at;
        const double t_s = message.quote.time_s * (i + 0.37) / count;
        ssv_plan_sample(&plan, t_s, &at);
        printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g", t_s, at.X_IS.p.x,
               at.X_IS.p.y, at.X_IS.p.z, at.X_IS.q.w, at.X_IS.q.x, at.X_IS.q.y, at.X_IS.q.z, at.v_IS_S_m_s.x,
               at.v_IS_S_m_s.y, at.v_IS_S_m_s.z, at.w_IS_S_rad_s.x, at.w_IS_S_rad_s.y, at.w_IS_S_rad_s.z);
        for (int n = 0; n < SSV_NUM_THRUSTERS; n++) printf(" %.17g", at.u_N[n]);
        putchar('\n');
    }
    wire_clear("plan_t", &message);
    return 0;
}

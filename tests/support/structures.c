#include "structures.h"

#include <string.h>

#include "sample.h"

#define HOST_DIR SSV_SOURCE_DIR "/host"

static structure_t ease;

bool structures_open(char* error, size_t error_size) {
    return structure_read(&ease, HOST_DIR "/structures/ease.yaml", HOST_DIR "/models", error, error_size);
}

void structures_numbers_of_vector(vec3_t v, double n[3]) {
    n[0] = real_to_double(v.x);
    n[1] = real_to_double(v.y);
    n[2] = real_to_double(v.z);
}

void structures_numbers_of_attitude(quat_t q, double n[4]) {
    n[0] = real_to_double(q.w);
    n[1] = real_to_double(q.x);
    n[2] = real_to_double(q.y);
    n[3] = real_to_double(q.z);
}

bool structures_share_a_hub(const structure_slot_t* a, const structure_slot_t* b) {
    return a->hub[0] == b->hub[0] || a->hub[0] == b->hub[1] || a->hub[1] == b->hub[0] || a->hub[1] == b->hub[1];
}

void structures_find_touching(structure_t* structure) {
    for (int s = 0; s < structure->num_slots; s++) {
        structure->slot[s].touches = 0;
        for (int k = 0; k < structure->num_slots; k++) {
            if (k != s && structures_share_a_hub(&structure->slot[s], &structure->slot[k])) {
                structure->slot[s].touches |= set_of(k);
            }
        }
    }
}

structure_t structures_sample(int num_slots) {
    structure_t s = ease;
    s.num_slots = num_slots;
    s.num_beams = num_slots + sample_below(2);
    for (int i = 0; i < num_slots; i++) {
        int taken;
        do {
            taken = sample_below(ease.num_slots);
            s.slot[i] = ease.slot[taken];
            for (int k = 0; k < i; k++) taken = strcmp(s.slot[k].name, s.slot[i].name) == 0 ? -1 : taken;
        } while (taken < 0);
        for (int k = 0; k < i; k++) s.slot[i].after |= (set_t)(sample_below(4) == 0) << k;
    }
    structures_find_touching(&s);
    for (int b = 0; b < s.num_beams; b++) {
        structures_numbers_of_vector(sample_vector(3), s.beam[b].p_IB_m);
        structures_numbers_of_attitude(sample_attitude(), s.beam[b].q_IB);
        s.beam[b].p_IB_m[0] -= 7;
    }
    s.slot[sample_below(num_slots)].beam = sample_below(4) == 0 ? sample_below(s.num_beams) : -1;
    structures_numbers_of_vector(sample_vector(2), s.p_IS_m);
    structures_numbers_of_attitude(sample_attitude(), s.q_IS);
    s.p_IS_m[1] += 7;
    s.touching = sample_below(2) == 0;
    s.obstacles = sample_below(3) != 0;
    s.task.weight_time_per_s = sample_below(3) == 0 ? 0 : 1;
    s.task.weight_impulse_per_Ns = s.task.weight_time_per_s > 0 && sample_below(2) == 0 ? 0.1 : 1;
    return s;
}

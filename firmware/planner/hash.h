/// 64-bit FNV-1a over values in a fixed byte order, so that a hash says the same on every machine.
#ifndef SSV_HASH_H
#define SSV_HASH_H

#include "ssv/vec3.h"

#define SSV_HASH_START UINT64_C(0xcbf29ce484222325)

uint64_t ssv_hash_u64(uint64_t hash, uint64_t value);
uint64_t ssv_hash_int(uint64_t hash, int value);
uint64_t ssv_hash_real(uint64_t hash, real_t value);
uint64_t ssv_hash_vec3(uint64_t hash, vec3_t value);
uint64_t ssv_hash_pose(uint64_t hash, pose_t value);

#endif

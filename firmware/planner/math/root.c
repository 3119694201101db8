// Bookkeeping of a bracketed root: which end a value belongs to, and what the next argument is.
#include "planner/math/root.h"

#include "planner/math/assert.h"

ssv_root_t ssv_root_between(real_t target, real_t low, real_t y_low, real_t high, real_t y_high) {
    SSV_ASSERT(!(low > high));
    return (ssv_root_t){
        .target = target, .low = low, .high = high, .y_low = y_low, .y_high = y_high, .bracketed = true};
}

ssv_root_t ssv_root_from(real_t target, real_t low, real_t y_low, real_t high) {
    SSV_ASSERT(!(low > high) && !(y_low > target));
    return (ssv_root_t){.target = target, .low = low, .high = high, .y_low = y_low, .y_high = target};
}

void ssv_root_tell(ssv_root_t* root, real_t x, real_t y) {
    SSV_ASSERT(!(x < root->low));
    root->above = y > root->target;
    *(root->above ? &root->high : &root->low) = x;
    *(root->above ? &root->y_high : &root->y_low) = y;
    root->bracketed = root->bracketed || root->above;
    root->num_told++;
}

void ssv_root_tell_illinois(ssv_root_t* root, real_t x, real_t y) {
    const bool may_stay = root->bracketed && root->num_told > 0, was_above = root->above;
    ssv_root_tell(root, x, y);
    if (!may_stay || root->above != was_above) return;
    real_t* stale = root->above ? &root->y_low : &root->y_high;
    *stale = root->target + real_mul(REAL(0.5), *stale - root->target);
}

real_t ssv_root_share(const ssv_root_t* root) {
    SSV_ASSERT(root->bracketed);
    return real_div(root->target - root->y_low, root->y_high - root->y_low);
}

real_t ssv_root_middle(const ssv_root_t* root) { return real_mul(REAL(0.5), root->low + root->high); }

real_t ssv_root_propose(const ssv_root_t* root) {
    if (root->num_told % 3 == 0) return ssv_root_middle(root);
    return root->low + real_mul(root->high - root->low, ssv_root_share(root));
}

bool ssv_root_is_inside(const ssv_root_t* root, real_t x) { return x > root->low && x < root->high; }

bool ssv_root_is_exhausted(const ssv_root_t* root) {
    const real_t middle = ssv_root_middle(root);
    return middle == root->low || middle == root->high;
}

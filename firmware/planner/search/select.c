#include "planner/search/select.h"

#include "planner/math/assert.h"
#include "planner/motion/maneuver.h"
#include "planner/motion/price_order.h"
#include "planner/search/bound.h"
#include "planner/search/budget.h"
#include "planner/search/capability.h"
#include "planner/search/optimal.h"
#include "planner/search/paper.h"
#include "planner/search/room.h"
#include "planner/search/screen.h"
#include "planner/search/tolerance.h"

// The cheapest candidate that is still feasible; -1 if there is none.
static int cheapest(const ssv_quote_t* quote) {
    int best = -1;
    for (int k = 0; k < quote->num_candidates; k++) {
        const ssv_candidate_t* candidate = &quote->candidate[k];
        if (candidate->outcome != SSV_FEASIBLE) continue;
        if (best < 0 || candidate->cost < quote->candidate[best].cost) best = k;
    }
    return best;
}

// Enters what a search of a candidate found, if it is cheaper than what is there.
static void improve(ssv_candidate_t* known, ssv_candidate_t found) {
    if (known->outcome != SSV_FEASIBLE || (found.outcome == SSV_FEASIBLE && found.cost < known->cost)) *known = found;
}

static void enter_candidates(const ssv_scenario_t* scenario, ssv_quote_t* quote) {
    for (int contact = 1; contact <= SSV_NUM_CONTACTS; contact++) {
        if (scenario->contact != 0 && scenario->contact != contact) continue;
        for (int k = 0; k < scenario->num_attach_heights; k++) {
            SSV_ASSERT(quote->num_candidates < SSV_MAX_CANDIDATES);
            quote->candidate[quote->num_candidates++] = (ssv_candidate_t){
                .contact = contact, .attach_height_m = scenario->attach_heights_m[k], .outcome = SSV_NO_AUTHORITY};
        }
    }
}

// Whether an end of its phases is blocked, so that there is nothing to search.
static bool is_blocked(const ssv_candidate_t* candidate) { return candidate->outcome >= SSV_START_BLOCKED; }

// Finds out which candidates are blocked. @return whether all are.
static bool check_room(const ssv_question_t* question, ssv_quote_t* quote) {
    bool all = true;
    for (int k = 0; k < quote->num_candidates; k++) {
        if (question->problem->around.counts) ssv_room_check(question, &quote->candidate[k]);
        all = all && is_blocked(&quote->candidate[k]);
    }
    return all;
}

// The paper's path of the next candidate, if that may be cheaper than what is known. @return whether it was the last.
static bool try_paper(ssv_choice_t* choice, ssv_quote_t* quote) {
    if (choice->num_done == 0) ssv_paper_search_begin(&choice->paper, &choice->question, &choice->best.price);
    if (choice->num_done == quote->num_candidates) return true;
    ssv_candidate_t* candidate = &quote->candidate[choice->num_done++];
    if (is_blocked(candidate)) return choice->num_done == quote->num_candidates;
    const int num_priced = choice->paper.num_priced;
    ssv_path_t path;
    if (ssv_paper_search(&choice->paper, candidate->contact, candidate->attach_height_m, &path)) {
        improve(candidate, ssv_candidate_of(&path.grasp, &path.price, &choice->paper.clearance));
        if (ssv_price_beats(&path.price, &choice->best.price)) choice->best = path;
    }
    quote->num_priced += choice->paper.num_priced - num_priced;
    return choice->num_done == quote->num_candidates;
}

// The candidate that promises least of those that are not marked; -1 if there is none.
static int least_of(const ssv_prospects_t* prospects, const bool marked[SSV_MAX_CANDIDATES]) {
    const real_t* promise = prospects->promise;
    int least = -1;
    for (int k = 0; k < prospects->num; k++) {
        if (!marked[k] && (least < 0 || ssv_clearly_less(promise[k], promise[least]))) least = k;
    }
    return least;
}

static ssv_search_t search_of(ssv_choice_t* choice, ssv_quote_t* quote) {
    return (ssv_search_t){&choice->question, &choice->memory, &choice->best, &quote->num_priced};
}

// Effort best screens what effort quick has found no price for; the others promise that price.
static void begin_screening(ssv_choice_t* choice, ssv_effort_t effort, ssv_quote_t* quote) {
    const ssv_search_t search = search_of(choice, quote);
    ssv_prospects_t* prospects = &choice->prospects;
    const bool knows_prices = effort == SSV_EFFORT_BEST && choice->detour < 0;
    choice->stage = SSV_CHOICE_SCREENS;
    choice->effort = effort;
    choice->num_done = 0;
    choice->tries_all = false;
    *prospects = (ssv_prospects_t){.num = quote->num_candidates, .favourite = -1};
    for (int k = 0; k < prospects->num; k++) {
        const ssv_candidate_t* candidate = &quote->candidate[k];
        prospects->screened[k] = prospects->done[k] = is_blocked(candidate);
        if (knows_prices && candidate->outcome == SSV_FEASIBLE) {
            prospects->promise[k] = candidate->cost;
            prospects->screened[k] = true;
            if (prospects->favourite < 0 || candidate->cost < prospects->promise[prospects->favourite])
                prospects->favourite = k;
        } else {
            prospects->promise[k] = ssv_screen_flights(&search, candidate->contact, candidate->attach_height_m);
        }
    }
}

static const ssv_budget_t* budget_of(const ssv_choice_t* choice) {
    return ssv_budget(choice->memory.capability.regime, choice->effort);
}

// Screens the next candidate: those with short flights. @return whether it was the last.
static bool screen_next(ssv_choice_t* choice, ssv_quote_t* quote) {
    const ssv_search_t search = search_of(choice, quote);
    const bool all = choice->tries_all;
    const ssv_budget_t* budget = budget_of(choice);
    ssv_prospects_t* prospects = &choice->prospects;
    while (choice->num_done < prospects->num) {
        const int n = choice->num_done++, next = least_of(prospects, prospects->screened);
        if (next < 0) {
            choice->num_done = prospects->num; // the rest is blocked
            break;
        }
        const ssv_candidate_t* candidate = &quote->candidate[next];
        const real_t* to_beat = prospects->favourite >= 0 ? &prospects->promise[prospects->favourite] : NULL;
        const real_t flights = prospects->promise[next];
        prospects->screened[next] = true;
        // Skip screening when the straight flights alone, plus half of the turning cost of the best candidate so far,
        // already cost as much as that candidate.
        prospects->done[next] =
            !all && to_beat != NULL &&
            (n >= budget->num_screened || flights + real_mul(SSV_TURNS_AT_LEAST, prospects->turns) >= *to_beat);
        if (prospects->done[next]) continue;
        prospects->promise[next] = ssv_screen(&search, candidate->contact, candidate->attach_height_m, to_beat);
        if (to_beat == NULL || ssv_clearly_less(prospects->promise[next], *to_beat)) {
            prospects->favourite = next;
            prospects->turns = prospects->promise[next] - flights;
        }
        break;
    }
    return choice->num_done == prospects->num;
}

// Whether the search goes on to this candidate, the n-th: with effort quick the most promising, with effort best each
// one. What a quick search finds says little of what there is: at the cheapest height it may cost twice as much.
static bool is_worth_a_search(const ssv_choice_t* choice, int next) {
    const ssv_prospects_t* prospects = &choice->prospects;
    const ssv_price_t* best = &choice->best.price;
    if (next < 0) return false;
    if (choice->tries_all && !choice->question.list_candidates) return best->outcome != SSV_FEASIBLE;
    const int n = choice->num_done;
    const real_t least = prospects->promise[prospects->favourite], promise = prospects->promise[next];
    if (n == 0 || choice->effort == SSV_EFFORT_BEST) return true;
    if (n >= budget_of(choice)->num_searched && !ssv_alike(least, promise)) return false;
    return best->outcome != SSV_FEASIBLE || promise < real_mul(SSV_SEARCH_GAIN, best->cost);
}

// Searches the next candidate. @return whether that was the last.
static bool search_next(ssv_choice_t* choice, ssv_quote_t* quote) {
    const ssv_search_t search = search_of(choice, quote);
    ssv_prospects_t* prospects = &choice->prospects;
    const int n = choice->num_done, next = n == 0 ? prospects->favourite : least_of(prospects, prospects->done);
    if (n == prospects->num || !is_worth_a_search(choice, next)) return true;
    ssv_candidate_t* candidate = &quote->candidate[next];
    const int contact = candidate->contact;
    const real_t height_m = candidate->attach_height_m;
    prospects->done[next] = prospects->searched[next] = true;
    // What the last screening kept is that of the favourite.
    if (n > 0 && choice->effort == SSV_EFFORT_QUICK) (void)ssv_screen(&search, contact, height_m, NULL);
    improve(candidate, ssv_optimal_search(&search, contact, height_m, choice->effort));
    choice->num_done++;
    return false;
}

// A quick search of the next candidate that has had none: where all are to be listed, and for effort best, so that it
// never costs more than one of such a list. @return whether there was none left.
static bool search_rest(ssv_choice_t* choice, ssv_quote_t* quote) {
    const ssv_search_t search = search_of(choice, quote);
    bool* searched = choice->prospects.searched;
    int next = 0;
    while (next < quote->num_candidates && (searched[next] || is_blocked(&quote->candidate[next]))) next++;
    if (next == quote->num_candidates) return true;
    ssv_candidate_t* candidate = &quote->candidate[next];
    searched[next] = true;
    (void)ssv_screen(&search, candidate->contact, candidate->attach_height_m, NULL);
    improve(candidate, ssv_optimal_search(&search, candidate->contact, candidate->attach_height_m, SSV_EFFORT_QUICK));
    return false;
}

// Steps along the beam from the best height so far, one to each side, shorter where neither gains; each with a quick
// search. @return whether these were the last.
static bool step_along_beam(ssv_choice_t* choice, ssv_quote_t* quote) {
    const ssv_search_t search = search_of(choice, quote);
    const ssv_path_t* best = &choice->best;
    const real_t length = choice->question.problem->scenario.beam.length_m, end = real_mul(REAL(0.5), length);
    if (choice->num_done == SSV_NUM_HEIGHT_STEPS || best->price.outcome != SSV_FEASIBLE) return true;
    const real_t from = best->grasp.height_m, step = choice->along_step_m;
    for (int side = -1; side <= 1; side += 2) {
        const real_t height_m = real_max(-end, real_min(end, side < 0 ? from - step : from + step));
        if (height_m == from) continue;
        const int contact = best->grasp.contact;
        (void)ssv_screen(&search, contact, height_m, NULL);
        (void)ssv_optimal_search(&search, contact, height_m, SSV_EFFORT_QUICK);
    }
    if (best->grasp.height_m == from) choice->along_step_m = real_mul(REAL(0.5), step);
    choice->num_done++;
    return false;
}

// More effort starts with what less effort does, and the paper's paths follow where these could still be cheaper:
// neither ever costs more.
static void begin_stage(ssv_choice_t* choice, ssv_choice_stage_t stage) {
    choice->stage = stage;
    choice->num_done = 0;
}

static void begin_after_quick(ssv_choice_t* choice) {
    const bool all = choice->question.list_candidates || choice->question.problem->scenario.effort == SSV_EFFORT_BEST;
    begin_stage(choice, all ? SSV_CHOICE_SEARCHES_REST : SSV_CHOICE_TRIES_PAPER);
}

static void begin_after_rest(ssv_choice_t* choice, ssv_quote_t* quote) {
    const ssv_scenario_t* scenario = &choice->question.problem->scenario;
    const bool between = scenario->attach_anywhere && choice->best.price.outcome == SSV_FEASIBLE;
    if (scenario->effort != SSV_EFFORT_BEST) {
        begin_stage(choice, SSV_CHOICE_TRIES_PAPER);
        return;
    }
    choice->between_contact = between ? choice->best.grasp.contact : 0;
    choice->between_height_m = choice->best.grasp.height_m;
    begin_screening(choice, SSV_EFFORT_BEST, quote);
}

// Where nothing that was searched keeps clear, the search goes on to what was left out. @return whether there is any.
static bool begin_rest(ssv_choice_t* choice, const ssv_quote_t* quote) {
    ssv_prospects_t* prospects = &choice->prospects;
    const bool needs_more = choice->question.problem->around.counts && choice->best.price.outcome != SSV_FEASIBLE;
    if (!needs_more || choice->tries_all) return false;
    bool any = false;
    choice->tries_all = true;
    for (int k = 0; k < prospects->num; k++) {
        prospects->done[k] = prospects->searched[k] || is_blocked(&quote->candidate[k]);
        any = any || !prospects->done[k];
    }
    return any;
}

// Where nothing keeps clear, one detour after the other, until something does. Effort best, which has been along its
// own way, starts with what effort quick does and then does better.
static void begin_detour(ssv_choice_t* choice, ssv_quote_t* quote) {
    ssv_question_t* question = &choice->question;
    const ssv_scenario_t* scenario = &question->problem->scenario;
    const bool found = choice->best.price.outcome == SSV_FEASIBLE, best = scenario->effort == SSV_EFFORT_BEST;
    const bool improves = best && choice->detour >= 0 && choice->effort == SSV_EFFORT_QUICK;
    const bool goes_on = question->problem->around.counts && question->method == SSV_METHOD_OPTIMAL;
    choice->detour++;
    if (best && (found || choice->detour == SSV_SAME_DETOUR)) choice->detour = SSV_SAME_DETOUR + 1;
    if (!goes_on || (found && !improves) || choice->detour == SSV_NUM_DETOURS) {
        begin_stage(choice, SSV_CHOICE_IS_MADE);
        return;
    }
    const ssv_detour_t* detour = &ssv_detours[choice->detour];
    question->approach_mate_m = real_max(scenario->approach_mate_m, detour->approach_mate_m);
    question->approach_dock_m = real_max(scenario->approach_dock_m, detour->approach_dock_m);
    begin_screening(choice, detour->effort, quote);
    choice->tries_all = !found;
}

static void begin_after_searches(ssv_choice_t* choice, ssv_quote_t* quote) {
    const ssv_scenario_t* scenario = &choice->question.problem->scenario;
    if (begin_rest(choice, quote)) return;
    if (choice->detour >= 0) {
        begin_detour(choice, quote);
        return;
    }
    if (choice->effort == SSV_EFFORT_BEST) {
        begin_stage(choice, choice->between_contact > 0 ? SSV_CHOICE_SEARCHES_BETWEEN : SSV_CHOICE_TRIES_PAPER);
    } else if (scenario->attach_anywhere) {
        choice->along_step_m = real_mul(SSV_FIRST_HEIGHT_STEP, scenario->beam.length_m);
        begin_stage(choice, SSV_CHOICE_STEPS_ALONG);
    } else {
        begin_after_quick(choice);
    }
}

void ssv_choice_begin(const ssv_question_t* question, ssv_choice_t* choice, ssv_quote_t* quote) {
    const uint32_t overflows = real_overflows();
    memset(quote, 0, sizeof *quote);
    quote->status = SSV_INFEASIBLE;
    quote->scenario_hash = question->problem->scenario_hash;
    choice->question = *question;
    choice->best.price.outcome = SSV_TOO_LONG;
    enter_candidates(&question->problem->scenario, quote);
    const bool blocked = check_room(question, quote);
    choice->detour = -1;
    if (blocked) {
        begin_stage(choice, SSV_CHOICE_IS_MADE);
    } else if (question->method == SSV_METHOD_OPTIMAL) {
        ssv_capability_init(&choice->question, &choice->memory.capability);
        begin_screening(choice, SSV_EFFORT_QUICK, quote);
    } else {
        begin_stage(choice, SSV_CHOICE_TRIES_PAPER);
    }
    choice->overflowed = real_overflows() != overflows;
}

bool ssv_choice_step(ssv_choice_t* choice, ssv_quote_t* quote) {
    const uint32_t overflows = real_overflows();
    const ssv_search_t search = search_of(choice, quote);
    switch (choice->stage) {
        case SSV_CHOICE_SCREENS:
            if (screen_next(choice, quote)) begin_stage(choice, SSV_CHOICE_SEARCHES);
            break;
        case SSV_CHOICE_SEARCHES:
            if (search_next(choice, quote)) begin_after_searches(choice, quote);
            break;
        case SSV_CHOICE_STEPS_ALONG:
            if (step_along_beam(choice, quote)) begin_after_quick(choice);
            break;
        case SSV_CHOICE_SEARCHES_REST:
            if (search_rest(choice, quote)) begin_after_rest(choice, quote);
            break;
        case SSV_CHOICE_SEARCHES_BETWEEN:
            (void)ssv_optimal_search(&search, choice->between_contact, choice->between_height_m, SSV_EFFORT_BEST);
            begin_stage(choice, SSV_CHOICE_TRIES_PAPER);
            break;
        case SSV_CHOICE_TRIES_PAPER:
            if (try_paper(choice, quote)) begin_detour(choice, quote);
            break;
        case SSV_CHOICE_IS_MADE: break;
    }
    if (real_overflows() != overflows) choice->overflowed = true;
    return choice->stage == SSV_CHOICE_IS_MADE;
}

bool ssv_choice_next(ssv_choice_t* choice, ssv_outcome_t outcome, ssv_quote_t* quote) {
    SSV_ASSERT(choice->question.method == SSV_METHOD_PAPER && outcome != SSV_FEASIBLE);
    const uint32_t overflows = real_overflows();
    int k = cheapest(quote);
    if (k >= 0) quote->candidate[k].outcome = outcome;
    k = cheapest(quote);
    if (k < 0) return false;
    const ssv_candidate_t* candidate = &quote->candidate[k];
    const ssv_price_t nothing = {.outcome = SSV_TOO_LONG};
    ssv_paper_search_begin(&choice->paper, &choice->question, &nothing);
    (void)ssv_paper_search(&choice->paper, candidate->contact, candidate->attach_height_m, &choice->best);
    quote->num_priced += choice->paper.num_priced;
    if (real_overflows() != overflows) choice->overflowed = true;
    return true;
}

void ssv_quote_finish_price(const ssv_question_t* question, const ssv_path_t* path, ssv_quote_t* quote) {
    quote->choice = ssv_candidate_of(&path->grasp, &path->price, NULL);
    quote->status = SSV_OK;
    quote->cost = quote->choice.cost;
    quote->time_s = quote->choice.time_s;
    quote->impulse_Ns = quote->choice.impulse_Ns;
    quote->lower_bound = ssv_least_price(question);
    quote->X_IS_final = question->problem->scenario.X_IS;
    for (int k = 0; k < path->num_maneuvers; k++) {
        const ssv_maneuver_t* maneuver = &path->maneuver[k];
        if (!(maneuver->length > REAL(0))) continue;
        quote->X_IS_final = ssv_maneuver_pose(quote->X_IS_final, maneuver->twist, maneuver->length);
    }
    quote->X_IB_final = pose_mul(quote->X_IS_final, path->X_SB);
    for (int k = 0; k < quote->num_candidates; k++) {
        ssv_candidate_t* candidate = &quote->candidate[k];
        const bool chosen =
            candidate->contact == path->grasp.contact && candidate->attach_height_m == path->grasp.height_m;
        if (chosen) *candidate = quote->choice;
    }
    if (question->list_candidates) return;
    quote->num_candidates = 0;
    memset(quote->candidate, 0, sizeof quote->candidate);
}

ssv_status_t ssv_quote_finish_status(const ssv_question_t* question, bool overflowed, ssv_quote_t* quote) {
    if (!overflowed && real_is_finite(quote->cost)) {
        // What motions that did not fit a plan added up is no price.
        if (quote->status != SSV_OK) quote->cost = quote->time_s = quote->impulse_Ns = REAL(0);
        return quote->status;
    }
    memset(quote, 0, sizeof *quote);
    quote->status = SSV_NUMERIC_OVERFLOW;
    quote->scenario_hash = question->problem->scenario_hash;
    return quote->status;
}

bool ssv_choice_quote_step(ssv_choice_t* choice, ssv_quote_t* quote) {
    if (!ssv_choice_step(choice, quote)) return false;
    const uint32_t overflows = real_overflows();
    if (choice->best.price.outcome == SSV_FEASIBLE) {
        ssv_quote_finish_price(&choice->question, &choice->best, quote);
    }
    (void)ssv_quote_finish_status(&choice->question, choice->overflowed || real_overflows() != overflows, quote);
    return true;
}

_Static_assert(sizeof(ssv_choice_t) <= sizeof(ssv_work_t), "a quote under way fits the memory to work in");
_Static_assert(_Alignof(ssv_choice_t) <= _Alignof(ssv_work_t), "and may stand there");

void ssv_quote_begin(const ssv_problem_t* problem, ssv_work_t* work, ssv_quote_t* quote) {
    const ssv_question_t question = ssv_question_of(problem);
    ssv_choice_begin(&question, (ssv_choice_t*)work, quote);
}

bool ssv_quote_step(ssv_work_t* work, ssv_quote_t* quote) { return ssv_choice_quote_step((ssv_choice_t*)work, quote); }

ssv_status_t ssv_quote(const ssv_problem_t* problem, ssv_work_t* work, ssv_quote_t* quote) {
    ssv_quote_begin(problem, work, quote);
    while (!ssv_quote_step(work, quote)) {}
    return quote->status;
}

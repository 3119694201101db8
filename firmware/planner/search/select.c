#include "planner/search/select.h"

#include "planner/math/assert.h"
#include "planner/motion/maneuver.h"
#include "planner/motion/price_order.h"
#include "planner/search/bound.h"
#include "planner/search/budget.h"
#include "planner/search/capability.h"
#include "planner/search/optimal.h"
#include "planner/search/paper.h"
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
                contact, scenario->attach_heights_m[k], REAL(0), SSV_NO_AUTHORITY, REAL(0), REAL(0), REAL(0)};
        }
    }
}

// The paper's path of each candidate that may be cheaper than what is known.
static void search_paper(const ssv_question_t* question, ssv_quote_t* quote, ssv_path_t* best) {
    ssv_paper_search_t search;
    ssv_paper_search_begin(&search, question, &best->price);
    ssv_path_t path;
    for (int k = 0; k < quote->num_candidates; k++) {
        ssv_candidate_t* candidate = &quote->candidate[k];
        if (!ssv_paper_search(&search, candidate->contact, candidate->attach_height_m, &path)) continue;
        improve(candidate, ssv_candidate_of(&path.grasp, &path.price));
        if (ssv_price_beats(&path.price, &best->price)) *best = path;
    }
    quote->num_priced += search.num_priced;
}

// What is known of the candidates while they are screened and searched.
typedef struct {
    int num;
    real_t promise[SSV_MAX_CANDIDATES]; // price of the flights alone at first, then what screening finds
    bool screened[SSV_MAX_CANDIDATES];  // or left out
    bool done[SSV_MAX_CANDIDATES];      // searched, or left out
    int favourite;                      // promises least of those screened; -1 before the first
} prospects_t;

// The candidate that promises least of those that are not marked; -1 if there is none.
static int least_of(const prospects_t* prospects, const bool marked[SSV_MAX_CANDIDATES]) {
    const real_t* promise = prospects->promise;
    int least = -1;
    for (int k = 0; k < prospects->num; k++) {
        if (!marked[k] && (least < 0 || ssv_clearly_less(promise[k], promise[least]))) least = k;
    }
    return least;
}

// Screens the candidates with short flights; all of them if all are to be listed.
static void screen_candidates(const ssv_search_t* search, const ssv_budget_t* budget, const ssv_quote_t* quote,
                              prospects_t* prospects) {
    const bool all = search->question->list_candidates;
    real_t turns = REAL(0); // what those of the favourite cost
    *prospects = (prospects_t){.num = quote->num_candidates, .favourite = -1};
    for (int k = 0; k < prospects->num; k++) {
        const ssv_candidate_t* candidate = &quote->candidate[k];
        prospects->promise[k] = ssv_screen_flights(search, candidate->contact, candidate->attach_height_m);
    }
    for (int n = 0; n < prospects->num; n++) {
        const int next = least_of(prospects, prospects->screened);
        const ssv_candidate_t* candidate = &quote->candidate[next];
        const real_t* to_beat = prospects->favourite >= 0 ? &prospects->promise[prospects->favourite] : NULL;
        const real_t flights = prospects->promise[next];
        prospects->screened[next] = true;
        // Skip screening when the straight flights alone, plus half of the turning cost of the best candidate so far,
        // already cost as much as that candidate.
        prospects->done[next] =
            !all && to_beat != NULL &&
            (n >= budget->num_screened || flights + real_mul(SSV_TURNS_AT_LEAST, turns) >= *to_beat);
        if (prospects->done[next]) continue;
        prospects->promise[next] = ssv_screen(search, candidate->contact, candidate->attach_height_m, to_beat);
        if (to_beat != NULL && !ssv_clearly_less(prospects->promise[next], *to_beat)) continue;
        prospects->favourite = next;
        turns = prospects->promise[next] - flights;
    }
}

// Screens the candidates and searches the most promising; all of them if all are to be listed.
SSV_OWN_FRAME static void search_candidates(const ssv_search_t* search, ssv_effort_t effort, ssv_quote_t* quote) {
    const ssv_budget_t* budget = &ssv_budgets[effort];
    const bool all = search->question->list_candidates;
    const ssv_price_t* best = &search->best->price;
    prospects_t prospects;
    screen_candidates(search, budget, quote, &prospects);
    for (int n = 0; n < prospects.num; n++) {
        const int next = n == 0 ? prospects.favourite : least_of(&prospects, prospects.done);
        if (next < 0) break;
        const real_t least = prospects.promise[prospects.favourite], promise = prospects.promise[next];
        if (!(all || n < budget->num_searched || ssv_alike(least, promise))) break;
        const bool hopeless = best->outcome == SSV_FEASIBLE && promise >= real_mul(SSV_SEARCH_GAIN, best->cost);
        if (n > 0 && !all && hopeless) break;
        ssv_candidate_t* candidate = &quote->candidate[next];
        const int contact = candidate->contact;
        const real_t height_m = candidate->attach_height_m;
        prospects.done[next] = true;
        // What the last screening kept is that of the favourite.
        if (n > 0 && effort == SSV_EFFORT_QUICK) (void)ssv_screen(search, contact, height_m, NULL);
        improve(candidate, ssv_optimal_search(search, contact, height_m, effort));
    }
}

// Steps along the beam from the best height so far to the better side, shorter where neither gains; each with a quick
// search.
static void search_along_beam(const ssv_search_t* search) {
    const ssv_path_t* best = search->best;
    const real_t length = search->question->problem->scenario.beam.length_m, end = real_mul(REAL(0.5), length);
    real_t step = real_mul(SSV_FIRST_HEIGHT_STEP, length);
    for (int n = 0; n < SSV_NUM_HEIGHT_STEPS && best->price.outcome == SSV_FEASIBLE; n++) {
        const real_t from = best->grasp.height_m;
        for (int side = -1; side <= 1; side += 2) {
            const real_t height_m = real_max(-end, real_min(end, side < 0 ? from - step : from + step));
            if (height_m == from) continue;
            const int contact = best->grasp.contact;
            (void)ssv_screen(search, contact, height_m, NULL);
            (void)ssv_optimal_search(search, contact, height_m, SSV_EFFORT_QUICK);
        }
        if (best->grasp.height_m == from) step = real_mul(REAL(0.5), step);
    }
}

// Effort best: the candidates, and the best height between them.
static void search_closely(const ssv_search_t* search, ssv_quote_t* quote) {
    const ssv_path_t* best = search->best;
    const bool between = search->question->problem->scenario.attach_anywhere && best->price.outcome == SSV_FEASIBLE;
    const int contact = between ? best->grasp.contact : 0;
    const real_t height_m = between ? best->grasp.height_m : REAL(0);
    search_candidates(search, SSV_EFFORT_BEST, quote);
    if (between) (void)ssv_optimal_search(search, contact, height_m, SSV_EFFORT_BEST);
}

_Static_assert(sizeof(ssv_memory_t) <= sizeof(ssv_work_t), "the search fits the memory to work in");
_Static_assert(_Alignof(ssv_memory_t) <= _Alignof(ssv_work_t), "the search may stand where that memory is");

// More effort starts with what less effort does, and the paper's paths follow where these could still be cheaper:
// neither ever costs more.
static void search_optimal(const ssv_question_t* question, ssv_work_t* work, ssv_quote_t* quote, ssv_path_t* best) {
    const ssv_scenario_t* scenario = &question->problem->scenario;
    ssv_memory_t* memory = (ssv_memory_t*)work;
    const ssv_search_t search = {question, memory, best, &quote->num_priced};
    ssv_capability_init(question, &memory->capability);
    search_candidates(&search, SSV_EFFORT_QUICK, quote);
    if (scenario->attach_anywhere) search_along_beam(&search);
    if (scenario->effort == SSV_EFFORT_BEST) search_closely(&search, quote);
}

bool ssv_choose(const ssv_question_t* question, ssv_work_t* work, ssv_quote_t* quote, ssv_path_t* best) {
    SSV_ASSERT(question->method == SSV_METHOD_PAPER || work != NULL);
    memset(quote, 0, sizeof *quote);
    quote->status = SSV_INFEASIBLE;
    quote->scenario_hash = question->problem->scenario_hash;
    best->price.outcome = SSV_TOO_LONG;
    enter_candidates(&question->problem->scenario, quote);
    if (question->method == SSV_METHOD_OPTIMAL) search_optimal(question, work, quote, best);
    search_paper(question, quote, best);
    return best->price.outcome == SSV_FEASIBLE;
}

bool ssv_choose_next(const ssv_question_t* question, ssv_outcome_t outcome, ssv_quote_t* quote, ssv_path_t* path) {
    SSV_ASSERT(question->method == SSV_METHOD_PAPER && outcome != SSV_FEASIBLE);
    int k = cheapest(quote);
    if (k >= 0) quote->candidate[k].outcome = outcome;
    k = cheapest(quote);
    if (k < 0) return false;
    const ssv_candidate_t* candidate = &quote->candidate[k];
    const ssv_price_t nothing = {.outcome = SSV_TOO_LONG};
    ssv_paper_search_t search;
    ssv_paper_search_begin(&search, question, &nothing);
    (void)ssv_paper_search(&search, candidate->contact, candidate->attach_height_m, path);
    quote->num_priced += search.num_priced;
    return true;
}

void ssv_quote_finish_price(const ssv_question_t* question, const ssv_path_t* path, ssv_quote_t* quote) {
    quote->choice = ssv_candidate_of(&path->grasp, &path->price);
    quote->status = SSV_OK;
    quote->cost = quote->choice.cost;
    quote->time_s = quote->choice.time_s;
    quote->impulse_Ns = quote->choice.impulse_Ns;
    quote->lower_bound = ssv_least_price(question);
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

ssv_status_t ssv_quote_finish_status(const ssv_question_t* question, uint32_t overflows, ssv_quote_t* quote) {
    if (real_overflows() == overflows && real_is_finite(quote->cost)) {
        // What motions that did not fit a plan added up is no price.
        if (quote->status != SSV_OK) quote->cost = quote->time_s = quote->impulse_Ns = REAL(0);
        return quote->status;
    }
    memset(quote, 0, sizeof *quote);
    quote->status = SSV_NUMERIC_OVERFLOW;
    quote->scenario_hash = question->problem->scenario_hash;
    return quote->status;
}

ssv_status_t ssv_quote_of(const ssv_question_t* question, ssv_work_t* work, ssv_quote_t* quote) {
    const uint32_t overflows = real_overflows();
    ssv_path_t path;
    if (ssv_choose(question, work, quote, &path)) ssv_quote_finish_price(question, &path, quote);
    return ssv_quote_finish_status(question, overflows, quote);
}

ssv_status_t ssv_quote(const ssv_problem_t* problem, ssv_work_t* work, ssv_quote_t* quote) {
    const ssv_question_t question = ssv_question_of(problem);
    return ssv_quote_of(&question, work, quote);
}

/// The choice among the candidates: which path is flown, and what it costs.
#ifndef SSV_SELECT_H
#define SSV_SELECT_H

#include "planner/motion/path.h"
#include "planner/motion/question.h"
#include "planner/search/paper.h"
#include "planner/search/screen.h"
#include "ssv/planner.h"

/// What is known of the candidates while they are screened and searched.
typedef struct {
    int num;
    real_t promise[SSV_MAX_CANDIDATES]; ///< price of the flights alone at first, then what screening finds
    bool screened[SSV_MAX_CANDIDATES];  ///< or left out
    bool done[SSV_MAX_CANDIDATES];      ///< searched, or left out
    bool searched[SSV_MAX_CANDIDATES];
    int favourite; ///< promises least of those screened; -1 before the first
    real_t turns;  ///< what those of the favourite cost
} ssv_prospects_t;

/// What comes next in a choice.
typedef enum {
    SSV_CHOICE_SCREENS, ///< candidate after candidate
    SSV_CHOICE_SEARCHES,
    SSV_CHOICE_STEPS_ALONG,   ///< along the beam from the best height so far
    SSV_CHOICE_SEARCHES_REST, ///< what has had no quick search
    SSV_CHOICE_SEARCHES_BETWEEN,
    SSV_CHOICE_TRIES_PAPER, ///< the paper's path of candidate after candidate
    SSV_CHOICE_IS_MADE
} ssv_choice_stage_t;

/// A choice among the candidates under way. It is made in steps, so that the caller can do other things in between.
typedef struct {
    ssv_question_t question;
    ssv_path_t best; ///< the cheapest so far, if feasible
    bool overflowed; ///< whether a result did not fit the scalar in any of the steps
    ssv_choice_stage_t stage;
    ssv_effort_t effort; ///< of the searches under way
    bool tries_all;      ///< whether no candidate is left out until there is one that keeps clear
    int detour;          ///< number of the one that is being tried, of those that follow where nothing keeps clear; -1
                         ///< before
    int num_done;        ///< candidates screened, searched or tried, or steps made along the beam, in this stage
    ssv_prospects_t prospects;
    real_t along_from_m, along_step_m; ///< the height that steps start from, and how long they are
    int between_contact;               ///< what the steps along the beam ended at; contact 0 = not asked for
    real_t between_height_m;
    ssv_paper_search_t paper;
    ssv_memory_t memory;
} ssv_choice_t;

/// Begins the choice by the question's method. *quote is emptied but for the candidates that there are; it is complete
/// only when the choice is made and ssv_quote_finish_price has filled in the rest.
void ssv_choice_begin(const ssv_question_t* question, ssv_choice_t* choice, ssv_quote_t* quote);

/// Looks at one more candidate or height. A search with effort best is the longest step: some 25 ms in fixed point on a
/// desktop core, 3 ms in double. @return whether the choice is made; then choice->best is it, if that is feasible.
bool ssv_choice_step(ssv_choice_t* choice, ssv_quote_t* quote);

/// Method paper: replaces choice->best by the path of the next candidate in order of price, after the one chosen turned
/// out not to be possible, for the reason given. @return whether there is one.
bool ssv_choice_next(ssv_choice_t* choice, ssv_outcome_t outcome, ssv_quote_t* quote);

/// Completes the quote with the price of the path that was chosen.
void ssv_quote_finish_price(const ssv_question_t* question, const ssv_path_t* path, ssv_quote_t* quote);

/// Ends every answer. If a result did not fit the scalar on the way, or the price is not finite, all that the quote
/// says is that; no other number of it can be trusted. @return quote->status.
ssv_status_t ssv_quote_finish_status(const ssv_question_t* question, bool overflowed, ssv_quote_t* quote);

/// One more step of a quote, and its end after the last. @return whether that was the last.
bool ssv_choice_quote_step(ssv_choice_t* choice, ssv_quote_t* quote);

#endif

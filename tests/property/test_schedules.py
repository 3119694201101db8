"""The scheduler against two judges of others: what its schedules cost against OR-Tools' constraint solver over the same prices,
and the decompositions of its domain against those that GTPyhop makes of the same tasks. In the long run alone, whose set-up
fetches both (160 MB)."""
import os
import pathlib
import subprocess
import unittest

LONG, BUILD_DIR = os.environ.get("SSV_LONG"), pathlib.Path(os.environ["SSV_BUILD_DIR"])
COUNT = 50

# What both judges read: structures with their rules, and what the scheduler says of them.
READER = """
import sys

def structures():
    found = []
    for line in sys.stdin:
        key, *values = line.split()
        if key == "structure":
            number, slots, beams, touching = map(int, values)
            found.append(dict(number=number, beams=beams, touching=touching, slots=[], ways=[], arcs=[], cost=None))
        elif key == "slot":
            beam, after, touches = map(int, values)
            bits = lambda mask: [k for k in range(64) if mask >> k & 1]
            found[-1]["slots"].append(dict(beam=beam, after=bits(after), touches=bits(touches)))
        elif key == "way":
            found[-1]["ways"].append(tuple(map(int, values)))
        elif key == "arc":
            found[-1]["arcs"].append((*map(int, values[:4]), float(values[4])))
        elif key == "cost":
            found[-1]["cost"] = float(values[0])
    return found

def may_take(structure, beam, slot):
    own = structure["slots"][slot]["beam"]
    return own == beam if own >= 0 else all(s["beam"] != beam for s in structure["slots"])
"""

# The vehicle's way is a circuit over poses, from the start and back to it; each arc is a part. Parts have places in time, by
# which the rules are kept. Prints how many structures there were, how many had no schedule, and the largest difference.
SOLVER = READER + """
from ortools.sat.python import cp_model

SCALE = 1e6  # the solver counts in whole numbers

def least(structure):
    model = cp_model.CpModel()
    num_slots = len(structure["slots"])
    poses = {arc[0] for arc in structure["arcs"]} | {arc[3] for arc in structure["arcs"]}
    back = {pose: model.new_bool_var("") for pose in poses}
    circuit = [(pose, 0, back[pose]) for pose in poses if pose != 0]
    circuit += [(pose, pose, model.new_bool_var("")) for pose in poses if pose != 0]
    time = [model.new_int_var(0, num_slots - 1, "") for _ in range(num_slots)]
    model.add_all_different(time)
    of_slot, of_beam, into, out_of, cost = {}, {}, {}, {}, []
    for start, beam, slot, end, price in structure["arcs"]:
        if not may_take(structure, beam, slot) or start == end or end == 0:
            continue
        taken = model.new_bool_var("")
        circuit.append((start, end, taken))
        of_slot.setdefault(slot, []).append(taken)
        of_beam.setdefault(beam, []).append(taken)
        into.setdefault((end, slot), []).append(taken)
        out_of.setdefault(start, []).append((slot, taken))
        cost.append(round(price * SCALE) * taken)
        if start == 0:
            model.add(time[slot] == 0).only_enforce_if(taken)
    model.add_circuit(circuit)
    for slot in range(num_slots):
        model.add_exactly_one(of_slot.get(slot, []))
    for beam in of_beam.values():
        model.add_at_most_one(beam)
    for (pose, before), came in into.items():
        for slot, taken in out_of.get(pose, []):
            for coming in came:
                model.add(time[slot] == time[before] + 1).only_enforce_if(taken, coming)
    for slot, rules in enumerate(structure["slots"]):
        for before in rules["after"]:
            model.add(time[before] < time[slot])
        if structure["touching"]:
            is_first, stands = model.new_bool_var(""), []
            model.add(time[slot] == 0).only_enforce_if(is_first)
            for other in rules["touches"]:
                earlier = model.new_bool_var("")
                model.add(time[other] < time[slot]).only_enforce_if(earlier)
                stands.append(earlier)
            model.add_bool_or([is_first, *stands])
    model.minimize(sum(cost))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 2
    status = solver.solve(model)
    assert status in (cp_model.OPTIMAL, cp_model.INFEASIBLE), solver.status_name(status)
    return solver.objective_value / SCALE if status == cp_model.OPTIMAL else None

worst, none, sampled = 0, 0, structures()
for structure in sampled:
    judged = least(structure)
    if judged is None or structure["cost"] is None:
        assert judged == structure["cost"], (structure["number"], judged, structure["cost"])
        none += 1
        continue
    worst = max(worst, abs(judged - structure["cost"]) / judged)
print(len(sampled), none, worst)
"""

# Every beam and slot is a method of its own. The last action takes a note of the plan and fails, so that all are tried.
DECOMPOSER = READER + """
import contextlib
import io

with contextlib.redirect_stdout(io.StringIO()):
    import gtpyhop
    gtpyhop.set_recursive_planning("iterative_dfs_backtracking")
    gtpyhop.verbose = 0

def ways(structure):
    found = set()
    gtpyhop.Domain(f"assembly_{structure['number']}")
    slots = structure["slots"]

    def fly_to_beam(state, beam):
        if beam not in state.free or state.held is not None:
            return None
        state.free = state.free - {beam}
        state.held = beam
        return state

    def fly_beam_to_hub(state, beam, slot):
        if state.held != beam or slot in state.built:
            return None
        state.held = None
        state.built = state.built | {slot}
        state.way = (*state.way, beam, slot)
        return state

    def note(state):
        found.add(state.way)
        return None

    def done(state):
        return [("note",)] if len(state.built) == len(slots) else None

    def assemble_with(beam, slot):
        def method(state):
            rules = slots[slot]
            allowed = (slot not in state.built and beam in state.free and may_take(structure, beam, slot) and
                       state.built.issuperset(rules["after"]) and
                       (not structure["touching"] or not state.built or bool(state.built & set(rules["touches"]))))
            return [("assemble_part", beam, slot), ("assemble_structure",)] if allowed else None
        method.__name__ = f"with_{beam}_{slot}"
        return method

    def assemble_part(state, beam, slot):
        return [("fly_to_beam", beam), ("fly_beam_to_hub", beam, slot)]

    gtpyhop.declare_actions(fly_to_beam, fly_beam_to_hub, note)
    gtpyhop.declare_task_methods("assemble_part", assemble_part)
    gtpyhop.declare_task_methods("assemble_structure", done, *(
        assemble_with(beam, slot) for beam in range(structure["beams"]) for slot in range(len(slots))))
    state = gtpyhop.State("start")
    state.free, state.held, state.built, state.way = frozenset(range(structure["beams"])), None, frozenset(), ()
    gtpyhop.find_plan(state, [("assemble_structure",)])
    return found

num_ways, sampled = 0, structures()
for structure in sampled:
    with contextlib.redirect_stdout(io.StringIO()):
        judged = ways(structure)
    assert len(structure["ways"]) == len(set(structure["ways"])), structure["number"]
    assert judged == set(structure["ways"]), (structure["number"], judged ^ set(structure["ways"]))
    num_ways += len(judged)
print(len(sampled), sum(not s["ways"] for s in sampled), num_ways)
"""


def judged(script, kind):
    facts = subprocess.run([os.environ["SSV_SCHEDULE_FACTS"], kind, "0", str(COUNT)], check=True, capture_output=True).stdout
    done = subprocess.run([BUILD_DIR / "schedules/bin/python", "-c", script], input=facts, capture_output=True)
    if done.returncode != 0:
        raise AssertionError(done.stderr.decode())
    return done.stdout.split()


@unittest.skipUnless(LONG, "OR-Tools and GTPyhop are fetched for the long run alone")
class Schedules(unittest.TestCase):
    def test_schedules_cost_what_a_constraint_solver_finds(self):
        count, none, worst = judged(SOLVER, "graph")
        print(f"{int(count)} structures of 4 to 6 slots, {int(none)} of them without a schedule: the solver's optimum and ours "
              f"differ by {float(worst):.1e} at most")
        self.assertEqual(int(count), COUNT)
        self.assertLess(int(none), COUNT / 5)
        self.assertLess(float(worst), 1e-9)  # the solver's prices are rounded to a millionth

    def test_decompositions_are_those_of_gtpyhop(self):
        count, none, ways = judged(DECOMPOSER, "decompositions")
        print(f"{int(count)} structures of 2 to 4 slots, {int(none)} of them without a way: {int(ways)} decompositions in all")
        self.assertEqual(int(count), COUNT)
        self.assertGreater(int(ways), 1000)


if __name__ == "__main__":
    unittest.main()

"""The planner in float and in fixed point against the planner in double: the shipped scenarios, and seeded random tasks.

The same doubles describe a task to all three; each rounds them to its own scalar. SSV_SEED=N draws other tasks. By themselves,
`test_scalars.py METHOD TASK...` (environment as ctest sets it) shows what the three make of single tasks.

Every plan is held to double's price and its end, and one that makes the same choice as double to its duration. A plan that makes
another choice, of contact, height, ring angle, rolls, travel attitudes or pivots, is held to what double makes of its very motion:
to that price and that duration, and to a tie: double's prices of both motions agree as closely as prices must.
A float plan of another choice is right where its price ties and double confirms the price of its motion; how far its duration
lies from that of double's choice is printed. With SSV_LONG=1 fixed point is held to that duration, too.
"""
import math
import os
import subprocess
import sys
import unittest

SEED = int(os.environ.get("SSV_SEED", "20261203"))
LONG = bool(os.environ.get("SSV_LONG"))
COUNT = (10000 if LONG else 400) + 10  # the shipped scenarios come first, and are no more than ten
METHODS = {"optimal": 0, "paper": 1}
STATUS = {0: "ok", 1: "infeasible", 2: "numeric overflow"}

COST = {"float": 1e-3, "fixed": 1e-4}  # |dJ| / J
TIME_S, TIME = 1e-3, 5e-4  # whichever is more
PLACE_M, ANGLE_RAD = 1e-4, math.radians(0.01)
# Two plans make the same choice if the vehicle is at the same place and attitude, as closely as the end must be, wherever it stops.
SAME_CHOICE = {"float": 0.98, "fixed": 1}  # of the plans of method optimal, at least


def turned(q, v):
    """v by the unit quaternion q, scalar first."""
    w, u = q[0], q[1:]
    cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    t = [2 * c for c in cross(u, v)]
    return [a + w * b + c for a, b, c in zip(v, t, cross(u, t))]


def angle_between(p, q):
    """Of two attitudes [rad]."""
    apart = min(math.dist(p, q), math.dist(p, [-c for c in q]))
    return 4 * math.asin(min(1, apart / 2))


def along(p, length, direction):
    return [a + length * b for a, b in zip(p, direction)]


def between(u, v):
    """The angle between a unit vector and the opposite of another [rad]."""
    return 2 * math.asin(min(1, math.dist(u, [-c for c in v]) / 2))


class Price:
    """What a motion costs: task, J, time."""

    def __init__(self, line):
        task, cost, time_s = line.split()
        self.task, self.cost, self.time_s = int(task), float(cost), float(time_s)

    def cost_error(self, double):
        return abs(self.cost - double.cost) / double.cost

    def time_error(self, double):
        """As a multiple of what is allowed."""
        return abs(self.time_s - double.time_s) / max(TIME_S, TIME * double.time_s)


class Plan(Price):
    """One line of plan_numbers."""

    def __init__(self, line):
        self.line = line
        self.task, self.status, self.overflowed, *numbers = line.split()
        self.task, self.status, self.overflowed = int(self.task), STATUS[int(self.status)], self.overflowed == "1"
        if self.status != "ok":
            return
        numbers = list(map(float, numbers))
        self.cost, self.time_s, self.impulse_Ns, self.contact, self.height_m, self.ring_rad, half_length_m = numbers[:7]
        standoff_m, port, axis = numbers[7], numbers[8:11], numbers[11:14]
        self.vehicle = numbers[14:17], numbers[17:21]
        self.beam = numbers[21:24], numbers[24:28]
        self.off_legs_m, self.stops = numbers[28], [(numbers[k:k + 3], numbers[k + 3:k + 7]) for k in range(36, len(numbers), 16)]
        # Where the beam must be, and the vehicle on it: beam z along the port's axis, vehicle x towards the beam.
        outward = turned(self.beam[1], [0, 0, -1 if self.contact == 1 else 1])
        side = turned(self.beam[1], [math.cos(self.ring_rad), math.sin(self.ring_rad), 0])
        end = along(self.beam[0], half_length_m, outward)
        mate = along(along(self.beam[0], self.height_m, turned(self.beam[1], [0, 0, 1])), standoff_m, side)
        self.off_place_m = max(math.dist(end, port), math.dist(mate, self.vehicle[0]))
        self.off_angle_rad = max(between(outward, axis), between(side, turned(self.vehicle[1], [1, 0, 0])))

    def chooses_like(self, other):
        """Whether both are the same motion, but for rounding."""
        return (self.contact == other.contact and len(self.stops) == len(other.stops)
                and all(math.dist(p, p_other) <= PLACE_M and angle_between(q, q_other) <= ANGLE_RAD
                        for (p, q), (p_other, q_other) in zip(self.stops, other.stops)))

    def place_error_m(self, double):
        return max(math.dist(self.vehicle[0], double.vehicle[0]), math.dist(self.beam[0], double.beam[0]))

    def angle_error_rad(self, double):
        return max(angle_between(self.vehicle[1], double.vehicle[1]), angle_between(self.beam[1], double.beam[1]))

    def __str__(self):
        if self.status != "ok":
            return self.status
        stops = [[round(c, 6) for c in p] for p, _ in self.stops]
        return (f"J {self.cost:.9g}, {self.time_s:.6f} s, {self.impulse_Ns:.6f} N s, contact {self.contact:.0f}, "
                f"height {self.height_m:+.6f} m, ring {self.ring_rad:+.6f} rad, stops {stops}")


def plans(scalar, method, first=0, count=COUNT):
    """The tasks from first up to count, planned on all cores."""
    cores = os.cpu_count() or 1
    command = [os.environ[f"SSV_NUMBERS_{scalar}"], str(SEED), str(METHODS[method])]
    workers = [subprocess.Popen([*command, str(first + k), str(cores), str(count)], stdout=subprocess.PIPE, text=True)
               for k in range(cores)]
    outputs = [worker.communicate()[0] for worker in workers]
    if any(worker.returncode for worker in workers):
        raise AssertionError(f"{command} ended with {[worker.returncode for worker in workers]}")
    return sorted(map(Plan, "".join(outputs).splitlines()), key=lambda plan: plan.task)


def price_in_double(found, method):
    """Double's prices of the motions of plans."""
    command = [os.environ["SSV_NUMBERS_double"], str(SEED), str(METHODS[method]), "-"]
    lines = subprocess.run(command, input="\n".join(plan.line for plan in found), stdout=subprocess.PIPE, text=True, check=True)
    return [Price(line) for line in lines.stdout.splitlines()]


def figures(values):
    """Median, 99th percentile and largest."""
    values = sorted(values)
    pick = lambda share: values[min(len(values) - 1, int(share * len(values)))]
    return f"{pick(0.5):.1e} / {pick(0.99):.1e} / {values[-1]:.1e}"


class Scalars(unittest.TestCase):
    def assert_none(self, what, tasks):
        with self.subTest(what):
            self.assertEqual(len(tasks), 0, f"tasks {[plan.task for plan, _ in tasks[:20]]}, seed {SEED}")

    def compare(self, scalar, method, double):
        """Holds what is to hold of every plan. @return those that make the same choice as in double, with these."""
        found = plans(scalar, method)
        pairs = [(plan, d) for plan, d in zip(found, double) if plan.status == d.status == "ok"]
        alike = [(plan, d) for plan, d in pairs if plan.chooses_like(d)]
        others = [(plan, d) for plan, d in pairs if not plan.chooses_like(d)]
        priced = price_in_double([plan for plan, _ in others], method)
        self.assertEqual([price.task for price in priced], [plan.task for plan, _ in others])
        own = [(plan, price) for (plan, _), price in zip(others, priced)]
        ties = [(price, d) for (_, d), price in zip(others, priced)]
        print(f"{method}, {scalar}: {len(pairs)} plans, {len(alike)} with the same choice; median / p99 / most of |dJ|/J "
              f"{figures(p.cost_error(d) for p, d in pairs)}, end off by {figures(p.off_place_m for p, _ in pairs)} m, "
              f"{figures(p.off_angle_rad for p, _ in pairs)} rad, samples {figures(p.off_legs_m for p, _ in pairs)} m, "
              f"time {figures(p.time_error(d) for p, d in alike)} of what is allowed")
        if others:
            print(f"{method}, {scalar}: {len(others)} with another choice, that ties within {figures(p.cost_error(d) for p, d in ties)}; "
                  f"|dJ|/J of these by double {figures(p.cost_error(d) for p, d in own)}, "
                  f"time {figures(p.time_error(d) for p, d in own)} of what is allowed; {sum(p.time_error(d) > 1 for p, d in others)} "
                  f"take another time than double's choice, "
                  f"{sum(p.contact != d.contact or abs(p.height_m - d.height_m) > PLACE_M for p, d in others)} have another grasp")
        self.assert_none("silent overflow", [(p, d) for p, d in zip(found, double) if p.overflowed and p.status != "numeric overflow"])
        self.assert_none("other status", [(p, d) for p, d in zip(found, double) if p.status != d.status])
        self.assert_none("price", [(p, d) for p, d in pairs + own if p.cost_error(d) > COST[scalar]])
        self.assert_none("duration", [(p, d) for p, d in alike + own if p.time_error(d) > 1])
        self.assert_none("choice that does not tie", [(p, d) for p, d in ties if p.cost_error(d) > COST[scalar]])
        if LONG and scalar == "fixed":
            self.assert_none("duration of another choice", [(p, d) for p, d in others if p.time_error(d) > 1])
        self.assert_none("end", [(p, d) for p, d in pairs if p.off_place_m > PLACE_M or p.off_angle_rad > ANGLE_RAD])
        self.assert_none("samples", [(p, d) for p, d in pairs if p.off_legs_m > PLACE_M])
        return alike

    def test_the_paper_s_method_plans_the_same(self):
        double = plans("double", "paper")
        for scalar in COST:
            with self.subTest(scalar):
                alike = self.compare(scalar, "paper", double)
                self.assert_none("pose", [(p, d) for p, d in alike if p.place_error_m(d) > PLACE_M or p.angle_error_rad(d) > ANGLE_RAD])
                self.assertGreater(len(alike), 0.99 * COUNT)

    def test_the_optimal_method_plans_at_the_same_price(self):
        double = plans("double", "optimal")
        for scalar in COST:
            with self.subTest(scalar):
                alike = self.compare(scalar, "optimal", double)
                self.assertGreaterEqual(len(alike), SAME_CHOICE[scalar] * COUNT)


if __name__ == "__main__":
    if len(sys.argv) > 1 and sys.argv[1] in METHODS:
        for task in map(int, sys.argv[2:]):
            for scalar in ("double", *COST):
                print(task, f"{scalar:6}", *plans(scalar, sys.argv[1], task, task + 1))
    else:
        unittest.main()

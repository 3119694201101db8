"""ssv-plannerd from the outside: a real process, real LCM over UDP multicast, friendly and hostile senders.

The junk is drawn from a seed that is printed; SSV_SEED=N draws the same again.
"""

import copy
import math
import os
import random
import signal
import socket
import struct
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

import lcm

import ssv

DAEMON = Path(os.environ["SSV_BIN_DIR"]) / "ssv-plannerd"
SEED = int(os.environ.get("SSV_SEED", "20250801"))

DEADLINE_S = 60  # generous: reached only when something is broken
RESEND_S = 5  # UDP may lose a datagram on a busy machine; askers ask again
SCENARIO, PLAN, STATUS = "SSV_SCENARIO", "SSV_PLAN", "SSV_PLANNER_STATUS"
BATCH, QUOTES = "SSV_SCENARIO_BATCH", "SSV_QUOTE_BATCH"
OK, INFEASIBLE, INVALID = ssv.quote_t.STATUS_OK, ssv.quote_t.STATUS_INFEASIBLE, ssv.quote_t.STATUS_INVALID
NEWEST_US = 2**63 - 1  # no epoch is newer, so junk that happens to be a scenario cannot make this one stale

GROUP = "239.255.76.67"
SHORT_MAGIC, FRAGMENT_MAGIC = 0x4C433032, 0x4C433033  # "LC02": a whole message, "LC03": a piece of one


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.bind(("", 0))
        return s.getsockname()[1]


def question(request_id, epoch_us=0, asker_id=0):
    """The paper's case study with a real tube for a beam."""
    q = ssv.scenario_t()
    q.asker.asker_id, q.asker.request_id, q.asker.epoch_us = asker_id, request_id, epoch_us
    body = q.vehicle.body
    body.mass_kg, body.inertia_kg_m2, body.drag_lin_kg_s, body.drag_quad_ang_Nm_s2 = 76.2, [2.7] * 3, 413.685, 2.2
    r = q.vehicle.radius_m = 0.3025
    q.vehicle.force_max_N = 6
    x, y, z = [1, 0, 0], [0, 1, 0], [0, 0, 1]
    for thruster, place, push in zip(q.vehicle.thruster, (z, z, x, x, y, y), (x, x, y, y, z, z)):
        thruster.p_ST_m, thruster.n_T_S = [r * c for c in place], push
    for thruster in q.vehicle.thruster[1::2]:
        thruster.p_ST_m, thruster.n_T_S = [-c for c in thruster.p_ST_m], [-c for c in thruster.n_T_S]
    q.beam.body.mass_kg, q.beam.body.inertia_kg_m2 = 11.3636, [8.8164, 8.8164, 0.0376]
    q.beam.radius_m, q.beam.length_m, q.beam.drag_strip_kg_m2 = 0.0606, 3.048, 66.66
    q.X_IS.q = [0, 0, 0, 1]
    q.X_IB.p_m, q.X_IB.q = [5, 0, 0], [math.sqrt(0.5), 0, math.sqrt(0.5), 0]
    q.port.p_IP_m, q.port.axis_I = [6.524, 5, 0], [0, -1, 0]
    q.contact, q.standoff_m, q.weight_time_per_s, q.weight_impulse_per_Ns = 1, 0.3025, 1, 1
    q.options.ring_angle_given, q.options.ring_angle_rad = True, -math.pi / 2
    return q


def message(q, scene=None):
    """What goes over LCM to ask q: a batch or a task as it is, a scenario with what stands around."""
    if not isinstance(q, ssv.scenario_t):
        return q
    task = ssv.task_t()
    task.scenario, task.scene = q, scene or ssv.scene_t()
    return task


def batch(request_id, scenarios, epoch_us=0, asker_id=0):
    b = ssv.scenario_batch_t()
    b.asker.asker_id, b.asker.request_id, b.asker.epoch_us = asker_id, request_id, epoch_us
    b.num_scenarios, b.scenarios = len(scenarios), scenarios
    return b


def changed(q, path, value):
    """A copy of q with one field changed: "vehicle.thruster.2.n_T_S.0"."""
    q = copy.deepcopy(q)
    *way, last = path.split(".")
    at = q
    for name in way:
        at = at[int(name)] if name.isdigit() else getattr(at, name)
    if last.isdigit():
        at[int(last)] = value
    else:
        setattr(at, last, value)
    return q


class Daemon:
    """A running ssv-plannerd on a multicast port of its own, and what it said."""

    def __init__(self, *options):
        self.port = free_port()
        self.url = f"udpm://{GROUP}:{self.port}?ttl=0"
        self.answers = {}  # request id -> encoded plans, in order of arrival
        self.quotes = {}  # likewise of batches
        self.statuses = []
        self.lcm = lcm.LCM(self.url)
        for channel, handler in ((PLAN, self._on_plan), (QUOTES, self._on_quotes), (STATUS, self._on_status)):
            self.lcm.subscribe(channel, handler).set_queue_capacity(20000)
        self.log = tempfile.TemporaryFile("w+")
        self.process = subprocess.Popen([DAEMON, "--lcm-url", self.url, *options], stdin=subprocess.DEVNULL,
                                        stdout=subprocess.DEVNULL, stderr=self.log)
        try:
            self.wait_until(lambda: self.statuses)
        except BaseException:
            self.close()
            raise

    def close(self):
        """Ends it as a supervisor would. @return its exit code, None if it had to be killed."""
        self.process.terminate()
        try:
            code = self.process.wait(DEADLINE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            code = None
        self.log.close()
        return code

    def _on_plan(self, _channel, data):
        self.answers.setdefault(struct.unpack_from(">q", data, 16)[0], []).append(data)

    def _on_quotes(self, _channel, data):
        self.quotes.setdefault(struct.unpack_from(">q", data, 16)[0], []).append(data)

    def _on_status(self, _channel, data):
        self.statuses.append(ssv.planner_status_t.decode(data))

    def said(self):
        self.log.seek(0)
        return self.log.read()

    def wait_until(self, condition, seconds=DEADLINE_S):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end or self.process.poll() is not None:
                raise AssertionError(f"ssv-plannerd (exit code {self.process.poll()}) did not do it. Its log ends:\n"
                                     + self.said()[-3000:])
            self.lcm.handle_timeout(100)

    def next_status(self):
        """A status that was made after this call, or that shows all that was before it."""
        seen = len(self.statuses)
        self.wait_until(lambda: len(self.statuses) >= seen + 2)
        return self.statuses[-1]

    def send(self, q, scene=None):
        self.lcm.publish(BATCH if isinstance(q, ssv.scenario_batch_t) else SCENARIO, message(q, scene).encode())

    def answers_to(self, q):
        asker = q.scenario.asker if isinstance(q, ssv.task_t) else q.asker
        return (self.quotes if isinstance(q, ssv.scenario_batch_t) else self.answers).get(asker.request_id, [])

    def ask_all(self, questions, scene=None):
        """Sends them in one burst, and those without an answer again; a scene is for every scenario that is none of a
        batch. @return the answers, in order."""
        before = [len(self.answers_to(q)) for q in questions]
        end = time.monotonic() + DEADLINE_S
        missing = list(zip(questions, before))
        while missing:
            if time.monotonic() > end or self.process.poll() is not None:
                raise AssertionError(f"no answer to {len(missing)} of {len(questions)} questions (exit code "
                                     f"{self.process.poll()}). The log ends:\n" + self.said()[-3000:])
            for q, _ in missing:
                self.send(q, scene)
            resend = time.monotonic() + RESEND_S
            while time.monotonic() < resend and self.process.poll() is None and missing:
                self.lcm.handle_timeout(100)
                missing = [(q, count) for q, count in missing if len(self.answers_to(q)) == count]
        return [(ssv.quote_batch_t if isinstance(q, ssv.scenario_batch_t) else ssv.plan_t).decode(self.answers_to(q)[-1])
                for q in questions]

    def ask(self, q, scene=None):
        return self.ask_all([q], scene)[0]

    def raw_sender(self):
        s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        s.connect((GROUP, self.port))
        return s


class DaemonTest(unittest.TestCase):
    def start(self, *options):
        daemon = Daemon(*options)
        self.addCleanup(lambda: self.assertEqual(daemon.close(), 0))
        return daemon

    def assert_alive(self, daemon):
        """100 of 100 good questions are answered with the same good plan."""
        plans = daemon.ask_all([question(10**15 + i, NEWEST_US) for i in range(100)])
        self.assertEqual([p.quote.reason for p in plans], [""] * 100)
        self.assertEqual(len({p.plan_hash for p in plans}), 1)


class Answers(DaemonTest):
    def test_a_good_scenario_gets_a_complete_plan_of_less_than_60_kB(self):
        daemon = self.start()
        plan = daemon.ask(question(42, 7))
        quote = plan.quote
        self.assertEqual((quote.status, quote.reason, plan.answer.asker.request_id, plan.answer.asker.epoch_us), (OK, "", 42, 7))
        self.assertAlmostEqual(quote.cost, quote.time_s + quote.impulse_Ns, delta=1e-9 * quote.cost)
        self.assertTrue(0 < quote.cost_lower_bound <= quote.cost)
        self.assertAlmostEqual(sum(leg.duration_s for leg in plan.legs), quote.time_s, delta=1e-9 * quote.time_s)
        self.assertAlmostEqual(sum(leg.impulse_Ns for leg in plan.legs), quote.impulse_Ns, delta=1e-9 * quote.impulse_Ns)
        last = plan.segments[-1]
        self.assertAlmostEqual(last.t_s + last.duration_s, quote.time_s, delta=1e-6)
        self.assertLessEqual(max(abs(u) for s in plan.segments for u in (*s.u_start_N, *s.u_end_N)), 6 * (1 + 1e-9))
        self.assertEqual([e.kind for e in plan.events], [ssv.event_t.KIND_MATE, ssv.event_t.KIND_DOCK])
        self.assertEqual((quote.num_candidates, quote.num_front, quote.choice.contact), (0, 0, 1))
        self.assertNotIn(0, (quote.scenario_hash, plan.plan_hash))
        self.assertLess(len(daemon.answers[42][0]), 60000)
        print(f"a plan of {plan.num_segments} segments takes {len(daemon.answers[42][0])} bytes", flush=True)

    def test_a_repeated_id_gets_the_same_bytes_and_no_second_planning(self):
        daemon = self.start()
        daemon.ask(question(1, 50))
        daemon.ask(question(2, 60))
        daemon.ask(question(1, 50))  # its epoch is older than 60 by now
        daemon.ask(question(1, 99))  # what is asked decides, not when
        self.assertGreaterEqual(len(daemon.answers[1]), 3)
        self.assertEqual(len(set(daemon.answers[1])), 1)
        self.assertEqual(daemon.ask(question(3, 60)).quote.status, OK)  # 99 came with a repeated question and did not count
        status = daemon.next_status()
        self.assertEqual((status.accepted, status.repeated), (3, status.received - 3))

    def test_an_invalid_scenario_is_also_answered_from_the_store_when_repeated(self):
        daemon = self.start()
        bad = changed(question(1), "contact", 77)
        daemon.ask(bad)
        daemon.ask(bad)
        self.assertEqual(len(set(daemon.answers[1])), 1)
        self.assertEqual(daemon.next_status().rejected_range, 1)

    def test_the_last_256_answers_are_stored_and_older_ones_are_planned_anew(self):
        daemon = self.start()
        first = daemon.ask(question(1))
        bad = changed(question(0), "contact", 77)
        daemon.ask_all([changed(bad, "asker.request_id", i) for i in range(2, 257)])
        self.assertEqual(daemon.ask(question(1)).plan_hash, first.plan_hash)
        self.assertEqual(daemon.next_status().accepted, 1)
        daemon.ask(changed(bad, "asker.request_id", 257))
        self.assertEqual(daemon.ask(question(1)).plan_hash, first.plan_hash)
        self.assertEqual(daemon.next_status().accepted, 2)

    def test_every_id_of_a_burst_is_answered_exactly_once(self):
        daemon = self.start()
        daemon.ask_all([question(i) for i in range(1, 101)])
        status = daemon.next_status()
        self.assertEqual(status.accepted, 100)
        # A busy machine may lose part of the burst, of the answers too; then ask_all asked again and the store answered.
        self.assertLessEqual(sum(len(a) for a in daemon.answers.values()), 100 + status.repeated)
        self.assertTrue(all(len(set(a)) == 1 for a in daemon.answers.values()))

    def test_any_64_bit_request_id_is_an_id(self):
        daemon = self.start()
        for request_id in (0, -1, 2**63 - 1, -(2**63)):
            self.assertEqual(daemon.ask(question(request_id)).answer.asker.request_id, request_id)

    def test_a_task_that_no_candidate_can_do_is_infeasible_with_a_reason_for_each(self):
        plan = self.start().ask(changed(question(1), "X_IS.p_m", [-900, 0, 0]))
        self.assertEqual((plan.quote.status, plan.num_legs, plan.num_segments, plan.num_events, plan.plan_hash),
                         (INFEASIBLE, 0, 0, 0, 0))
        self.assertEqual(plan.quote.num_candidates, 3)
        for candidate in plan.quote.candidates:
            self.assertTrue(candidate.reason)
            self.assertIn(f"contact 1, height {candidate.attach_height_m:g} m: {candidate.reason}", plan.quote.reason)

    def test_quaternions_within_a_thousandth_of_unit_length_are_normalised(self):
        daemon = self.start()
        exact = daemon.ask(question(1))
        for request_id, scale in ((2, 1.0009), (3, 0.9991)):
            q = question(request_id)
            q.X_IS.q, q.X_IB.q = ([scale * c for c in pose.q] for pose in (q.X_IS, q.X_IB))
            plan = daemon.ask(q)
            self.assertEqual(plan.quote.status, OK)
            self.assertAlmostEqual(plan.quote.cost, exact.quote.cost, delta=1e-9 * exact.quote.cost)
            self.assertAlmostEqual(math.hypot(*plan.legs[0].X_IS_start.q), 1, delta=1e-12)

    def test_options_of_zero_are_method_optimal_with_effort_quick_and_the_others_are_taken_too(self):
        daemon = self.start()
        choices = {"paper": ssv.options_t.METHOD_PAPER, "optimal": ssv.options_t.METHOD_OPTIMAL}
        efforts = {"quick": ssv.options_t.EFFORT_QUICK, "best": ssv.options_t.EFFORT_BEST}
        self.assertEqual((choices["optimal"], efforts["quick"]), (0, 0))
        cost, hashes = {}, set()
        for method in choices:
            for effort in efforts:
                q = changed(question(len(hashes) + 1), "options.method", choices[method])
                plan = daemon.ask(changed(q, "options.effort", efforts[effort]))
                self.assertEqual(plan.quote.status, OK)
                cost[method, effort] = plan.quote.cost
                hashes.add(plan.quote.scenario_hash)
                ramps = {leg.ramp for leg in plan.legs}
                self.assertEqual(ramps == {ssv.leg_t.RAMP_OPTIMAL}, method == "optimal", ramps)
        self.assertEqual(len(hashes), 4)
        self.assertEqual(cost["paper", "quick"], cost["paper", "best"])
        self.assertLess(cost["optimal", "quick"], cost["paper", "quick"])
        self.assertLess(cost["optimal", "best"], cost["paper", "quick"])

    def test_a_flag_is_true_unless_its_byte_is_zero(self):
        flags = (0, 1, 2, 127, -1, -128)
        plans = self.start().ask_all([changed(question(i), "options.ring_angle_given", flags[i]) for i in range(len(flags))])
        self.assertEqual([p.quote.status for p in plans], [OK] * len(flags))
        self.assertEqual([p.quote.scenario_hash == plans[1].quote.scenario_hash for p in plans], [False] + [True] * 5)


class Epochs(DaemonTest):
    def test_an_older_epoch_is_refused_with_both_values(self):
        daemon = self.start()
        self.assertEqual(daemon.ask(question(1, 1000)).quote.status, OK)
        stale = daemon.ask(question(2, 999))
        self.assertEqual((stale.quote.status, stale.num_segments), (INVALID, 0))
        for word in ("epoch_us", "999", "1000"):
            self.assertIn(word, stale.quote.reason)
        self.assertEqual(daemon.ask(question(3, 1000)).quote.status, OK)
        self.assertEqual(daemon.next_status().rejected_stale_epoch, 1)

    def test_an_invalid_scenario_does_not_advance_the_epoch(self):
        daemon = self.start()
        self.assertEqual(daemon.ask(question(1, 10)).quote.status, OK)
        self.assertEqual(daemon.ask(changed(question(2, NEWEST_US), "standoff_m", -1)).quote.status, INVALID)
        self.assertEqual(daemon.ask(question(3, 10)).quote.status, OK)

    def test_an_infeasible_scenario_does_advance_the_epoch(self):
        daemon = self.start()
        self.assertEqual(daemon.ask(changed(question(1, 20), "X_IS.p_m", [-900, 0, 0])).quote.status, INFEASIBLE)
        self.assertIn("epoch_us", daemon.ask(question(2, 19)).quote.reason)

    def test_of_a_burst_the_newest_is_planned_and_what_follows_it_with_an_older_epoch_is_not(self):
        daemon = self.start()
        newest, older, same = daemon.ask_all([question(1, 3), question(2, 2), question(3, 3)])
        self.assertEqual((newest.quote.status, older.quote.status, same.quote.status), (OK, INVALID, OK))

    def test_a_negative_epoch_is_named(self):
        self.assertIn("epoch_us: -1 ", self.start().ask(question(1, -1)).quote.reason)


NAN, INF = float("nan"), float("inf")
INVALID_FIELDS = [  # what to change, to what, the reason's beginning, the counter
    ("vehicle.body.mass_kg", 0.0, "vehicle.body.mass_kg: 0 is outside its range [0.01, 10000]", "range"),
    ("vehicle.body.mass_kg", -76.2, "vehicle.body.mass_kg: -76.2 is outside", "range"),
    ("vehicle.body.mass_kg", NAN, "vehicle.body.mass_kg: nan is not a finite number", "not_finite"),
    ("vehicle.body.mass_kg", -NAN, "vehicle.body.mass_kg: nan is not a finite number", "not_finite"),
    ("vehicle.body.inertia_kg_m2.1", 0.0, "vehicle.body.inertia_kg_m2: 0 is outside", "range"),
    ("vehicle.body.inertia_kg_m2.2", INF, "vehicle.body.inertia_kg_m2: inf is not a finite number", "not_finite"),
    ("vehicle.body.inertia_kg_m2", [0.1, 0.1, 8.8], "vehicle.body.inertia_kg_m2: 8.8 is more than the other two", "range"),
    ("vehicle.body.added_mass_kg.0", -1.0, "vehicle.body.added_mass_kg: -1 is outside", "range"),
    ("vehicle.body.drag_lin_kg_s", -1e-9, "vehicle.body.drag_lin_kg_s: -1e-09 is outside", "range"),
    ("vehicle.body.drag_quad_kg_m", -INF, "vehicle.body.drag_quad_kg_m: -inf is not a finite number", "not_finite"),
    ("vehicle.body.drag_lin_ang_Nm_s", 1e6, "vehicle.body.drag_lin_ang_Nm_s: 1000000 is outside", "range"),
    ("vehicle.body.drag_quad_ang_Nm_s2", -2.2, "vehicle.body.drag_quad_ang_Nm_s2: -2.2 is outside", "range"),
    ("vehicle.radius_m", 0.0, "vehicle.radius_m: 0 is outside", "range"),
    ("vehicle.force_max_N", 0.0, "vehicle.force_max_N: 0 is outside", "range"),
    ("vehicle.thruster.5.p_ST_m.2", 11.0, "vehicle.thruster[5].p_ST_m: 11 is outside its range [-10, 10]", "range"),
    ("vehicle.thruster.0.p_ST_m.0", NAN, "vehicle.thruster[0].p_ST_m: nan is not", "not_finite"),
    ("vehicle.thruster.2.n_T_S", [0, 0.5, 0], "vehicle.thruster[2].n_T_S: length 0.5 is not 1 within 0.001", "not_unit"),
    ("vehicle.thruster.3.n_T_S", [0, 0, 0], "vehicle.thruster[3].n_T_S: length 0 is not 1", "not_unit"),
    ("vehicle.thruster.1.n_T_S.0", INF, "vehicle.thruster[1].n_T_S: inf is not a finite number", "not_finite"),
    ("vehicle.thruster.0.n_T_S", [0, 0, 1], "vehicle.thruster: ", "singular"),
    ("beam.body.mass_kg", 0.0, "beam.body.mass_kg: 0 is outside", "range"),
    ("beam.body.inertia_kg_m2.0", -8.8, "beam.body.inertia_kg_m2: -8.8 is outside", "range"),
    ("beam.body.added_mass_kg.2", NAN, "beam.body.added_mass_kg: nan is not", "not_finite"),
    ("beam.body.drag_lin_kg_s", -1.0, "beam.body.drag_lin_kg_s: -1 is outside", "range"),
    ("beam.body.drag_quad_kg_m", -1.0, "beam.body.drag_quad_kg_m: -1 is outside", "range"),
    ("beam.body.drag_lin_ang_Nm_s", -1.0, "beam.body.drag_lin_ang_Nm_s: -1 is outside", "range"),
    ("beam.body.drag_quad_ang_Nm_s2", NAN, "beam.body.drag_quad_ang_Nm_s2: nan is not", "not_finite"),
    ("beam.radius_m", -0.06, "beam.radius_m: -0.06 is outside", "range"),
    ("beam.length_m", 0.0, "beam.length_m: 0 is outside", "range"),
    ("beam.drag_strip_kg_m2", -66.66, "beam.drag_strip_kg_m2: -66.66 is outside", "range"),
    ("X_IS.p_m.0", 1001.0, "X_IS.p_m: 1001 is outside its range [-1000, 1000]", "range"),
    ("X_IS.p_m.2", NAN, "X_IS.p_m: nan is not", "not_finite"),
    ("X_IS.q", [0, 0, 0, 0], "X_IS.q: length 0 is not 1 within 0.001", "not_unit"),
    ("X_IS.q", [0, 0, 0, 1.0011], "X_IS.q: length 1.0011 is not 1", "not_unit"),
    ("X_IS.q.1", NAN, "X_IS.q: nan is not", "not_finite"),
    ("X_IB.p_m.1", INF, "X_IB.p_m: inf is not", "not_finite"),
    ("X_IB.q", [0, 0, 0, 0], "X_IB.q: length 0 is not 1", "not_unit"),
    ("X_IB.q", [0, 0.9989, 0, 0], "X_IB.q: length 0.9989 is not 1", "not_unit"),
    ("port.p_IP_m.2", -1000.5, "port.p_IP_m: -1000.5 is outside", "range"),
    ("port.axis_I", [0, 0, 0], "port.axis_I: length 0 is not 1", "not_unit"),
    ("port.axis_I.0", NAN, "port.axis_I: nan is not", "not_finite"),
    ("contact", 3, "contact: 3 is outside its range [0, 2]", "range"),
    ("contact", -128, "contact: -128 is outside", "range"),
    ("standoff_m", 0.0, "standoff_m: 0 is outside", "range"),
    ("standoff_m", 0.3, "standoff_m: 0.3 is inside hull and beam, whose radii make 0.3631", "range"),
    ("standoff_m", NAN, "standoff_m: nan is not", "not_finite"),
    ("weight_time_per_s", -1.0, "weight_time_per_s: -1 is outside its range [0, 1000]", "range"),
    ("weight_impulse_per_Ns", -1e-300, "weight_impulse_per_Ns: -1e-300 is outside", "range"),
    ("weight_impulse_per_Ns", INF, "weight_impulse_per_Ns: inf is not", "not_finite"),
    ("options.method", 2, "options.method: 2 is outside its range [0, 1]", "range"),
    ("options.method", -1, "options.method: -1 is outside", "range"),
    ("options.effort", 2, "options.effort: 2 is outside its range [0, 1]", "range"),
    ("options.effort", -128, "options.effort: -128 is outside", "range"),
    ("options.num_attach_heights", 9, "options.num_attach_heights: 9 is outside its range [0, 8]", "range"),
    ("options.num_attach_heights", -128, "options.num_attach_heights: -128 is outside", "range"),
    ("options.ring_angle_rad", 6.3, "options.ring_angle_rad: 6.3 is outside", "range"),
    ("options.ring_angle_rad", NAN, "options.ring_angle_rad: nan is not", "not_finite"),
]


class InvalidScenarios(DaemonTest):
    def test_each_bad_field_is_answered_by_its_name_and_counted(self):
        daemon = self.start()
        counted = dict.fromkeys(("range", "not_finite", "not_unit", "singular", "weights"), 0)

        def check(q, expected, counter):
            plan = daemon.ask(q)
            with self.subTest(expected):
                quote = plan.quote
                self.assertEqual((quote.status, plan.answer.asker.request_id), (INVALID, q.asker.request_id))
                self.assertTrue(quote.reason.startswith(expected), quote.reason)
                self.assertEqual((quote.num_candidates, plan.num_legs, plan.num_segments, plan.num_events), (0, 0, 0, 0))
            counted[counter] += 1

        for i, (path, value, expected, counter) in enumerate(INVALID_FIELDS):
            check(changed(question(i + 1), path, value), expected, counter)
        both = changed(changed(question(900), "weight_time_per_s", 0), "weight_impulse_per_Ns", 0)
        check(both, "weight_time_per_s and weight_impulse_per_Ns: both are zero, one must be positive", "weights")
        high = changed(changed(question(901), "options.num_attach_heights", 2), "options.attach_heights_m.1", 1.6)
        check(high, "options.attach_heights_m[1]: 1.6 is outside its range [-1.524, 1.524]", "range")

        status = daemon.next_status()
        self.assertEqual(counted, {name: getattr(status, "rejected_" + name) for name in counted})
        self.assertEqual(status.accepted, 0)

    def test_what_is_not_asked_for_is_not_judged(self):
        q = changed(changed(question(1), "options.ring_angle_given", False), "options.ring_angle_rad", NAN)
        self.assertEqual(self.start().ask(changed(q, "options.attach_heights_m", [NAN] * 8)).quote.status, OK)


def unlike():
    """16 questions of which no two have the same answer."""
    every_height = [round(-1.524 + k * 3.048 / 7, 3) for k in range(8)]
    for i in range(16):
        q = changed(question(i, i), "X_IS.p_m", [-0.3 * i, 0.2 * i, 0.1 * i])
        q = changed(q, "weight_impulse_per_Ns", (0, 0.1, 1, 10)[i % 4])
        q = changed(q, "options.method", i % 3 == 2)
        q = changed(q, "options.effort", i % 5 == 4)
        q = changed(q, "options.attach_anywhere", i % 7 == 3)
        q = changed(q, "options.want_candidates", i % 2 == 1)
        q = changed(q, "options.want_front", i % 4 >= 2)
        if i % 4 == 3:
            q = changed(changed(q, "contact", 0), "options.ring_angle_given", False)
            q = changed(changed(q, "options.num_attach_heights", 8), "options.attach_heights_m", every_height)
        yield q


class Batches(DaemonTest):
    def test_each_scenario_of_a_batch_gets_the_quote_that_its_plan_has_to_the_last_bit_in_the_order_asked(self):
        daemon = self.start()
        scenarios = list(unlike())
        answer = daemon.ask(batch(1000, scenarios, 16))
        plans = daemon.ask_all([changed(q, "asker.epoch_us", 16) for q in scenarios])
        self.assertEqual((answer.answer.asker.request_id, answer.answer.asker.epoch_us, answer.num_quotes), (1000, 16, 16))
        self.assertEqual(len({quote.cost for quote in answer.quotes}), 16)
        for i, (quote, plan) in enumerate(zip(answer.quotes, plans)):
            with self.subTest(i):
                self.assertEqual(quote.status, OK)
                self.assertEqual(quote.encode(), plan.quote.encode())

    def test_a_batch_of_one_is_a_cost_only_query(self):
        answer = self.start().ask(batch(7, [question(5)]))
        self.assertEqual([quote.status for quote in answer.quotes], [OK])

    def test_candidates_and_front_come_only_on_request(self):
        daemon = self.start()
        for candidates in (False, True):
            for front in (False, True):
                q = changed(changed(question(5), "options.want_candidates", candidates), "options.want_front", front)
                quote = daemon.ask(batch(2 * candidates + front, [q])).quotes[0]
                self.assertEqual(quote.num_candidates, 3 if candidates else 0)
                self.assertEqual(quote.num_front > 0, front)
                if candidates:
                    self.assertEqual(min(c.cost for c in quote.candidates), quote.cost)

    def test_no_point_of_a_front_is_better_than_another_in_both_and_one_is_as_good_as_the_quote(self):
        daemon = self.start()
        for i, q in enumerate(changed(q, "options.want_front", True) for q in unlike()):
            quote = daemon.ask(batch(i, [q])).quotes[0]
            with self.subTest(i):
                self.assertGreater(quote.num_front, 0)
                for one, next_one in zip(quote.front, quote.front[1:]):
                    self.assertLess(one.time_s, next_one.time_s)
                    self.assertGreater(one.impulse_Ns, next_one.impulse_Ns)
                self.assertTrue(any(p.time_s <= quote.time_s and p.impulse_Ns <= quote.impulse_Ns for p in quote.front))
                for p in quote.front:
                    cost = q.weight_time_per_s * p.time_s + q.weight_impulse_per_Ns * p.impulse_Ns
                    self.assertAlmostEqual(p.cost, cost, delta=1e-12 * cost)
                    self.assertGreaterEqual(p.cost, quote.cost_lower_bound)

    def test_a_bad_scenario_is_named_and_leaves_the_others_alone(self):
        daemon = self.start()
        bad = [changed(question(1), "standoff_m", NAN), changed(question(2), "X_IS.p_m", [-900, 0, 0]),
               changed(question(3), "vehicle.thruster.2.n_T_S", [0, 0.5, 0])]
        answer = daemon.ask(batch(1, [question(0), bad[0], question(4), bad[1], bad[2], question(5)]))
        alone = daemon.ask_all([question(10), *bad])
        self.assertEqual([quote.status for quote in answer.quotes], [OK, INVALID, OK, INFEASIBLE, INVALID, OK])
        self.assertEqual([answer.quotes[i].cost for i in (0, 2, 5)], [alone[0].quote.cost] * 3)
        for i, plan in zip((1, 3, 4), alone[1:]):
            self.assertEqual(answer.quotes[i].encode(), plan.quote.encode())
        status = daemon.next_status()
        self.assertEqual((status.batches, status.quoted, status.accepted), (1, 3, 1))
        self.assertEqual((status.infeasible, status.rejected_not_finite, status.rejected_not_unit), (2, 2, 2))
        said = daemon.said()
        self.assertRegex(said, r"(?m) INFO  batch 0{15}1, scenario 1: invalid: standoff_m: nan is not a finite number$")
        self.assertRegex(said, r"(?m) INFO  batch 0{15}1: 3 of 6 scenarios ok, priced in .* ms$")

    def test_the_longest_answers_fit_one_datagram(self):
        daemon = self.start()
        q = changed(changed(question(1), "contact", 0), "options.num_attach_heights", 8)
        q = changed(q, "options.attach_heights_m", [-1.52345678 + 1e-8 * k for k in range(8)])
        q = changed(changed(q, "options.want_candidates", True), "options.want_front", True)
        far = changed(q, "X_IS.p_m", [-900, 0, 0])
        for number, scenario, status in ((1, q, OK), (2, far, INFEASIBLE)):
            answer = daemon.ask(batch(number, [scenario] * 16))
            self.assertEqual({(quote.status, quote.num_candidates) for quote in answer.quotes}, {(status, 16)})
            self.assertLess(len(daemon.quotes[number][0]), 54_000)
            print(f"a batch of 16 with status {status} takes {len(daemon.quotes[number][0])} bytes", flush=True)
        self.assertTrue(answer.quotes[0].reason.endswith(answer.quotes[0].candidates[-1].reason))  # not cut

    def test_a_repeated_batch_gets_the_same_bytes_and_its_id_is_none_of_a_scenario(self):
        daemon = self.start()
        daemon.ask(question(1))
        daemon.ask(batch(1, [question(1), question(2)]))
        daemon.ask(batch(1, [question(1), question(2)], 99))  # what is asked decides, not when
        daemon.ask(question(1))
        self.assertEqual((len(set(daemon.quotes[1])), len(set(daemon.answers[1]))), (1, 1))
        status = daemon.next_status()
        self.assertEqual((status.accepted, status.batches, status.quoted), (1, 1, 2))
        self.assertEqual(status.repeated, status.received - 2)
        self.assertEqual(daemon.ask(question(2)).quote.status, OK)  # 99 came with a repeated question and did not count

    def test_every_batch_of_a_burst_is_answered_exactly_once_among_scenarios(self):
        daemon = self.start()
        daemon.ask_all([make(i) for i in range(30) for make in (question, lambda i: batch(i, [question(0), question(1)]))])
        status = daemon.next_status()
        self.assertEqual((status.accepted, status.batches, status.quoted), (30, 30, 60))
        self.assertTrue(all(len(set(a)) == 1 for answers in (daemon.answers, daemon.quotes) for a in answers.values()))

    def test_epochs_of_batches_and_scenarios_are_one_order_and_those_within_a_batch_mean_nothing(self):
        daemon = self.start()
        self.assertEqual(daemon.ask(batch(1, [question(0, -5), question(1, NEWEST_US)], 1000)).quotes[0].status, OK)
        self.assertIn("999 is older than 1000", daemon.ask(question(2, 999)).quote.reason)
        self.assertEqual(daemon.ask(question(3, 2000)).quote.status, OK)
        stale = daemon.ask(batch(4, [question(0), question(1)], 1999))
        self.assertEqual([quote.status for quote in stale.quotes], [INVALID] * 2)
        self.assertIn("1999 is older than 2000", stale.quotes[1].reason)
        bad = changed(question(0), "contact", 77)
        self.assertEqual(daemon.ask(batch(5, [bad, bad], NEWEST_US)).quotes[0].status, INVALID)
        self.assertEqual(daemon.ask(batch(6, [bad, question(1)], 3000)).quotes[1].status, OK)
        self.assertIn("2999 is older than 3000", daemon.ask(question(7, 2999)).quote.reason)
        negative = daemon.ask(batch(8, [question(0), question(1)], -1))
        self.assertTrue(all(quote.reason.startswith("asker.epoch_us: -1 is negative") for quote in negative.quotes))
        self.assertEqual(daemon.next_status().rejected_stale_epoch, 4)

    def test_what_is_no_batch_through_and_through_is_refused_without_harm(self):
        daemon = self.start()
        good = batch(1, [question(0), question(1)]).encode()
        counted = lambda count: good[:40] + struct.pack(">i", count) + good[44:]
        whole = lambda count: counted(count) + (count - 2) * question(0).encode()[8:]
        rng = random.Random(SEED)
        malformed = [counted(count) for count in (0, 1, 3, 16, 17, -1, -2**31, 2**31 - 1)]
        malformed += [whole(17), whole(60), counted(0)[:44], message(question(0)).encode(), b"", rng.randbytes(1594)]
        malformed += [good[:length] for length in range(0, len(good), 61)] + [good + b"\0", rng.randbytes(8) + good[8:]]
        malformed += [good[:8] + rng.randbytes(rng.randrange(3000)) for _ in range(200)]
        for channel, data in [(BATCH, data) for data in malformed] + [(SCENARIO, good)]:
            daemon.lcm.publish(channel, data)
            daemon.ask(question(0))  # so that no datagram is lost for lack of room
        self.assertEqual(daemon.next_status().rejected_undecodable, len(malformed) + 1)
        self.assertEqual(daemon.quotes, {})
        self.assert_alive(daemon)

    def test_the_sign_of_life_does_not_wait_for_a_long_batch(self):
        daemon = self.start()
        q = changed(changed(changed(question(0), "contact", 0), "options.effort", 1), "options.want_front", True)
        q = changed(changed(q, "options.num_attach_heights", 8), "options.attach_heights_m", [0.1 * k for k in range(8)])
        seen = len(daemon.statuses)
        start = time.monotonic()
        daemon.ask(batch(1, [q] * 4))
        took_s = time.monotonic() - start
        status = daemon.next_status()
        longest_us = max(b.uptime_us - a.uptime_us for a, b in zip(daemon.statuses[seen - 1:], daemon.statuses[seen:]))
        print(f"a batch of 4 fronts by effort best takes {took_s:.1f} s, one of them {status.worst_quote_us / 1e6:.2f} s; "
              f"status every {longest_us / 1e6:.2f} s at most", flush=True)
        self.assertLess(longest_us, 1e6 + status.worst_quote_us + 0.5e6)
        self.assertGreater(status.worst_quote_us, 0)


class Junk(DaemonTest):
    """Every 15 datagrams a stored answer is asked for. The transport keeps the order, so when it comes, they were read."""

    def setUp(self):
        self.random = random.Random(SEED)
        print(f"SSV_SEED={SEED}", flush=True)

    def flipped(self, data):
        data = bytearray(data)
        for _ in range(self.random.randint(1, 8)):
            data[self.random.randrange(len(data))] ^= 1 << self.random.randrange(8)
        return bytes(data)

    def cut(self, datagram):
        """Its start, but not one that ends within the "SSV_" of the channel: liblcm reads on where an older datagram lay in
        its buffer. What it then takes for an answer has a negative size, and Python's binding crashes on that, not the
        daemon."""
        return datagram[:self.random.choice([n for n in range(len(datagram)) if not 8 <= n <= 12])]

    def fragment(self, payload):
        """A piece of one of few messages, so that pieces which contradict one another meet."""
        r = self.random
        sequence, size = r.randrange(4), r.choice((0, 1, 700, 1024, 2**28, 2**31, 2**32 - 1))
        offset = r.choice((0, 1, 500, 700, 2**31, 2**32 - 16, 2**32 - 1, r.getrandbits(32)))
        number, count = r.choice((0, 1, 2, 65535)), r.choice((0, 1, 2, 3, 65535))
        head = struct.pack(">IIIIHH", FRAGMENT_MAGIC, sequence, size, offset, number, count)
        return head + payload[:r.randrange(len(payload))]

    def junk(self, count):
        r = self.random
        good = message(question(r.getrandbits(62))).encode()
        good_batch = batch(r.getrandbits(62), [question(1), question(2)]).encode()
        named, named_batch = SCENARIO.encode() + b"\0", BATCH.encode() + b"\0"
        short = lambda name, payload: struct.pack(">II", SHORT_MAGIC, r.getrandbits(32)) + name + payload
        kinds = (
            lambda: r.randbytes(r.randrange(0, 1400)),
            lambda: self.cut(short(named, good)),
            lambda: self.flipped(short(named, good)),
            lambda: short(named, self.flipped(good)),
            lambda: short(named, r.randbytes(8) + good[8:]),  # a type of another version
            lambda: short(named, good[:8] + good[8:r.randrange(8, len(good))]),
            lambda: short(named, good + r.randbytes(r.randrange(1, 400))),
            lambda: short(r.randbytes(r.randrange(0, 100)), good),  # channel names of any bytes and length
            lambda: short(b"A" * r.randrange(60, 70) + r.choice((b"", b"\0")), good),
            lambda: short(named, b""),
            lambda: short(named_batch, r.randbytes(8) + good_batch[8:]),
            lambda: short(named_batch, self.flipped(good_batch[:44]) + good_batch[44:]),
            lambda: self.cut(short(named_batch, good_batch)),
            lambda: self.fragment(named + good),
            lambda: self.fragment(r.randbytes(900)),
        )
        for i in range(count):
            yield kinds[i % len(kinds)]()

    def test_100000_junk_datagrams_leave_it_answering(self):
        daemon = self.start()
        daemon.ask(question(1))
        with daemon.raw_sender() as raw:
            for i, datagram in enumerate(self.junk(100_000)):
                raw.send(datagram)
                if i % 15 == 14:  # as many as the socket has room for
                    daemon.answers.clear()
                    daemon.ask(question(1))
        status = daemon.next_status()
        print(f"100000 junk datagrams: {status.rejected_undecodable} reached the decoder, "
              f"{status.received - status.rejected_undecodable - status.repeated} were scenarios all the same", flush=True)
        self.assertGreater(status.rejected_undecodable, 20_000)
        self.assert_alive(daemon)

    def test_a_datagram_cut_within_its_channel_s_name_is_refused(self):
        """liblcm takes the rest of the name from the datagram before, if nobody wanted that; the size comes out negative."""
        daemon = self.start()
        with daemon.raw_sender() as raw:
            for channel, q in ((SCENARIO, question(1)), (BATCH, batch(1, [question(1)]))):
                unwanted = struct.pack(">II", SHORT_MAGIC, 0) + channel.replace("SSV_", "OLD_").encode() + b"\0" + message(q).encode()
                raw.send(unwanted)
                raw.send(unwanted[:8] + b"SSV_")
        status = daemon.next_status()
        self.assertEqual((status.received, status.rejected_undecodable), (2, 2))
        self.assert_alive(daemon)

    def malformed(self, count):
        """Tasks that decode: half of them noise, half with a few numbers of the nasty kind in a good one."""
        r = self.random
        good = message(question(0)).encode()
        nasty = (NAN, INF, -INF, 0.0, -0.0, 5e-324, -5e-324, 2.2e-308, 1.7e308, -1.7e308, 1e-9, -1e-9, 1e9, -1.0, 2.0**53)
        for i in range(count):
            head = good[:8] + struct.pack(">4q", 0, i, 0, 0)
            if i % 2 == 0:
                yield head + r.randbytes(len(good) - 40)
                continue
            data = bytearray(head + good[40:])
            for _ in range(r.randint(1, 3)):
                struct.pack_into(">d", data, 40 + 8 * r.randrange((len(data) - 40) // 8), r.choice(nasty))
            yield bytes(data)

    def test_10000_malformed_scenarios_are_all_answered_and_leave_it_answering(self):
        daemon = self.start()
        tally = {}
        batch = []
        for data in self.malformed(10_000):
            batch.append(ssv.task_t.decode(data))
            if len(batch) == 16:  # as many as a socket has room for
                for quote in (plan.quote for plan in daemon.ask_all(batch)):
                    self.assertIn(quote.status, (OK, INFEASIBLE, INVALID))
                    self.assertEqual(quote.status == OK, quote.reason == "")
                    self.assertLess(len(quote.reason), 1535)
                    tally[quote.status] = tally.get(quote.status, 0) + 1
                batch = []
                daemon.answers.clear()
        print(f"10000 malformed scenarios: {tally.get(INVALID, 0)} invalid, {tally.get(INFEASIBLE, 0)} infeasible, "
              f"{tally.get(OK, 0)} sound all the same", flush=True)
        self.assertGreater(tally.get(INVALID, 0), 5000)
        self.assert_alive(daemon)


class Process(DaemonTest):
    def run_daemon(self, *arguments):
        return subprocess.run([DAEMON, *arguments], capture_output=True, text=True, timeout=DEADLINE_S)

    def test_status_comes_once_a_second_with_the_version_and_the_type_hashes(self):
        daemon = self.start()
        self.assertEqual(daemon.ask(question(77)).quote.status, OK)
        seen = len(daemon.statuses)
        daemon.wait_until(lambda: len(daemon.statuses) >= seen + 5)
        first, *_, last = daemon.statuses[seen:]
        self.assertAlmostEqual((last.uptime_us - first.uptime_us) / 1e6 / (len(daemon.statuses) - seen - 1), 1, delta=0.3)
        type_hash = lambda t: struct.unpack(">q", t._get_packed_fingerprint())[0]
        self.assertEqual((last.task_type_hash, last.plan_type_hash, last.scenario_batch_type_hash,
                          last.quote_batch_type_hash, last.planner_status_type_hash),
                         tuple(map(type_hash, (ssv.task_t, ssv.plan_t, ssv.scenario_batch_t, ssv.quote_batch_t,
                                               ssv.planner_status_t))))
        self.assertEqual(f"ssv-plannerd {last.planner.version} (double)\n", self.run_daemon("--version").stdout)
        self.assertEqual(last.planner.scalar, ssv.planner_t.SCALAR_DOUBLE)
        self.assertNotEqual(last.planner.planner_id, 0)
        self.assertEqual((last.accepted, last.last_request_id), (1, 77))
        self.assertLess(0, last.last_plan_us)
        self.assertLessEqual(last.last_plan_us, last.worst_plan_us)

    def test_what_is_no_scenario_is_counted_and_logged_but_each_one_only_when_verbose(self):
        for options, each in (((), False), (("--verbose",), True)):
            daemon = self.start(*options)
            daemon.lcm.publish(SCENARIO, ssv.pose_t().encode())
            daemon.wait_until(lambda: daemon.statuses[-1].rejected_undecodable == 1)
            daemon.next_status()
            self.assertIn("WARN", daemon.said())
            self.assertEqual("DEBUG" in daemon.said(), each)

    def test_each_answer_is_a_line_of_the_log(self):
        daemon = self.start()
        daemon.ask(question(123456))
        daemon.ask(changed(question(123457), "standoff_m", NAN))
        said = daemon.said()
        stamp = r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z"
        self.assertRegex(said, rf"(?m)^{stamp} INFO  scenario {123456:016x}: ok, J .* planned in .* ms$")
        self.assertRegex(said, rf"(?m) INFO  scenario {123457:016x}: invalid after \S+ ms: standoff_m: nan is not a finite number$")

    def test_sigterm_and_sigint_end_it_with_exit_code_0(self):
        for number in (signal.SIGTERM, signal.SIGINT):
            daemon = self.start()
            daemon.process.send_signal(number)
            self.assertEqual(daemon.process.wait(DEADLINE_S), 0)

    def assert_sigterm_ends_it_under_a_flood(self, payload, flooded, channel=SCENARIO):
        daemon = self.start()
        stop = threading.Event()
        head = struct.pack(">II", SHORT_MAGIC, 0) + channel.encode() + b"\0"

        def flood():
            with daemon.raw_sender() as raw:
                i = 0
                while not stop.is_set():
                    i += 1
                    raw.send(head + payload(i))

        thread = threading.Thread(target=flood)
        thread.start()
        try:
            daemon.wait_until(lambda: flooded(daemon.statuses[-1]))
            start = time.monotonic()
            daemon.process.terminate()
            self.assertEqual(daemon.process.wait(DEADLINE_S), 0)
            print(f"stopped {time.monotonic() - start:.3f} s after SIGTERM", flush=True)
        finally:
            stop.set()
            thread.join()

    def test_sigterm_ends_it_while_scenarios_pour_in(self):
        good = message(question(0)).encode()
        self.assert_sigterm_ends_it_under_a_flood(lambda i: good[:16] + struct.pack(">q", i) + good[24:],
                                                  lambda status: status.accepted > 20)

    def test_sigterm_ends_it_while_batches_pour_in(self):
        good = batch(0, [question(0)] * 16).encode()
        self.assert_sigterm_ends_it_under_a_flood(lambda i: good[:16] + struct.pack(">q", i) + good[24:],
                                                  lambda status: status.batches > 5, BATCH)

    def test_sigterm_ends_it_while_junk_pours_in(self):
        self.assert_sigterm_ends_it_under_a_flood(lambda i: b"junk", lambda status: status.rejected_undecodable > 1000)

    def test_without_a_way_to_open_lcm_it_says_what_to_do_and_ends_with_exit_code_4(self):
        for url, *words in (("nonsense://", "nonsense://", "udpm://239.255.76.67:7667?ttl=0", "tcpq://HOST:7700"),
                            ("udpm://10.0.0.1:7667", "'10.0.0.1' is no multicast group"),
                            ("tcpq://127.0.0.1:1", "lcm-tcpq-server")):
            with self.subTest(url):
                result = self.run_daemon("--lcm-url", url)
                self.assertEqual(result.returncode, 4)
                for word in words:
                    self.assertIn(word, result.stderr)

    def test_help_shows_examples_and_exit_codes_and_wrong_usage_ends_with_64(self):
        text = self.run_daemon("--help").stdout
        self.assertIn("Examples:", text)
        self.assertIn("Exit codes:", text)
        for wrong in (("--nonsense",), ("something",)):
            self.assertEqual(self.run_daemon(*wrong).returncode, 64)


if __name__ == "__main__":
    unittest.main(verbosity=2)

"""Several askers and several planners on one bus, a stranger among them: everybody gets the answer to his own question.

SSV_LONG=1 runs as many rounds as the requirements name.
"""

import json
import os
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

import lcm

import ssv

BIN = Path(os.environ["SSV_BIN_DIR"])
SOURCE = Path(os.environ["SSV_SOURCE_DIR"])
SCENARIOS = sorted((SOURCE / "host/scenarios").glob("*.yaml"))
TASK = SOURCE / "host/scenarios/port2_either.yaml"
LONG = bool(os.environ.get("SSV_LONG"))
NANOSECONDS = 10**9  # what an asker counts in that takes its clock for microseconds


def run(*arguments, timeout=120):
    return subprocess.run([BIN / "ssv", *map(str, arguments)], capture_output=True, text=True, timeout=timeout)


def start(*arguments):
    return subprocess.Popen([BIN / "ssv", *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def scenario(plan_json, asker_id, request_id, epoch_us=0):
    """The scenario of a plan's JSON as a message."""
    def fill(message, fields):
        for key, value in fields.items():
            at = getattr(message, key)
            if isinstance(value, dict):
                fill(at, value)
            elif isinstance(value, list) and value and isinstance(value[0], dict):
                for one, part in zip(at, value):
                    fill(one, part)
            else:
                setattr(message, key, value)
    fields = json.loads(json.dumps(plan_json["scenario"]))
    del fields["asker"]
    fields["options"]["method"] = ("optimal", "paper").index(fields["options"]["method"])
    fields["options"]["effort"] = ("quick", "best").index(fields["options"]["effort"])
    fields["obstacles"], fields["left"] = int(fields["obstacles"], 16), int(fields["left"], 16)
    q = ssv.scenario_t()
    fill(q, fields)
    q.asker.asker_id, q.asker.request_id, q.asker.epoch_us = asker_id, request_id, epoch_us
    return q


def task(scenario):
    """The question for a plan of it, with nothing around."""
    message = ssv.task_t()
    message.scenario = scenario
    return message


class Bus(unittest.TestCase):
    def setUp(self):
        port = 20000 + (os.getpid() * 7 + hash(self.id())) % 20000
        self.url = f"udpm://239.255.76.67:{port}?ttl=0"
        self.lcm = f"--lcm={self.url}"
        self.here = json.loads(run("plan", TASK, "--format", "json").stdout)

    def planner(self, scalar="double"):
        name = "ssv-plannerd" + ("" if scalar == "double" else "-" + scalar)
        process = subprocess.Popen([BIN / name, "--lcm-url", self.url], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        def end():
            process.terminate()
            process.wait(10)
        self.addCleanup(end)
        return process

    def ask(self, q, bus=None):
        """The answer of whoever answers, by the message types in Python."""
        bus = bus or lcm.LCM(self.url)
        got = []
        channel, kind = (("SSV_PLAN", ssv.plan_t) if isinstance(q, ssv.scenario_t) else
                         ("SSV_QUOTE_BATCH", ssv.quote_batch_t))
        def on(_channel, data):
            answer = kind.decode(data)
            if answer.answer.asker.request_id == q.asker.request_id:
                got.append(answer)
        subscription = bus.subscribe(channel, on)
        end = time.monotonic() + 30
        while not got and time.monotonic() < end:
            if isinstance(q, ssv.scenario_t):
                bus.publish("SSV_SCENARIO", task(q).encode())
            else:
                bus.publish("SSV_SCENARIO_BATCH", q.encode())
            bus.handle_timeout(500)
        bus.unsubscribe(subscription)
        self.assertTrue(got, "nobody answered")
        return got[0]

    def assert_plan(self, done):
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(json.loads(done.stdout)["plan"]["plan_hash"], self.here["plan"]["plan_hash"])


class Askers(Bus):
    def test_two_command_lines_at_once_both_get_their_answer_in_20_of_20_rounds(self):
        self.planner()
        for _ in range(20):
            askers = [start("quote", *SCENARIOS, "--effort", "best", self.lcm, "--timeout", "30"),
                      start("plan", TASK, self.lcm, "--timeout", "30"),
                      start("quote", *SCENARIOS, self.lcm, "--timeout", "30")]
            for asker in askers:
                _, stderr = asker.communicate(timeout=100)
                self.assertEqual((asker.returncode, stderr), (0, ""))

    def test_an_asker_whose_clock_runs_ahead_shuts_nobody_out(self):
        self.planner()
        ahead = ssv.scenario_batch_t()
        ahead.asker.asker_id, ahead.asker.request_id, ahead.asker.epoch_us = 6, 2, 2**62
        ahead.num_scenarios, ahead.scenarios = 1, [scenario(self.here, 0, 0)]
        for asker_id in (0, 5):
            q = scenario(self.here, asker_id, 1, int(time.time()) * NANOSECONDS)
            self.assertEqual(self.ask(q).quote.status, ssv.quote_t.STATUS_OK)
        self.assertEqual(self.ask(ahead).quotes[0].status, ssv.quote_t.STATUS_OK)
        for _ in range(20):
            self.assert_plan(run("plan", TASK, self.lcm, "--format", "json", "--timeout", "30"))

    def test_an_asker_whose_clock_runs_behind_is_answered_like_all_others(self):
        self.planner()
        self.assert_plan(run("plan", TASK, self.lcm, "--format", "json", "--timeout", "30"))
        for number in range(20):
            self.assertEqual(self.ask(scenario(self.here, 9, number + 1, number)).quote.status, ssv.quote_t.STATUS_OK)

    def test_another_question_under_an_old_id_is_refused_and_never_answered_with_the_old_plan(self):
        self.planner()
        one, other = scenario(self.here, 3, 1), scenario(self.here, 3, 1)
        other.weight_time_per_s *= 2
        first = self.ask(one)
        self.assertEqual(first.quote.status, ssv.quote_t.STATUS_OK)
        for _ in range(20):
            refused = self.ask(other)
            self.assertEqual((refused.quote.status, refused.num_segments), (ssv.quote_t.STATUS_INVALID, 0))
            self.assertIn("request_id", refused.quote.reason)
            self.assertNotEqual(refused.answer.question_hash, first.answer.question_hash)
            self.assertEqual(self.ask(one).encode(), first.encode())
        of_another = self.ask(scenario(self.here, 4, 1))  # the same id of another asker is another question
        self.assertEqual(of_another.quote.status, ssv.quote_t.STATUS_OK)

    def test_a_planner_that_is_started_again_answers_the_same_question(self):
        first = self.planner()
        q = scenario(self.here, 3, 1, 5)
        before = self.ask(q)
        first.terminate()
        first.wait(10)
        self.planner()
        after = self.ask(q)
        self.assertEqual(before.plan_hash, after.plan_hash)
        self.assertNotEqual(before.answer.planner.planner_id, after.answer.planner.planner_id)
        self.assert_plan(run("plan", TASK, self.lcm, "--format", "json", "--timeout", "30"))

    def test_a_long_question_of_many_files_survives_a_planner_that_ends_in_the_middle(self):
        first, _ = self.planner(), self.planner()
        asker = start("quote", *(SCENARIOS * 40), "--effort", "best", self.lcm, "--timeout", "60", "--format", "json")
        time.sleep(2)
        self.assertIsNone(asker.poll(), "too short a question for this test")
        first.kill()
        stdout, stderr = asker.communicate(timeout=300)
        self.assertEqual((asker.returncode, stderr), (0, ""))
        self.assertEqual(len(json.loads(stdout)["quotes"]), 40 * len(SCENARIOS))

    def test_two_demos_at_once_both_work(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        for _ in range(20 if LONG else 2):
            demos = [subprocess.Popen([sys.executable, "-B", SOURCE / "host/demo.py", BIN, Path(folder.name) / f"{number}.html"],
                                      stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                      env=dict(os.environ, LCM_DEFAULT_URL=self.url)) for number in range(2)]
            for demo in demos:
                _, stderr = demo.communicate(timeout=200)
                self.assertEqual((demo.returncode, stderr), (0, b""))


class Planners(Bus):
    def test_a_planner_of_the_scalar_asked_for_answers_and_no_other(self):
        scalars = ("double", "float", "fixed")
        for scalar in scalars:
            self.planner(scalar)
        expected = {scalar: json.loads(run("plan", TASK, "--scalar", scalar, "--format", "json").stdout)["plan"]["plan_hash"]
                    for scalar in scalars}
        self.assertEqual(len(set(expected.values())), 3)
        for number in range(200 if LONG else 30):
            scalar = scalars[number % 3]
            done = run("plan", TASK, self.lcm, "--scalar", scalar, "--format", "json", "--timeout", "30")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            plan = json.loads(done.stdout)["plan"]
            self.assertEqual((plan["answer"]["planner"]["scalar"], plan["plan_hash"]), (scalar, expected[scalar]))

    def test_a_burst_of_16_full_batches_loses_none_and_comes_back_in_order(self):
        self.planner()
        self.planner()
        paths = (SCENARIOS * 60)[:256]
        here = json.loads(run("quote", *paths, "--format", "json").stdout)["quotes"]
        for _ in range(100 if LONG else 3):
            done = run("quote", *paths, self.lcm, "--format", "json", "--timeout", "30")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            there = json.loads(done.stdout)["quotes"]
            self.assertEqual([row["quote"] for row in there], [row["quote"] for row in here])

    def test_two_planners_share_the_batches(self):
        self.planner()
        self.planner()
        batches = {}
        bus = lcm.LCM(self.url)
        def on_quotes(_channel, data):
            quotes = ssv.quote_batch_t.decode(data)
            batches.setdefault(quotes.answer.planner.planner_id, set()).add(quotes.answer.asker.request_id)
        bus.subscribe("SSV_QUOTE_BATCH", on_quotes).set_queue_capacity(1000)
        asker = start("quote", *(SCENARIOS * 60)[:256], "--effort", "best", self.lcm, "--timeout", "60")
        while asker.poll() is None:
            bus.handle_timeout(50)
        asker.communicate()
        while bus.handle_timeout(200):
            pass
        self.assertEqual((asker.returncode, len(batches)), (0, 2))
        shares = sorted(map(len, batches.values()))
        self.assertGreater(shares[0], shares[1] / 4)  # on two busy cores one planner may be slower


class Strangers(Bus):
    def test_a_stranger_who_answers_every_question_with_nonsense_wins_none(self):
        self.planner()
        forged = self.ask(scenario(self.here, 1, 1))
        forged.quote.cost, forged.quote.cost_lower_bound, forged.quote.choice.contact = 1e-3, 5.0, 2
        for segment in forged.segments:
            segment.u_start_N = segment.u_end_N = [1e6] * 6
        stop, sent, bus = threading.Event(), [], lcm.LCM(self.url)

        def answer(_channel, data):
            head = forged.answer.asker
            head.asker_id, head.request_id, head.epoch_us, head.planner_id = struct.unpack_from(">4q", data, 8)
            bus.publish("SSV_PLAN", forged.encode())
            sent.append(head.request_id)
        bus.subscribe("SSV_SCENARIO", answer).set_queue_capacity(1000)

        def spoof():
            while bus.handle_timeout(100) or not stop.is_set():
                pass

        thread = threading.Thread(target=spoof)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(stop.set)
        refused = 0
        for _ in range(200):
            done = run("plan", TASK, self.lcm, "--format", "json", "--timeout", "30")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(json.loads(done.stdout)["plan"]["plan_hash"], self.here["plan"]["plan_hash"])
            refused += "refused an answer on SSV_PLAN" in done.stderr
        stop.set()
        thread.join()
        print(f"{len(sent)} forged answers to 200 questions, {refused} came first and were refused, none was taken", flush=True)
        self.assertGreaterEqual(len(sent), 200)
        self.assertGreater(refused, 0, "the stranger never came first, so this tells nothing")

    def test_a_flood_of_forged_answers_is_told_in_a_few_lines_and_the_right_one_is_still_awaited(self):
        forged = ssv.plan_t()
        forged.answer.planner.planner_id = 1
        bus = lcm.LCM(self.url)
        flooded = []
        def answer(_channel, data):
            head = forged.answer.asker
            head.asker_id, head.request_id, head.epoch_us, head.planner_id = struct.unpack_from(">4q", data, 8)
            for _ in range(10):
                bus.publish("SSV_PLAN", forged.encode())
            flooded.append(data)
        bus.subscribe("SSV_SCENARIO", answer)
        asker = start("plan", TASK, self.lcm, "--timeout", "30")
        while len(flooded) < 2:
            bus.handle_timeout(100)
        self.planner()
        _, stderr = asker.communicate(timeout=60)
        self.assertEqual(asker.returncode, 0, stderr)
        self.assertEqual(stderr.count("refused an answer on SSV_PLAN, still waiting for a right one: question_hash"), 3)
        self.assertRegex(stderr, r"ssv: refused \d+ more answers on SSV_PLAN\n$")


if __name__ == "__main__":
    unittest.main(verbosity=2)

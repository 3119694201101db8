"""ssv schedule over a bus that loses, delays and forges answers, with planners that die, and under Ctrl-C: the schedule is still
right, or the command says why there is none. Between planners and asker stands a relay, which does to answers what a test says.
"""
import json
import os
import random
import signal
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

import lcm

import ssv
from test_askers import BIN, SOURCE, Bus

EASE = (SOURCE / "host/structures/ease.yaml").read_text()
THREE = EASE[:EASE.index("  - {name: leg_east,")]
SEED = 20261202
QUESTIONS, ANSWERS, STATUS = "SSV_SCENARIO_BATCH", "SSV_QUOTE_BATCH", "SSV_PLANNER_STATUS"


class Relay:
    """Carries questions from the asker's bus to the planners', and answers and signs of life back. `pass_on` gets each answer as
    bytes and returns what becomes of it: a list of (seconds to wait, bytes)."""

    def __init__(self, planners_url, asker_url, pass_on):
        self.pass_on, self.answers, self.late = pass_on, 0, []
        self.planners, self.asker = lcm.LCM(planners_url), lcm.LCM(asker_url)
        self.asker.subscribe(QUESTIONS, self.planners.publish).set_queue_capacity(1000)
        self.planners.subscribe(STATUS, self.asker.publish)
        self.planners.subscribe(ANSWERS, self._answer).set_queue_capacity(1000)
        self._stop = threading.Event()
        self._threads = [threading.Thread(target=self._run, args=(bus,)) for bus in (self.planners, self.asker)]
        for thread in self._threads:
            thread.start()

    def _answer(self, _channel, data):
        self.answers += 1
        self.late += [(time.monotonic() + wait, answer) for wait, answer in self.pass_on(data)]

    def _run(self, bus):
        while not self._stop.is_set():
            bus.handle_timeout(5)
            if bus is self.planners:
                due = [entry for entry in self.late if entry[0] <= time.monotonic()]
                self.late = [entry for entry in self.late if entry not in due]
                for _, answer in due:
                    self.asker.publish(ANSWERS, answer)

    def close(self):
        self._stop.set()
        for thread in self._threads:
            thread.join()


def forged(change):
    """What changes an answer after decoding it."""
    def pass_on(data):
        answer = ssv.quote_batch_t.decode(data)
        change(answer)
        return answer.encode()
    return pass_on


class Faults(Bus):
    @classmethod
    def setUpClass(cls):
        cls.right = cls.schedule_of(cls.start("--format", "json"))

    @staticmethod
    def start(*arguments, text=THREE):
        with tempfile.TemporaryFile("w+") as file:
            file.write(text)
            file.seek(0)
            return subprocess.Popen([BIN / "ssv", "schedule", "-", *map(str, arguments)], stdin=file, stdout=subprocess.PIPE,
                                    stderr=subprocess.PIPE, text=True)

    @staticmethod
    def schedule_of(process):
        stdout, stderr = process.communicate(timeout=200)
        if process.returncode != 0:
            raise AssertionError(f"exit code {process.returncode}: {stderr}")
        return json.loads(stdout)["schedule"]

    def relay(self, pass_on):
        port = int(self.url.split(":")[2].split("?")[0])
        self.asker_url = self.url.replace(f":{port}?", f":{port + 20001}?")
        relay = Relay(self.url, self.asker_url, pass_on)
        self.addCleanup(relay.close)
        return relay

    def ask_over(self, *arguments, url=None):
        return self.start("--lcm", url or self.asker_url, "--format", "json", *arguments)

    def assert_right(self, process):
        self.assertEqual(self.schedule_of(process), self.right)


class Answers(Faults):
    def test_every_fifth_answer_is_lost(self):
        self.planner()
        draw, lost = random.Random(SEED), []

        def lose(data):
            if draw.random() < 0.2:
                lost.append(data)
                return []
            return [(0, data)]
        relay = self.relay(lose)
        self.assert_right(self.ask_over())
        print(f"{len(lost)} of {relay.answers} answers were lost", flush=True)
        self.assertGreater(len(lost), 5)

    def test_answers_come_late_and_twice(self):
        self.planner()
        self.planner()
        draw = random.Random(SEED)
        late = []

        def delay(data):
            wait = draw.choice([0] * 12 + [0.6, 1.5, 4])  # past the next time that it is asked, and past a planner's patience
            late.append(wait)
            return [(wait, data), (wait + 0.3, data)]
        self.relay(delay)
        self.assert_right(self.ask_over())
        self.assertGreater(max(late), 1)

    def test_answers_to_another_question_and_under_no_name_come_first(self):
        def other_hash(answer):
            answer.answer.question_hash ^= 1

        def half_price(answer):
            for quote in answer.quotes:
                quote.cost /= 2

        def other_count(answer):
            answer.num_quotes -= 1
            answer.quotes = answer.quotes[1:]
        self.planner()
        forgers = [forged(change) for change in (other_hash, half_price, other_count)]
        self.relay(lambda data: [*((0, forger(data)) for forger in forgers), (0.001, data[:-3]), (0.002, data)])
        asker = self.ask_over()
        stdout, stderr = asker.communicate(timeout=200)
        self.assertEqual(asker.returncode, 0, stderr)
        self.assertEqual(json.loads(stdout)["schedule"], self.right)
        self.assertIn("refused an answer on SSV_QUOTE_BATCH, still waiting for a right one: question_hash", stderr)

    def test_prices_that_add_up_and_are_of_no_plan_are_found_out_in_the_end(self):
        def flatter(answer):
            for quote in answer.quotes:
                for field in ("cost", "cost_lower_bound", "time_s", "impulse_Ns"):
                    setattr(quote, field, getattr(quote, field) * 0.9)
        self.planner()
        self.relay(lambda data: [(0, forged(flatter)(data))])
        asker = self.ask_over()
        stdout, stderr = asker.communicate(timeout=200)
        self.assertEqual((asker.returncode, stdout), (1, ""), stderr)
        self.assertRegex(stderr, r"part 1 is priced at \S+, but its plan says otherwise")

    def test_no_answer_ever_comes(self):
        self.planner()
        self.relay(lambda data: [])
        asker = self.ask_over("--timeout", "2")
        stdout, stderr = asker.communicate(timeout=60)
        self.assertEqual((asker.returncode, stdout), (4, ""), stderr)
        self.assertIn("nobody answered", stderr)


class Planners(Faults):
    def test_a_planner_is_killed_and_another_started_during_the_search(self):
        first, answers = self.planner(), []

        def kill_once(data):
            answers.append(data)
            if len(answers) == 5:
                first.kill()
                threading.Timer(1, self.planner).start()
                return []
            return [(0, data)]
        self.relay(kill_once)
        self.assert_right(self.ask_over("--timeout", "30"))
        self.assertGreater(len(answers), 5)

    def test_a_planner_dies_for_good(self):
        first = self.planner()
        answers = []

        def kill_later(data):
            answers.append(data)
            if len(answers) == 5:
                first.kill()
            return [(0, data)]
        self.relay(kill_later)
        asker = self.ask_over("--timeout", "3")
        stdout, stderr = asker.communicate(timeout=60)
        self.assertEqual((asker.returncode, stdout), (4, ""), stderr)
        self.assertIn("nobody answered", stderr)

    def test_of_two_scalars_the_right_one_is_asked(self):
        self.planner("float")
        self.planner("double")
        self.assert_right(self.ask_over(url=self.url))

    def test_a_planner_of_another_scalar_is_not_asked(self):
        self.planner("fixed")
        asker = self.ask_over("--timeout", "3", url=self.url)
        stdout, stderr = asker.communicate(timeout=60)
        self.assertEqual((asker.returncode, stdout), (4, ""), stderr)
        self.assertIn("computes in fixed, not in double", stderr)


class Interrupted(Faults):
    def interrupt(self, number, *arguments, is_begun=lambda: True):
        """Ends a search that is some seconds old, and has begun what the test is about, however busy the machine is."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "schedule.json"
            structure = (SOURCE / "host/structures/rack_of_12.yaml").read_text()
            asker = self.start("--format", "json", "--output", path, *arguments, text=structure)
            time.sleep(3)
            deadline_s = time.monotonic() + 60
            while not is_begun() and time.monotonic() < deadline_s:
                time.sleep(0.1)
            self.assertIsNone(asker.poll(), "too short a search for this test")
            asker.send_signal(number)
            stdout, stderr = asker.communicate(timeout=20)
            self.assertEqual((asker.returncode, stdout, stderr), (0, "", ""))
            self.assertEqual(os.listdir(folder), ["schedule.json"])
            return json.loads(path.read_text())["schedule"]

    def test_the_best_schedule_so_far_is_written(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            schedule = self.interrupt(number)
            self.assertFalse(schedule["optimal"])
            self.assertEqual(len(schedule["subtasks"]), 6)
            self.assertLessEqual(schedule["cost"], schedule["greedy_cost"])

    def test_over_lcm_too_where_nobody_answers_any_more(self):
        answers = []
        self.planner()

        def fall_silent(data):
            answers.append(data)
            return [(0, data)] if len(answers) <= 60 else []
        self.relay(fall_silent)
        schedule = self.interrupt(signal.SIGINT, "--lcm", self.asker_url, "--timeout", "100", is_begun=lambda: len(answers) > 60)
        self.assertGreater(len(answers), 60)
        self.assertFalse(schedule["optimal"])


if __name__ == "__main__":
    unittest.main(verbosity=2)

"""What one asker, or a reader of the log that has gone, must not do to the others: hold up the planner, its signs of life,
its answers to them, or its end. SSV_LONG=1 floods for longer."""

import os
import signal
import subprocess
import threading
import time
import unittest

import lcm

import ssv
from test_askers import BIN, LONG, Bus, scenario, task

FLOOD_PER_S = 10_000
FLOOD_S = 20 if LONG else 6


def slow(plan_json):
    """The dearest question that there is: effort best, anywhere, eight heights, every candidate, the front."""
    q = scenario(plan_json, 11, 1)
    q.options.effort = ssv.options_t.EFFORT_BEST
    q.options.attach_anywhere = q.options.want_candidates = q.options.want_front = True
    q.options.num_attach_heights = 8
    q.options.attach_heights_m = [-1.5, -1, -0.6, -0.2, 0.2, 0.6, 1, 1.5]
    q.contact = 0
    return q


class Floods(Bus):
    def test_a_long_question_holds_up_neither_the_sign_of_life_nor_another_asker_nor_the_end(self):
        daemon = self.planner("fixed")
        bus = lcm.LCM(self.url)
        beats = []
        bus.subscribe("SSV_PLANNER_STATUS", lambda _channel, data: beats.append((time.monotonic(), ssv.planner_status_t.decode(data))))
        while not beats:
            bus.handle_timeout(2000)
        for number in range(12):  # minutes of work, of one asker
            q = slow(self.here)
            q.asker.request_id, q.weight_time_per_s = number + 1, 1 + number / 100
            bus.publish("SSV_SCENARIO", task(q).encode())
        waits = []
        for number in range(6):
            start = time.monotonic()
            answer = self.ask(scenario(self.here, 12, number + 1), bus)
            waits.append(time.monotonic() - start)
            self.assertEqual(answer.quote.status, ssv.quote_t.STATUS_OK)
            time.sleep(0.5)
        end = time.monotonic() + 2
        while time.monotonic() < end:
            bus.handle_timeout(200)
        self.assertGreater(beats[-1][1].waiting, 0, "the long questions are done: they were to be at work still")
        gaps = [b[1].uptime_us - a[1].uptime_us for a, b in zip(beats, beats[1:])]
        print(f"another asker waited {max(waits):.3f} s at most; status every {min(gaps) / 1e6:.3f} to {max(gaps) / 1e6:.3f} s")
        self.assertLess(max(waits), 1)
        self.assertLess(max(gaps), 1_100_000)  # due once a second; a turn takes up to 50 ms
        start = time.monotonic()
        daemon.send_signal(signal.SIGTERM)
        daemon.wait(5)
        print(f"SIGTERM took {time.monotonic() - start:.3f} s")
        self.assertLess(time.monotonic() - start, 0.5)

    def test_a_flood_of_one_asker_delays_nobody_else(self):
        self.planner()
        stop = threading.Event()
        flooder = lcm.LCM(self.url)
        sent = 0

        def flood():
            nonlocal sent
            q = scenario(self.here, 13, 0)
            start = time.monotonic()
            while not stop.is_set() and time.monotonic() - start < 60:
                due = int((time.monotonic() - start) * FLOOD_PER_S)
                for _ in range(max(0, min(due - sent, 500))):
                    q.asker.request_id += 1
                    flooder.publish("SSV_SCENARIO", task(q).encode())
                    sent += 1
                time.sleep(0.002)

        thread = threading.Thread(target=flood)
        bus = lcm.LCM(self.url)
        self.ask(scenario(self.here, 14, 1), bus)  # the planner is there
        thread.start()
        started, waits = time.monotonic(), []
        for number in range(20):
            start = time.monotonic()
            answer = self.ask(scenario(self.here, 14, number + 2), bus)
            waits.append(time.monotonic() - start)
            self.assertEqual(answer.quote.status, ssv.quote_t.STATUS_OK)
            time.sleep(FLOOD_S / 20)
        stop.set()
        thread.join()
        rate = sent / (time.monotonic() - started)
        print(f"20 of 20 answered, {max(waits):.3f} s at most, beside {rate:.0f} questions a second")
        self.assertLess(max(waits), 1)

    def test_a_log_that_nobody_reads_costs_lines_and_no_answer(self):
        log, end_of_log = os.pipe()  # never read
        daemon = subprocess.Popen([BIN / "ssv-plannerd", "--lcm-url", self.url], stdout=subprocess.DEVNULL, stderr=end_of_log)
        self.addCleanup(daemon.kill)
        bus = lcm.LCM(self.url)
        beats = []
        bus.subscribe("SSV_PLANNER_STATUS", lambda _channel, data: beats.append(ssv.planner_status_t.decode(data)))
        for number in range(1200):  # some 100 bytes a line fill a pipe of 64 kB
            q = scenario(self.here, 15, number + 1)
            q.standoff_m = -1  # refused, which is soon done and is told at length
            self.assertEqual(self.ask(q, bus).quote.status, ssv.quote_t.STATUS_INVALID)
        seen = len(beats)
        while len(beats) == seen:
            bus.handle_timeout(2000)
        self.assertGreater(beats[-1].log_lines_lost, 0)
        daemon.send_signal(signal.SIGTERM)
        self.assertEqual(daemon.wait(5), 0)
        os.close(log)
        os.close(end_of_log)


if __name__ == "__main__":
    unittest.main(verbosity=2)

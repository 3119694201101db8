"""The demo behind demo.sh: asks a planner of its own over LCM for the paper's case study, prints the paper's tables beside
what comes back by the paper's method, and what method optimal saves. Then flies it in simulation, in rough water, and writes the
flight as a page.

    python3 demo.py BIN_FOLDER PAGE.html

Exit codes: 0 every plan arrived and the flight docked, 1 one did not.
"""

import csv
import ctypes
import functools
import json
import math
import os
import re
import signal
import string
import subprocess
import sys
import tempfile
import textwrap
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SCENARIO = ROOT / "host/scenarios/paper_case.yaml"
CLEAR_SCENARIO = ROOT / "host/scenarios/clear/paper_case.yaml"
PAPER_TABLES = ROOT / "tests/golden/paper_tables.csv"
ATTACHMENTS = {"1": 1.524, "2": 0.0, "3": -1.524}  # the paper's number of the attachment: height along the beam [m]
TIME, FUEL, BOTH = "1,0", "0,1", "1,1"  # weights; the paper's tables are for full thrust, as time alone asks for
PAPER, OPTIMAL = ("--method", "paper"), ("--method", "optimal", "--effort", "best")
LOG_PATIENCE_S = 2
NOTE_ABOVE = 0.002  # a larger difference gets its reason
TITLES = {
    "5": "Table 5: the vehicle flies to the beam",
    "6": "Table 6: the vehicle carries the beam to the hub",
    "7": "Table 7: all of it",
}


class Failed(Exception):
    """What went wrong, for the person at the terminal."""


def end_with(parent_pid, number):
    """Has the kernel send this process a signal when its parent ends, however it ends."""
    pr_set_pdeathsig = 1
    ctypes.CDLL(None).prctl(pr_set_pdeathsig, number)
    if os.getppid() != parent_pid:  # it ended before the kernel knew
        os._exit(1)


# For subprocess: what every process that the demo starts does first.
end_with_demo = functools.partial(end_with, os.getpid(), signal.SIGKILL)


class Planner:
    """A running ssv-plannerd; leaving the `with` block stops it. Its log has no name, so nothing remains of it."""

    def __init__(self, bin_dir):
        self._program = bin_dir / "ssv-plannerd"

    def __enter__(self):
        self._log = tempfile.TemporaryFile()
        self._process = subprocess.Popen(
            [self._program],
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=self._log,
            preexec_fn=end_with_demo,
        )
        return self

    def __exit__(self, *_):
        self._process.terminate()
        try:
            self._process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._log.close()

    def log(self):
        return os.pread(self._log.fileno(), 1 << 20, 0).decode(errors="replace")


def ask(bin_dir, scenario, method, weights):
    """The plan, as the planner gave it over LCM."""
    command = [bin_dir / "ssv", "plan", "-", "--lcm", "--format", "json", *method, "--weights", weights]
    done = subprocess.run(command, input=scenario, capture_output=True, text=True, preexec_fn=end_with_demo)
    if done.returncode != 0:
        raise Failed(f"No plan by method {method[1]} with weights {weights}.\n{done.stderr}")
    return json.loads(done.stdout)


def one_attachment(number):
    """The case study for one of the paper's attachments."""
    return SCENARIO.read_text() + f"attach_heights_m: [{ATTACHMENTS[number]}]\n"


def every_side():
    """The case study for all attachments, with the side of the beam left to the planner."""
    return re.sub(r"(?m)^ring_angle_rad:.*\n", "", SCENARIO.read_text())


def for_rough_water():
    """The case study with a beam of a real tube's inertia, which the paper's is not, and force to push back with."""
    return re.sub(r"(?m)^model:.*$", "model: ease", every_side()) + "thrust_reserve: 0.2\n"


def rotation(q_start, q_end):
    """Angle [rad] and axis in I of the turn from one attitude to another: q_end = q_turn q_start."""
    w1, x1, y1, z1 = q_end
    w2, x2, y2, z2 = q_start[0], -q_start[1], -q_start[2], -q_start[3]
    w = w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2
    axis = [
        w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
        w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
        w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
    ]
    norm = math.hypot(*axis)
    sign = -1 if w < 0 else 1
    return 2 * math.atan2(norm, sign * w), [sign * a / norm for a in axis]


def pair_centre(scenario, p_vehicle, p_beam):
    m_vehicle, m_beam = scenario["vehicle"]["body"]["mass_kg"], scenario["beam"]["body"]["mass_kg"]
    return [(m_vehicle * a + m_beam * b) / (m_vehicle + m_beam) for a, b in zip(p_vehicle, p_beam)]


def peak_thrust(plan, leg, thrusters):
    """Largest sum of absolute thrusts [N] of these thrusters during a leg."""
    segments = [s for s in plan["segments"] if s["leg"] == leg]
    return max(sum(abs(s[end][i]) for i in thrusters) for s in segments for end in ("u_start_N", "u_end_N"))


def our_values(answer):
    """Our number for each (table, row) of the paper; rows that have none of ours are left out."""
    scenario, plan = answer["scenario"], answer["plan"]
    fly, turn, pair_turn, pair_fly = plan["legs"]
    # In both flights body x lies along x_I and body y along y_I, so these thrusters push along them.
    along_x, along_y, every = (0, 1), (2, 3), range(6)
    start = pair_centre(scenario, pair_turn["X_IS_start"]["p_m"], scenario["X_IB"]["p_m"])
    end = pair_centre(scenario, plan["quote"]["X_IS_final"]["p_m"], plan["quote"]["X_IB_final"]["p_m"])
    turn_angle, turn_axis = rotation(turn["X_IS_start"]["q"], turn["X_IS_end"]["q"])
    pair_angle, pair_axis = rotation(pair_turn["X_IS_start"]["q"], pair_turn["X_IS_end"]["q"])
    return {
        ("5", "translation to beam, x"): fly["X_IS_end"]["p_m"][0],
        ("5", "translation to beam, y"): fly["X_IS_end"]["p_m"][1],
        ("5", "rotation to beam, angle"): turn_angle,
        ("5", "rotation to beam, axis z"): turn_axis[2],
        ("5", "time of translation, x"): fly["duration_s"],
        ("5", "thrust of translation, x"): peak_thrust(plan, 0, along_x),
        ("5", "thrust of translation, y"): peak_thrust(plan, 0, along_y),
        ("5", "time of rotation"): turn["duration_s"],
        ("5", "thrust of rotation"): peak_thrust(plan, 1, every),
        ("6", "centre of the pair, x"): start[0],
        ("6", "centre of the pair, y"): start[1],
        ("6", "rotation to hub, angle"): pair_angle,
        ("6", "rotation to hub, axis z"): pair_axis[2],
        ("6", "translation to hub, x"): end[0] - start[0],
        ("6", "translation to hub, y"): end[1] - start[1],
        ("6", "time of rotation"): pair_turn["duration_s"],
        ("6", "thrust of rotation"): peak_thrust(plan, 2, every),
        ("6", "thrust of translation, x"): peak_thrust(plan, 3, along_x),
        ("6", "time of translation, y"): pair_fly["duration_s"],
        ("6", "thrust of translation, y"): peak_thrust(plan, 3, along_y),
        ("7", "time of translation, SSV"): fly["duration_s"],
        ("7", "fuel of translation, SSV"): fly["impulse_Ns"],
        ("7", "time of rotation, SSV"): turn["duration_s"],
        ("7", "fuel of rotation, SSV"): turn["impulse_Ns"],
        ("7", "time of rotation, pair"): pair_turn["duration_s"],
        ("7", "fuel of rotation, pair"): pair_turn["impulse_Ns"],
        ("7", "time of translation, pair"): pair_fly["duration_s"],
        ("7", "fuel of translation, pair"): pair_fly["impulse_Ns"],
        ("7", "total time"): plan["quote"]["time_s"],
        ("7", "total fuel"): plan["quote"]["impulse_Ns"],
    }


class Notes:
    """Gives each reason a letter, in the order in which they come up."""

    def __init__(self):
        self._reasons = []

    def letter(self, reason):
        if reason not in self._reasons:
            self._reasons.append(reason)
        return string.ascii_lowercase[self._reasons.index(reason)]

    def lines(self):
        for letter, reason in zip(string.ascii_lowercase, self._reasons):
            yield from textwrap.wrap(reason, 116, initial_indent=f"{letter}  ", subsequent_indent="   ")


def number(value):
    return f"{value:8.4f}" if abs(value) < 1000 else f"{value:8.1f}"


def cell(row, ours, notes):
    """28 columns: the paper's value, ours, their difference, and the letter of its reason."""
    paper = float(row["paper_value"])
    if ours is None:
        return f"{number(paper)} {'-':>8} {'':8} {notes.letter(row['reason'])}"
    difference = (ours - paper) / abs(paper)
    note = notes.letter(row["reason"]) if abs(difference) > NOTE_ABOVE else ""
    percent = round(100 * difference, 2) + 0.0  # no -0.00
    return f"{number(paper)} {number(ours)} {percent:+7.2f}% {note:1}"


def print_tables(plans, paper_rows):
    notes = Notes()
    ours = {attachment: our_values(plan) for attachment, plan in plans.items()}
    columns = f"{'paper':>8} {'ours':>8} {'diff':>8}  "
    for table, title in TITLES.items():
        headings = [f"attachment {a} ({h:+.3f} m)".center(28) for a, h in ATTACHMENTS.items()]
        print(f"\n{title}")
        print(f"{'':32}{' '.join(headings)}".rstrip())
        print(f"{'':32}{' '.join(3 * [columns])}".rstrip())
        rows = [row for row in paper_rows if row["table"] == table]
        for name in dict.fromkeys(row["row"] for row in rows):
            of_name = {row["attachment"]: row for row in rows if row["row"] == name}
            cells = [cell(of_name[a], ours[a].get((table, name)), notes) for a in ATTACHMENTS]
            print(f"{name + ' [' + of_name['1']['unit'] + ']':32}{' '.join(cells)}".rstrip())
    print("\nWhy they differ by more than 0.2 %:")
    print("\n".join(notes.lines()))


def print_winners(plans, paper_rows):
    print(f"\n{'Best attachment':30}{'paper':30}ours")
    for goal, weights, row_name, key, unit in (
        ("for time (weights 1, 0)", TIME, "total time", "time_s", "s"),
        ("for fuel (weights 0, 1)", FUEL, "total fuel", "impulse_Ns", "N s"),
    ):
        rows = [row for row in paper_rows if (row["table"], row["row"]) == ("7", row_name)]
        of_paper = {row["attachment"]: float(row["paper_value"]) for row in rows}
        of_ours = {a: plans[weights][a]["plan"]["quote"][key] for a in ATTACHMENTS}
        best = [min(values, key=values.get) for values in (of_paper, of_ours)]
        cells = [f"{a} ({values[a]:.1f} {unit})" for a, values in zip(best, (of_paper, of_ours))]
        print(f"{goal:30}{cells[0]:30}{cells[1]}")
    print("The paper's fuel is that of full-thrust ramps; ours with weights 0, 1 lets drag slow the vehicle.")


def print_gain(paper, optimal):
    print("\nWhat method optimal saves, all attachments compared, the side of the beam and everything else left to it")
    print(f"{'':30}{'paper: J':>12}{'optimal: J':>12}{'saving':>10}{'no plan below':>16}")
    for goal, weights in (
        ("time alone (weights 1, 0)", TIME),
        ("fuel alone (weights 0, 1)", FUEL),
        ("both (weights 1, 1)", BOTH),
    ):
        before, after = (plans[weights]["plan"]["quote"] for plans in (paper, optimal))
        saving = f"{100 * (1 - after['cost'] / before['cost']):.2f} %"
        print(f"{goal:30}{before['cost']:12.2f}{after['cost']:12.2f}{saving:>10}{after['cost_lower_bound']:16.2f}")


def print_clearance(plans):
    print("\nThe same task where nothing may be touched: 3 cm away from the beam, and straight at beam and port over the last 15 cm")
    print(f"{'':30}{'J':>12}{'keeps clear by':>18}")
    for method, plan in plans.items():
        clearance_mm = 1e3 * plan["plan"]["clearance"]["certified_m"]
        print(f"{method:30}{plan['plan']['quote']['cost']:12.2f}{clearance_mm:15.1f} mm")
    print("The plans above keep clear of nothing, as the paper's own: they pass through the beam itself.")


def print_effort(what, plans, planner):
    """Length of the timelines, and what the planner's log says of the time to plan. Another planner on the bus may have
    answered before it has, or in place of it."""
    deadline = time.monotonic() + LOG_PATIENCE_S
    lengths = [plan["plan"]["num_segments"] for plan in plans]
    asked = {plan["plan"]["answer"]["asker"]["request_id"] for plan in plans}
    times_ms = {}
    while len(times_ms) < len(asked) and time.monotonic() < deadline:
        lines = re.findall(r"scenario (\w+): ok,.* planned in ([\d.]+) ms", planner.log())
        times_ms = {request: float(ms) for request, ms in lines if request in asked}
        time.sleep(0.05)
    if not times_ms:
        raise Failed("The planner's log tells of none of these plans.")
    print(f"{len(plans)} plans {what} received over LCM: {min(lengths)} to {max(lengths)} thrust segments each, "
          f"planned in {min(times_ms.values()):.4g} to {max(times_ms.values()):.4g} ms.")


def print_flight(bin_dir):
    """The last act: a planner and a simulated vehicle of its own, which `ssv fly` starts and ends."""
    command = [bin_dir / "ssv", "fly", "-", "--sim", "--conditions", "rough"]
    done = subprocess.run(command, input=for_rough_water(), capture_output=True, text=True, preexec_fn=end_with_demo)
    if done.returncode != 0:
        raise Failed(f"The flight did not dock.\n{done.stderr}{done.stdout}")
    print("\nThe case study flown, with model ease: over a vehicle link, by the vehicle's own controller, in simulated rough water")
    print("(a current of half a centimetre per second that wanders, thrusters off by 5 % and 0.2 s late, noise of 5 mm and 0.5 deg)")
    print(done.stdout.split("\n", 1)[1].rstrip())


def write_page(bin_dir, page):
    """The same flight once more, for it is the same to the last bit, as a page that opens in any browser."""
    fly = [bin_dir / "ssv", "fly", "-", "--sim", "--conditions", "rough", "--format", "json"]
    flight = subprocess.run(fly, input=for_rough_water(), capture_output=True, text=True, preexec_fn=end_with_demo)
    report = [bin_dir / "ssv", "report", "-", "--output", page]
    done = subprocess.run(report, input=flight.stdout, capture_output=True, text=True, preexec_fn=end_with_demo)
    if done.returncode != 0:
        raise Failed(f"The page of the flight could not be written.\n{flight.stderr}{done.stderr}")
    print(f"\nSee it fly, in any browser: {page}")


def run(bin_dir, page):
    with PAPER_TABLES.open() as file:
        paper_rows = list(csv.DictReader(file))
    with Planner(bin_dir) as planner:
        try:
            plans = {
                weights: {a: ask(bin_dir, one_attachment(a), PAPER, weights) for a in ATTACHMENTS}
                for weights in (TIME, FUEL)
            }
            paper = {weights: ask(bin_dir, SCENARIO.read_text(), PAPER, weights) for weights in (TIME, FUEL, BOTH)}
            optimal = {weights: ask(bin_dir, every_side(), OPTIMAL, weights) for weights in (TIME, FUEL, BOTH)}
            clear = {"paper's method": ask(bin_dir, CLEAR_SCENARIO.read_text(), PAPER, BOTH),
                     "method optimal": ask(bin_dir, CLEAR_SCENARIO.read_text(), OPTIMAL, BOTH)}
            print("The paper's case study by the paper's method, planned by ssv-plannerd over LCM for each of its three attachments.")
            print_tables(plans[TIME], paper_rows)
            print_winners(plans, paper_rows)
            print_gain(paper, optimal)
            print_clearance(clear)
            by_paper = [plan for of_weights in (*plans.values(), paper) for plan in of_weights.values()]
            print()
            print_effort("by the paper's method", by_paper, planner)
            print_effort("by method optimal, effort best,", list(optimal.values()), planner)
            print_flight(bin_dir)
            write_page(bin_dir, page)
        except Failed as failure:
            raise Failed(f"{failure}\nThe log of ssv-plannerd:\n{planner.log()}") from failure


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    end_with(os.getppid(), signal.SIGTERM)
    # As an exception, a signal unwinds through the `with` block that stops the planner.
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, _: sys.exit(128 + number))
    try:
        run(Path(sys.argv[1]), Path(sys.argv[2]))
    except Failed as failure:
        sys.exit(str(failure))
    except KeyboardInterrupt:
        sys.exit(128 + signal.SIGINT)


if __name__ == "__main__":
    main()

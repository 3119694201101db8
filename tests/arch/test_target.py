"""The planner on bare Cortex-M cores, emulated: it plans the shipped scenarios and random tasks, fixed point gives the same
bits there as here, and what it takes stays within tests/bench/budgets.csv. -V shows the figures; SSV_REFRESH_BUDGETS=1 has
them written to that file.
"""
import concurrent.futures
import csv
import json
import os
import re
import shutil
import sys
import unittest

import onboard
import target
from core import ROOT, run

NEEDED = ("arm-none-eabi-gcc", "qemu-system-arm")
IMAGES = [("m3", "fixed"), ("m4f", "fixed"), ("m4f", "float"), ("m7", "fixed"), ("m7", "float"), ("m7", "double")]
API = ["ssv_problem_init", "ssv_plan", "ssv_quote", "ssv_front", "ssv_lower_bound", "ssv_plan_arrival", "ssv_plan_sample"]
# How far J may be from that of the double build on this machine, relative.
COST_TOLERANCE = {"double": 1e-6, "fixed": 1e-4, "float": 1e-3}
LONGEST_INTERRUPT = 128  # bytes of stack: what the core saves, and the tick's handler
MOST_ARGUMENTS = 24  # bytes: arguments that a function saves itself; the compiler does not count them as its frame

BUDGETS = ROOT / "tests/bench/budgets.csv"
COLUMNS = ["core", "scalar", "what", "figure", "budget"]
MARGIN = 0.05
ONBOARD = {("m4f", scalar, onboard.ALL): scalar for scalar in ("fixed", "float")}
# What the project has set itself; held with the compiler of the budgets.
GOALS = {("m3", "fixed", "16_obstacles optimal", "instructions"): 80_000_000,
         ("m3", "fixed", "planner", "text_bytes"): 128 * 1024,
         ("m3", "fixed", "planner", "static_ram_bytes"): 64 * 1024,
         **{("m3", "fixed", name, "stack_bytes"): 8 * 1024 for name in API},
         ("m3", "fixed", "paper_case optimal", "instructions"): 60_000_000,
         ("m7", "float", "paper_case optimal", "instructions"): 10_000_000,
         **{(*key, "text_bytes"): 48 * 1024 for key in ONBOARD},
         **{(*key, "ram_bytes"): 32 * 1024 for key in ONBOARD}}


def compiler():
    return run(["arm-none-eabi-gcc", "--version"]).splitlines()[0]


class Image:
    """An image, what it has printed, and what it takes."""

    def __init__(self, cpu, scalar):
        self.cpu, self.scalar = cpu, scalar
        folder = target.build(cpu, scalar)
        self.folder, self.archive, self.file = folder, folder / "firmware/libssv_planner.a", folder / "bin/plan.elf"
        lines, self.exit_code = target.emulate(cpu, self.file)
        self.plans = target.planned(lines)
        functions = target.disassembled(self.file)
        self.stacks = {name: target.deepest(functions, f"{name}_{scalar}") for name in API}

    def figures(self):
        """{(core, scalar, what, figure): number}, all that has a budget."""
        text, data, bss = target.sections(self.archive)
        sizes = target.symbols(self.file)
        found = {("planner", "text_bytes"): text,
                 ("planner", "static_ram_bytes"): data + bss + sizes["problem"] + sizes["work"] + sizes["plan"]}
        for name, (depth, _) in self.stacks.items():
            found[name, "stack_bytes"] = depth
        for (name, method), row in self.plans.items():
            if not is_random(name) and row["status"] == "ok":
                found[f"{name} {method}", "instructions"] = int(row["instructions"])
        for method in ("optimal", "paper"):
            found[f"random {method}", "most_instructions"] = max(
                int(row["instructions"]) for (name, of), row in self.plans.items() if is_random(name) and of == method)
        return {(self.cpu, self.scalar, *key): number for key, number in found.items()}


OF_NO_FILE = "16_obstacles"  # a task that plan.c makes


def is_random(name):
    return name.startswith("random_")


def read_budgets():
    """{(core, scalar, what, figure): budget}, and the compiler that they are for."""
    with open(BUDGETS, encoding="utf-8", newline="") as file:
        of = file.readline().removeprefix("# ").strip()
        return {tuple(row[name] for name in COLUMNS[:4]): int(row["budget"]) for row in csv.DictReader(file)}, of


def write_budgets(figures):
    with open(BUDGETS, "w", encoding="utf-8", newline="") as file:
        file.write(f"# {compiler()}\n")
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(COLUMNS)
        rows.writerows([*key, number] for key, number in figures.items())


def breaches(figures, budgets):
    """Sentences: figures that are more than MARGIN over their budgets, and budgets and figures without the other."""
    found = []
    for key in {**budgets, **figures}:
        name = ",".join(key)
        if key not in budgets:
            found.append(f"{name}: {figures[key]} has no budget")
        elif key not in figures:
            found.append(f"{name}: a budget of what is no more")
        elif figures[key] > budgets[key] * (1 + MARGIN):
            growth = figures[key] / budgets[key] - 1
            found.append(f"{name}: {figures[key]} is {growth:.1%} over its budget of {budgets[key]}")
    return found


class Target(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            images = {key: pool.submit(Image, *key) for key in IMAGES}
            here = {scalar: pool.submit(target.run_here, "plan", scalar) for scalar in ("double", "fixed")}
            cls.images = {key: future.result() for key, future in images.items()}
            cls.here = {scalar: target.planned(future.result()[0]) for scalar, future in here.items()}
        cls.figures = {key: number for image in cls.images.values() for key, number in image.figures().items()}
        for key, scalar in ONBOARD.items():
            found = onboard.measure(onboard.ALL, scalar)
            for figure in ("text_bytes", "image_text_bytes", "ram_bytes", "stack_bytes"):
                cls.figures[*key, figure] = getattr(found, figure)

    def test_every_core_plans_the_shipped_scenarios_and_random_tasks_at_the_price_of_the_double_build_here(self):
        for (cpu, scalar), image in self.images.items():
            print(f"Cortex-{cpu}, {scalar}: scenario, method, status, J, plan hash, instructions, bytes of stack")
            for key, row in image.plans.items():
                if not is_random(row["name"]):
                    print(" ", *row.values())
                with self.subTest(cpu=cpu, scalar=scalar, plan=key):
                    here = self.here["double"][key]
                    self.assertEqual(row["status"], here["status"] if is_random(row["name"]) else "ok")
                    cost = float(here["cost"])
                    self.assertAlmostEqual(float(row["cost"]), cost, delta=COST_TOLERANCE[scalar] * cost)
            with self.subTest(cpu=cpu, scalar=scalar):
                self.assertEqual(image.exit_code, 0)

    def test_fixed_point_gives_the_plans_of_this_machine_to_the_last_bit_on_every_core(self):
        here = self.here["fixed"]
        self.assertGreaterEqual(sum(is_random(name) and row["status"] == "ok" for (name, _), row in here.items()), 50)
        for (cpu, scalar), image in self.images.items():
            if scalar == "fixed":
                with self.subTest(cpu=cpu):
                    self.assertEqual(image.plans.keys(), here.keys())
                    differing = [key for key, row in image.plans.items()
                                 if any(row[field] != here[key][field] for field in ("status", "cost", "hash"))]
                    self.assertEqual(differing, [])

    def test_the_command_line_makes_the_same_plans_of_the_scenario_files(self):
        for scalar, plans in self.here.items():
            for (name, method), row in plans.items():
                if not is_random(name) and name != OF_NO_FILE:
                    with self.subTest(scalar=scalar, name=name, method=method):
                        answer = run([f"{os.environ['SSV_BIN_DIR']}/ssv", "plan", ROOT / f"host/scenarios/{name}.yaml",
                                      "--scalar", scalar, "--method", method, "--effort", "quick", "--format", "json"])
                        self.assertEqual(json.loads(answer)["plan"]["plan_hash"], row["hash"])

    def test_nothing_takes_more_than_its_budget(self):
        for key, goal in GOALS.items():
            number = self.figures[key]
            print(f"goal {','.join(key)}: {number} of {goal}, {'met' if number <= goal else 'missed'}")
        for (cpu, scalar), image in self.images.items():
            depth, path = image.stacks["ssv_plan"]
            print(f"Cortex-{cpu}, {scalar}: {depth} bytes of stack: {' > '.join(path)}")
        if os.environ.get("SSV_REFRESH_BUDGETS"):
            write_budgets(self.figures)
        budgets, of = read_budgets()
        if of != compiler():
            self.skipTest(f"the budgets are for {of}, this is {compiler()}")
        self.assertEqual([",".join(key) for key, goal in GOALS.items() if self.figures[key] > goal], [])
        found = breaches(self.figures, budgets)
        self.assertEqual(found, [], "\n".join([
            "", *found, "If that is the price of something worth it, SSV_REFRESH_BUDGETS=1 bash tests/run.sh -R arch.target "
            f"writes the new figures to {BUDGETS.relative_to(ROOT)}"]))

    def test_a_figure_that_grew_by_more_than_a_twentieth_is_told_with_its_row(self):
        key = ("m3", "fixed", "planner", "text_bytes")
        self.assertEqual(breaches({key: 1050}, {key: 1000}), [])
        self.assertEqual(breaches({key: 1051}, {key: 1000}),
                         ["m3,fixed,planner,text_bytes: 1051 is 5.1% over its budget of 1000"])
        self.assertEqual(len(breaches({key: 1}, {})), 1)
        self.assertEqual(len(breaches({}, {key: 1})), 1)

    def test_no_plan_goes_deeper_into_the_stack_than_the_call_graph_says(self):
        for (cpu, scalar), image in self.images.items():
            with self.subTest(cpu=cpu, scalar=scalar):
                measured = max(int(row["stack_bytes"]) for row in image.plans.values())
                self.assertLessEqual(measured, image.stacks["ssv_plan"][0] + LONGEST_INTERRUPT)
                self.assertGreater(measured, image.stacks["ssv_plan"][0] / 2)

    def test_no_frame_is_smaller_than_the_compiler_says(self):
        for (cpu, scalar), image in self.images.items():
            with self.subTest(cpu=cpu, scalar=scalar):
                frames, compared = target.compilers_frames(image.folder), 0
                for function in target.disassembled(image.file).values():
                    if len(frames.get(function.name, [])) == 1:
                        compared += 1
                        expected = frames[function.name][0]
                        self.assertGreaterEqual(function.frame_bytes, expected, function.name)
                        self.assertLessEqual(function.frame_bytes, expected + MOST_ARGUMENTS, function.name)
                self.assertGreater(compared, 80)

    def test_fixed_arithmetic_gives_the_same_bits_on_a_core_without_floating_point(self):
        lines, _ = target.emulate("m3", self.images["m3", "fixed"].folder / "bin/arithmetic.elf")
        print("Cortex-m3, fixed: operation, hash, mean and most instructions of a call", *lines, sep="\n  ")
        here, _ = target.run_here("arithmetic", "fixed")
        self.assertEqual([line.split()[:2] for line in lines], [line.split()[:2] for line in here])

    def test_a_flight_to_the_mate_gives_the_same_commands_to_the_last_bit_as_here(self):
        here = target.run_here("fly", "fixed", ("link", "vehicle", "guidance"))
        print("fixed: steps of guidance, phase, hash of all efforts, thrusts and trims", *here[0], sep="\n  ")
        self.assertEqual(here[1], 0)
        self.assertGreater(len(here[0]), 10)
        for (cpu, scalar), image in self.images.items():
            if scalar == "fixed":
                with self.subTest(cpu=cpu):
                    self.assertEqual(target.emulate(cpu, image.folder / "bin/fly.elf"), here)

    def test_no_archive_needs_a_heap_and_a_fixed_one_no_floating_point_either(self):
        heap = r"(m|c|re)alloc|free|_sbrk"
        floating = r"__aeabi_([fd]|\w+2[fd])|(a?sin|a?cos|a?tan|sqrt|log|exp|ldexp|pow|fabs)"
        for (cpu, scalar), image in self.images.items():
            with self.subTest(cpu=cpu, scalar=scalar):
                undefined = set(re.findall(r"\bU (\w+)", run(["arm-none-eabi-nm", "-u", image.archive])))
                self.assertIn("memset", undefined)
                unwanted = f"{heap}|{floating}" if scalar == "fixed" else heap
                self.assertEqual([name for name in sorted(undefined) if re.match(unwanted, name)], [])

    def test_a_fault_ends_the_emulator_with_its_own_exit_code(self):
        folder = self.images["m3", "fixed"].folder
        source = folder / "fault.c"
        source.write_text("int main(void) { return *(volatile int*)0x90000000; }\n")
        run(["arm-none-eabi-gcc", "-mcpu=cortex-m3", "-mthumb", source, ROOT / "firmware/target/board.c",
             "--specs=rdimon.specs", "-nostartfiles", f"-T{ROOT}/firmware/target/mps2.ld", "-o", folder / "fault.elf"])
        self.assertEqual(target.emulate("m3", folder / "fault.elf"), ([], 70))


if __name__ == "__main__":
    missing = [program for program in NEEDED if not shutil.which(program)]
    if missing:
        print(f"Skipped: {' and '.join(missing)} not found. On Debian:\n"
              "  apt-get install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm")
        sys.exit(77)
    unittest.main()

"""Builds the tests of the labels unit and wire in a second tree, with AddressSanitizer, LeakSanitizer and
UndefinedBehaviorSanitizer, and runs them there. Only what these tests need is built, and the second time only what changed."""

import json
import os
import re
import subprocess
import unittest
from pathlib import Path

TREE = Path(os.environ["SSV_SANITIZE_DIR"])
LABELS = "^(unit|wire)$"
FLAGS = "-O1 -fno-omit-frame-pointer -fsanitize=address,undefined -fno-sanitize-recover=all"


def run(*command):
    done = subprocess.run([str(part) for part in command], text=True, errors="replace", stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))} failed\n{done.stdout[-8000:]}")
    return done.stdout


def ctest(*options):
    return run(os.environ["SSV_CTEST"], "--test-dir", TREE, "-L", LABELS, *options)


class Sanitize(unittest.TestCase):
    def test_unit_and_wire_tests_pass_under_sanitizers(self):
        run(os.environ["SSV_CMAKE"], "-S", os.environ["SSV_SOURCE_DIR"], "-B", TREE, "-G", "Ninja", "-C",
            os.environ["SSV_SANITIZE_OPTIONS"], "-DCMAKE_BUILD_TYPE=Debug", f"-DCMAKE_C_FLAGS={FLAGS}")
        tests = json.loads(ctest("--show-only=json-v1"))["tests"]
        # FOLDER.NAME is the program test_FOLDER_NAME; tests in Python have none and start what the first tree built.
        targets = set(re.findall(r"^(test_\w+):", run(os.environ["SSV_CMAKE"], "--build", TREE, "--target", "help"), re.M))
        programs = {test["name"]: "test_" + test["name"].replace(".", "_") for test in tests}
        programs = {name: target for name, target in programs.items() if target in targets}
        self.assertGreater(len(programs), 10, "too few tests are programs")
        run(os.environ["SSV_CMAKE"], "--build", TREE, "--target", *programs.values())
        os.environ["ASAN_OPTIONS"] = "detect_leaks=1:detect_stack_use_after_return=1"
        os.environ["UBSAN_OPTIONS"] = "print_stacktrace=1"
        names = "|".join(name.replace(".", "[.]") for name in programs)
        print(ctest("-R", f"^({names})$", "--output-on-failure", "--no-tests=error", "--parallel", "2"), flush=True)


if __name__ == "__main__":
    unittest.main(verbosity=2)
